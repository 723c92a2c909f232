//! The world and then its states, through late joins, resets and restarts of the server.

use crate::client::{Client, ClientError};
use crate::feed::{Feed, Presence, Presences};
use protocol::keys::{Name, Role};
use protocol::snapshot::{Snapshot, World};
use std::time::{Duration, Instant};

/// Longest wait between two looks at who is there and whether to stop.
const LOOK_AROUND: Duration = Duration::from_millis(100);
/// Silence after which the server is asked whether it is still there; a paused one is silent too.
const SILENCE: Duration = Duration::from_secs(1);

/// What a follower learns.
#[derive(Clone, Debug, PartialEq)]
pub enum Update {
    /// A world to begin with, or to begin again with: everything before is void.
    World(Box<World>),
    /// A newer state of that world.
    State(Box<Snapshot>),
    /// The server is gone; a world follows when one is back.
    Gone,
}

/// Follows an arena. As an iterator it ends when the client's options are aborted.
///
/// It subscribes first and asks for the world then, so nothing falls between; states that the world already holds
/// are dropped, and a state of another epoch sends it back for that epoch's world.
pub struct Follower {
    client: Client,
    states: Feed<Snapshot>,
    servers: Presences,
    server: Option<Name>,
    known: Option<Mark>,
    /// Whether `Gone` is still to be told.
    shown: bool,
    next_question: Instant,
    heard: Instant,
}

/// Which state is the newest known.
#[derive(Clone, Copy, PartialEq)]
struct Mark {
    epoch: u64,
    tick: u64,
    wall_ns: u64,
}

impl Mark {
    const fn of(state: &Snapshot) -> Self {
        Self { epoch: state.epoch, tick: state.tick, wall_ns: state.wall_ns }
    }

    /// At one tick a second frame tells of a pause begun or ended.
    const fn is_older_than(self, state: &Snapshot) -> bool {
        state.tick > self.tick || (state.tick == self.tick && state.wall_ns != self.wall_ns)
    }
}

impl Follower {
    pub(crate) fn new(client: Client) -> Result<Self, ClientError> {
        let now = Instant::now();
        Ok(Self {
            states: client.subscribe_state()?,
            servers: client.watch(Role::Server)?,
            client,
            server: None,
            known: None,
            shown: false,
            next_question: now,
            heard: now,
        })
    }

    /// The next update, or none within `timeout`. A question to a server on its way down may take longer.
    pub fn next_within(&mut self, timeout: Duration) -> Result<Option<Update>, ClientError> {
        let deadline = Instant::now() + timeout;
        while !self.client.options().abort.is_aborted() {
            if let Some(update) = self.look_around()? {
                return Ok(Some(update));
            }
            let wait = deadline.saturating_duration_since(Instant::now()).min(LOOK_AROUND);
            if let Some(state) = self.states.recv_timeout(wait)?
                && let Some(update) = self.take(state)
            {
                return Ok(Some(update));
            }
            if Instant::now() >= deadline {
                break;
            }
        }
        Ok(None)
    }

    /// States that could not be read so far.
    pub const fn unreadable(&self) -> u64 {
        self.states.unreadable()
    }

    fn take(&mut self, state: Snapshot) -> Option<Update> {
        self.heard = Instant::now();
        let known = self.known?;
        if known.epoch != state.epoch {
            self.known = None;
            self.next_question = self.heard;
            return None;
        }
        if !known.is_older_than(&state) {
            return None;
        }
        self.known = Some(Mark::of(&state));
        Some(Update::State(Box::new(state)))
    }

    /// Notes who came and went, and asks what has to be asked.
    fn look_around(&mut self) -> Result<Option<Update>, ClientError> {
        while let Some(change) = self.servers.recv_timeout(Duration::ZERO)? {
            match change {
                Presence::Here(id) => {
                    // The first token may arrive after the first world, and is then no news.
                    if self.server.replace(id.clone()).is_some_and(|known| known != id) {
                        self.known = None;
                        self.next_question = Instant::now();
                    }
                }
                Presence::Gone(id) if self.server.as_ref() == Some(&id) => {
                    self.server = None;
                    if let Some(gone) = self.lose() {
                        return Ok(Some(gone));
                    }
                }
                Presence::Gone(_) => {}
            }
        }
        let Some(known) = self.known else { return Ok(self.ask_for_world()) };
        if self.heard.elapsed() > SILENCE {
            self.heard = Instant::now();
            match self.client.stats_now(SILENCE) {
                Ok(stats) if stats.epoch == known.epoch => {}
                Ok(_) => self.known = None,
                // Too busy for a question is not gone.
                Err(ClientError::Refused { .. }) => {}
                Err(_) => return Ok(self.lose()),
            }
        }
        Ok(None)
    }

    fn ask_for_world(&mut self) -> Option<Update> {
        let now = Instant::now();
        if now < self.next_question {
            return None;
        }
        self.next_question = now + LOOK_AROUND;
        match self.client.snapshot_now() {
            Ok(world) => {
                self.known = Some(Mark::of(&world.snapshot));
                self.shown = true;
                self.heard = Instant::now();
                Some(Update::World(Box::new(world)))
            }
            Err(e) => {
                tracing::debug!("no world yet: {e}");
                None
            }
        }
    }

    fn lose(&mut self) -> Option<Update> {
        self.known = None;
        std::mem::take(&mut self.shown).then_some(Update::Gone)
    }
}

impl Iterator for Follower {
    type Item = Update;

    /// Waits as long as it takes; ends when aborted, or when the session itself is lost.
    fn next(&mut self) -> Option<Update> {
        while !self.client.options().abort.is_aborted() {
            match self.next_within(LOOK_AROUND) {
                Ok(Some(update)) => return Some(update),
                Ok(None) => {}
                Err(e) => {
                    tracing::error!("the session is lost: {e}");
                    return None;
                }
            }
        }
        None
    }
}
