//! Commands and questions coming in. Callbacks run on Zenoh's receiving threads: they check, answer from what is
//! ready, or put the command into the inbox; none waits for the simulation.

use super::budget::Budget;
use super::{Latest, NetworkError};
use crate::inbox::{Answer, Inbox, Refused, Request};
use protocol::codec::{self, MAX_COMMAND_BYTES};
use protocol::command::{Command, Reply};
use protocol::keys::{Keys, Name};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use zenoh::bytes::{Encoding, ZBytes};
use zenoh::pubsub::Subscriber;
use zenoh::query::{Query, Queryable};
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

/// Declarations that live as long as this.
pub struct Services {
    _queryables: Vec<Queryable<()>>,
    _presses: Subscriber<()>,
}

impl Services {
    /// Declares the commands and the questions of an arena.
    pub fn declare(
        session: &Session,
        keys: &Keys,
        latest: &Arc<Latest>,
        inbox: &Arc<Inbox>,
    ) -> Result<Self, NetworkError> {
        let gate = Arc::new(Gate { inbox: inbox.clone(), budget: Mutex::default() });
        let mut queryables = vec![commands(session, &keys.srv_command(), gate.clone())?];
        let mut answer = |key: String, make: fn(&Latest, &Query) -> Result<Bytes, String>| {
            let latest = latest.clone();
            let declared =
                session.declare_queryable(key).callback(move |query| match make(&latest, &query) {
                    Ok((bytes, encoding)) => send(&query, bytes, encoding),
                    Err(why) => send_error(&query, &why),
                });
            declared.wait().map(|queryable| queryables.push(queryable))
        };
        answer(keys.srv_snapshot(), snapshot)?;
        answer(keys.srv_scene(), |latest, _| Ok(json(&*latest.scene)))?;
        answer(keys.srv_stats(), |latest, _| Ok(json(&latest.stats())))?;
        answer(keys.srv_info(), |latest, _| Ok(json(&latest.info)))?;
        let presses = presses(session, keys.clone(), gate)?;
        Ok(Self { _queryables: queryables, _presses: presses })
    }
}

type Bytes = (Vec<u8>, Encoding);

fn json<T: serde::Serialize>(value: &T) -> Bytes {
    (codec::encode_json(value), Encoding::APPLICATION_JSON)
}

fn snapshot(latest: &Latest, query: &Query) -> Result<Bytes, String> {
    match query.parameters().get("format") {
        None | Some("cbor") => Ok((codec::encode_world(&latest.world()), Encoding::APPLICATION_CBOR)),
        Some("json") => Ok(json(&latest.world())),
        Some(other) => Err(format!("format {other:?} is unknown: use cbor or json")),
    }
}

/// Commands that are answered: when done, at which tick; when not, why not.
fn commands(session: &Session, key: &str, gate: Arc<Gate>) -> Result<Queryable<()>, NetworkError> {
    // Questions do not say who asks; all of them share one budget.
    let asker: Name = "srv".parse().expect("a valid name");
    let callback = move |query: Query| {
        let empty = ZBytes::new();
        match gate.check(query.payload().unwrap_or(&empty), &asker) {
            Ok(command) => {
                let answer: Answer = Box::new(move |reply| send_reply(&query, reply));
                if let Err(Refused { request: Request { answer: Some(answer), .. }, why }) =
                    gate.offer(command, Some(answer))
                {
                    answer(&refusal(why.into()));
                }
            }
            Err(why) => send_reply(&query, &refusal(why)),
        }
    };
    Ok(session.declare_queryable(key.to_owned()).callback(callback).wait()?)
}

/// Commands that are not answered.
fn presses(session: &Session, keys: Keys, gate: Arc<Gate>) -> Result<Subscriber<()>, NetworkError> {
    let anyone = keys.cmd_of_anyone();
    let subscriber = session.declare_subscriber(anyone).callback(move |sample| {
        let command = match keys.player_of(sample.key_expr().as_str()) {
            Some(player) if sample.kind() == SampleKind::Put => gate.check(sample.payload(), &player),
            _ => gate.refuse("no player of this name".into()),
        };
        match command {
            Ok(command) => drop(gate.offer(command, None)),
            Err(why) => tracing::debug!("{} refused: {why}", sample.key_expr()),
        }
    });
    Ok(subscriber.wait()?)
}

/// What every command has to pass.
struct Gate {
    inbox: Arc<Inbox>,
    budget: Mutex<Budget>,
}

impl Gate {
    fn check(&self, payload: &ZBytes, source: &Name) -> Result<Command, String> {
        // The budget first: refusing must be cheap.
        if !self.budget.lock().unwrap_or_else(PoisonError::into_inner).allows(source, Instant::now()) {
            return self.refuse("too many commands: send at most 120 a second".into());
        }
        if payload.len() > MAX_COMMAND_BYTES {
            return self.refuse(format!("{} bytes are too many: at most {MAX_COMMAND_BYTES}", payload.len()));
        }
        codec::decode_command(&payload.to_bytes()).or_else(|e| self.refuse(e.to_string()))
    }

    fn refuse<T>(&self, why: String) -> Result<T, String> {
        self.inbox.count_refused();
        Err(why)
    }

    fn offer(&self, command: Command, answer: Option<Answer>) -> Result<(), Refused> {
        let offered = self.inbox.offer(Request { command, answer });
        if offered.is_err() {
            self.inbox.count_refused();
        }
        offered
    }
}

fn refusal(error: String) -> Reply {
    Reply { ok: false, tick: 0, epoch: 0, error }
}

fn send_reply(query: &Query, reply: &Reply) {
    send(query, codec::encode_json(reply), Encoding::APPLICATION_JSON);
}

fn send(query: &Query, bytes: Vec<u8>, encoding: Encoding) {
    if let Err(e) = query.reply(query.key_expr().clone(), bytes).encoding(encoding).wait() {
        tracing::debug!("{} could not be answered: {e}", query.key_expr());
    }
}

fn send_error(query: &Query, why: &str) {
    if let Err(e) = query.reply_err(why).encoding(Encoding::TEXT_PLAIN).wait() {
        tracing::debug!("{} could not be answered: {e}", query.key_expr());
    }
}
