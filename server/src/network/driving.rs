//! Players: claims and drive messages coming in, acknowledgements going out on a thread of their own, which also looks
//! who has fallen silent.

use super::NetworkError;
use super::answers::Answer;
use super::budget::Source;
use super::services::Gate;
use crate::players::{LOOK_EVERY, Players};
use protocol::codec;
use protocol::command::{CommandFault, Refusal, Reply, code};
use protocol::keys::{Keys, Role};
use protocol::player::{Claim, Claimed, Release};
use std::sync::Arc;
use std::time::Instant;
use zenoh::bytes::Encoding;
use zenoh::pubsub::Subscriber;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{Query, Queryable};
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

/// Declarations that live as long as this, and the thread that acknowledges.
pub struct Driving {
    _queryables: [Queryable<()>; 2],
    _subscribers: [Subscriber<()>; 2],
    players: Arc<Players>,
}

impl Drop for Driving {
    fn drop(&mut self) {
        self.players.close();
    }
}

impl Driving {
    /// Declares what players need.
    pub fn declare(session: &Session, keys: &Keys, gate: &Arc<Gate>) -> Result<Self, NetworkError> {
        let declared = Self {
            _queryables: [
                session.declare_queryable(keys.srv_claim()).callback(question(gate, claim)).wait()?,
                session.declare_queryable(keys.srv_release()).callback(question(gate, release)).wait()?,
            ],
            _subscribers: [drives(session, keys, gate)?, leavings(session, keys, gate)?],
            players: gate.players.clone(),
        };
        let (session, keys, gate) = (session.clone(), keys.clone(), gate.clone());
        let acknowledge = move || acknowledge(&session, &keys, &gate);
        std::thread::Builder::new().name("acknowledge".into()).spawn(acknowledge)?;
        Ok(declared)
    }
}

/// What is asked, once the budget allows it.
fn question(gate: &Arc<Gate>, ask: fn(&Arc<Gate>, Query, &[u8])) -> impl Fn(Query) + Send + Sync + 'static {
    let gate = gate.clone();
    move |query: Query| {
        let bytes = query.payload().map(|payload| payload.to_bytes().into_owned()).unwrap_or_default();
        match gate.spend(&Source::Commands) {
            Ok(()) => ask(&gate, query, &bytes),
            Err(why) => gate.reply(query, why.into()),
        }
    }
}

fn malformed(gate: &Gate, query: Query, why: &CommandFault) {
    let why = gate.refuse(code::MALFORMED, why.to_string());
    gate.reply(query, why.into());
}

fn claim(gate: &Arc<Gate>, query: Query, bytes: &[u8]) {
    match Claim::from_json(bytes) {
        Ok(claim) => {
            let way_back = gate.clone();
            let answer = move |claimed: Claimed| way_back.give(query, Answer::Claimed(claimed));
            gate.players.claim(claim, &gate.latest.stage(), Box::new(answer));
        }
        Err(why) => malformed(gate, query, &why),
    }
}

fn release(gate: &Arc<Gate>, query: Query, bytes: &[u8]) {
    match Release::from_json(bytes) {
        Ok(release) => {
            let way_back = gate.clone();
            let answer = move |reply: &Reply| way_back.reply(query, reply.clone());
            gate.players.release(&release, Box::new(answer));
        }
        Err(why) => malformed(gate, query, &why),
    }
}

fn drives(session: &Session, keys: &Keys, gate: &Arc<Gate>) -> Result<Subscriber<()>, NetworkError> {
    let (keys, gate) = (keys.clone(), gate.clone());
    let subscriber = session.declare_subscriber(keys.drive_of_anyone()).callback(move |sample| {
        let driven = match keys.driver_of(sample.key_expr().as_str()) {
            Some(player) if sample.kind() == SampleKind::Put => {
                gate.players.drive(&player, &sample.payload().to_bytes())
            }
            _ => Err(Refusal::new(code::MALFORMED, "no player of this name")),
        };
        if let Err(why) = driven {
            tracing::debug!("{} refused: {why}", sample.key_expr());
            gate.refuse(why.code, why.why);
        }
    });
    Ok(subscriber.wait()?)
}

fn leavings(session: &Session, keys: &Keys, gate: &Arc<Gate>) -> Result<Subscriber<()>, NetworkError> {
    let gate = gate.clone();
    let tokens = session.liveliness().declare_subscriber(keys.alive_all(Role::Player));
    let subscriber = tokens.callback(move |sample| {
        let id = sample.key_expr().as_str().rsplit('/').next().and_then(|id| id.parse().ok());
        if let (Some(player), SampleKind::Delete) = (id, sample.kind()) {
            gate.players.left(&player);
        }
    });
    Ok(subscriber.wait()?)
}

/// Publishes acknowledgements as they fall due, and looks now and then who is silent.
fn acknowledge(session: &Session, keys: &Keys, gate: &Gate) {
    let mut next_look = Instant::now() + LOOK_EVERY;
    while let Some(acks) = gate.players.acks(next_look) {
        for (player, ack) in acks {
            let put = session
                .put(keys.ack(&player), codec::encode_json(&ack))
                .encoding(Encoding::APPLICATION_JSON)
                .priority(Priority::InteractiveHigh)
                .congestion_control(CongestionControl::Drop)
                .express(true);
            if let Err(e) = put.wait() {
                tracing::debug!("{player} could not be told: {e}");
            }
        }
        let now = Instant::now();
        if now >= next_look {
            next_look = now + LOOK_EVERY;
            gate.players.look(|| gate.latest.stage());
        }
    }
}
