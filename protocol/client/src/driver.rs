//! A claimed ball: commands go out again and again until the server has acknowledged them.

use crate::client::{Client, ClientError};
use crate::window::{Wanted, Window};
use protocol::codec;
use protocol::command::{Direction, Reply, SteerMode};
use protocol::keys::{Name, Role};
use protocol::player::{Ack, Acted, Claim, Grant, MAX_WINDOW, Release};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use zenoh::Wait;
use zenoh::bytes::Encoding;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::qos::{CongestionControl, Priority};

/// Time between two messages as long as something is not acknowledged.
const SEND_AGAIN: Duration = Duration::from_millis(50);
/// Time between two messages that say no more than that the player is there.
const HEARTBEAT: Duration = Duration::from_millis(200);
/// Least time between two messages: what comes in between goes together.
const SPACING: Duration = Duration::from_millis(5);
/// How long an orderly release may take.
const RELEASE_PATIENCE: Duration = Duration::from_secs(1);

/// Why a command was not taken.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DriveFault {
    /// The ball is another's, or nobody's.
    #[error("the ball is lost: {0}")]
    Lost(String),
    /// The server is behind, or far away.
    #[error("{MAX_WINDOW} commands wait for their acknowledgement: send fewer")]
    Full,
    /// It makes no sense.
    #[error(transparent)]
    Command(#[from] protocol::command::CommandFault),
}

/// A ball that is driven from here; it is given back when this is dropped.
pub struct Driver {
    client: Client,
    grant: Grant,
    shared: Arc<Shared>,
    sender: Option<JoinHandle<()>>,
    _acks: Subscriber<()>,
    /// Tells everybody that somebody plays; when the process dies, the server hears of it at once.
    _presence: LivelinessToken,
}

struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

struct State {
    window: Window,
    /// Something has not been sent yet.
    fresh: bool,
    ended: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait(state: MutexGuard<'_, State>, changed: &Condvar, until: Instant) -> bool {
        let left = until.saturating_duration_since(Instant::now());
        drop(changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner));
        left > Duration::ZERO
    }
}

impl Client {
    /// Claims a ball, the first free one of the players' balls without a name.
    pub fn claim(&self, player: &Name, ball: Option<&str>) -> Result<Driver, ClientError> {
        let claim = Claim { player: player.clone(), ball: ball.map(str::to_owned) };
        claim.check()?;
        let key = self.keys().srv_claim();
        let claimed: protocol::player::Claimed =
            codec::decode_json(&self.ask_with(&key, Some(&codec::encode_json(&claim)))?)?;
        if let Some(grant) = claimed.grant {
            return Driver::new(self.clone(), grant);
        }
        let Reply { code, error: why, .. } = claimed.reply;
        Err(ClientError::Refused { question: key, why, code })
    }
}

impl Driver {
    fn new(client: Client, grant: Grant) -> Result<Self, ClientError> {
        let window = Window::new(grant.token.clone(), grant.claim);
        let state = State { window, fresh: true, ended: false };
        let shared = Arc::new(Shared { state: Mutex::new(state), changed: Condvar::new() });
        let taker = shared.clone();
        let key = client.keys().ack(&grant.player);
        let acks =
            client.session().declare_subscriber(key).callback(move |sample| {
                match codec::decode_json::<Ack>(&sample.payload().to_bytes()) {
                    Ok(ack) => {
                        taker.lock().window.take(ack, Instant::now());
                        taker.changed.notify_all();
                    }
                    Err(e) => tracing::warn!("{} cannot be read: {e}", sample.key_expr()),
                }
            });
        let acks = acks.wait()?;
        let presence = client.announce(Role::Player, &grant.player)?;
        let publisher = client
            .session()
            .declare_publisher(client.keys().drive(&grant.player))
            .encoding(Encoding::APPLICATION_JSON)
            .priority(Priority::InteractiveHigh)
            .congestion_control(CongestionControl::Drop)
            .express(true)
            .wait()?;
        // As many rounds as fit into the lease without an answer, and the ball is another's.
        let most_unanswered = (grant.lease_s / SEND_AGAIN.as_secs_f64()).ceil() as u32;
        let source = shared.clone();
        let sender = std::thread::Builder::new().name("drive".into());
        let sender = sender
            .spawn(move || {
                send(&source, most_unanswered, |message| {
                    if let Err(e) = publisher.put(message).wait() {
                        tracing::debug!("not sent: {e}");
                    }
                });
            })
            .map_err(zenoh::Error::from)?;
        Ok(Self { client, grant, shared, sender: Some(sender), _acks: acks, _presence: presence })
    }

    /// Which ball.
    pub fn ball(&self) -> &str {
        &self.grant.ball
    }

    /// What was given.
    pub const fn grant(&self) -> &Grant {
        &self.grant
    }

    /// Pushes the ball once, or until told otherwise, at the next tick boundary. The command's number is its name in
    /// [`Driver::acked`].
    pub fn drive(&self, direction: Direction, mode: SteerMode) -> Result<u64, DriveFault> {
        self.drive_at(Wanted::default(), direction, mode)
    }

    /// The same at a tick, or at the next one when that is past.
    pub fn drive_at(&self, wanted: Wanted, direction: Direction, mode: SteerMode) -> Result<u64, DriveFault> {
        direction.check()?;
        let mut state = self.shared.lock();
        if let Some(why) = state.window.ended() {
            return Err(DriveFault::Lost(why.to_owned()));
        }
        let seq = state.window.push(wanted, direction, mode, Instant::now()).ok_or(DriveFault::Full)?;
        state.fresh = true;
        drop(state);
        self.shared.changed.notify_all();
        Ok(seq)
    }

    /// What became of commands since this was asked last, in order; of the last 1024 at most.
    pub fn acked(&self) -> Vec<Acted> {
        self.shared.lock().window.take_outcomes()
    }

    /// Waits until every command is acknowledged, or the ball is lost, or the time is over; whether nothing waits.
    pub fn settle(&self, timeout: Duration) -> bool {
        let deadline = Instant::now() + timeout;
        loop {
            let state = self.shared.lock();
            if state.window.waiting() == 0 || state.window.ended().is_some() {
                return state.window.waiting() == 0;
            }
            if !Shared::wait(state, &self.shared.changed, deadline) {
                return false;
            }
        }
    }

    /// Commands that are not acknowledged yet.
    pub fn waiting(&self) -> usize {
        self.shared.lock().window.waiting()
    }

    /// From the last acknowledged command to its acknowledgement.
    pub fn latency(&self) -> Option<Duration> {
        self.shared.lock().window.latency()
    }

    /// Why the ball is lost, if it is.
    pub fn lost(&self) -> Option<String> {
        self.shared.lock().window.ended().map(str::to_owned)
    }

    /// Gives the ball back and waits until it is free; dropping does the same.
    pub fn release(self) {}

    fn give_back(&self) {
        if self.lost().is_some() {
            return;
        }
        let release = Release { player: self.grant.player.clone(), token: self.grant.token.clone() };
        let key = self.client.keys().srv_release();
        let asked = self.client.ask_once_with(&key, Some(&codec::encode_json(&release)), RELEASE_PATIENCE);
        match asked {
            Ok(_) => self.shared.lock().window.end("released"),
            // Its silence frees it, a little later.
            Err(e) => tracing::debug!("{:?} was not released in order: {e}", self.grant.ball),
        }
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        self.give_back();
        self.shared.lock().ended = true;
        self.shared.changed.notify_all();
        if let Some(sender) = self.sender.take() {
            // It does not panic; and if it did there would be nobody to tell.
            drop(sender.join());
        }
    }
}

/// Sends what there is at a fixed rate until acknowledged, and signs of life otherwise, until the ball is lost.
fn send(shared: &Shared, most_unanswered: u32, put: impl Fn(Vec<u8>)) {
    let mut sent: Option<Instant> = None;
    // Rounds are counted, not time: a process that was held up does not take that for the server's silence.
    let mut round: Option<Instant> = None;
    loop {
        let mut state = shared.lock();
        if state.ended || state.window.ended().is_some() {
            return;
        }
        let pause = if state.fresh {
            SPACING
        } else if state.window.waiting() > 0 || state.window.unanswered() > 0 {
            SEND_AGAIN
        } else {
            HEARTBEAT
        };
        let next = sent.map_or_else(Instant::now, |sent| sent + pause);
        if Instant::now() < next {
            Shared::wait(state, &shared.changed, next);
            continue;
        }
        if state.window.unanswered() >= most_unanswered {
            state.window.end("the server does not answer");
            shared.changed.notify_all();
            return;
        }
        let now = Instant::now();
        if round.is_none_or(|round| now >= round + SEND_AGAIN) {
            round = Some(now);
            state.window.count_round();
        }
        state.fresh = false;
        let message = codec::encode_json(&state.window.message());
        drop(state);
        sent = Some(now);
        put(message);
    }
}
