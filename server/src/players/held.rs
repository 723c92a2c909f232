//! One player's ball: which commands have come, and what became of them.

use super::tally::Tally;
use super::{DRIVES_PER_S, MESSAGES_PER_S};
use crate::bucket::Bucket;
use protocol::keys::Name;
use protocol::player::{Ack, Acted, Drive, Grant, LEASE_MILLIS, MAX_WINDOW, PlayerRow, Token};
use protocol::snapshot::Collisions;
use std::collections::BTreeMap;
use std::time::Instant;
use subtle::ConstantTimeEq;

/// A claim, from the question for it until its ball is free again.
#[derive(Debug)]
pub struct Held {
    /// Number of the claim.
    pub id: u64,
    /// Which ball.
    pub ball: String,
    token: Token,
    /// Number of the command that is expected next.
    pub next_seq: u64,
    /// The last command up to which the player knows everything.
    acked: u64,
    /// What the player may not know yet.
    outcomes: BTreeMap<u64, Acted>,
    /// Commands on their way to their ticks.
    waiting: usize,
    refused: u64,
    tally: Tally,
    latency_ms: Option<f64>,
    /// Looks since the last message.
    pub silent_looks: u32,
    /// Hits of the ball since it was claimed.
    pub hits: Collisions,
    /// Messages of any kind under the player's name.
    pub messages: Bucket,
    /// Commands.
    drives: Bucket,
    /// Whether there is something to acknowledge.
    news: bool,
    /// Why it ends, from when it does until its ball is free.
    pub ending: Option<String>,
}

impl Held {
    /// A claim that begins now.
    pub fn new(id: u64, ball: String, token: Token, now: Instant) -> Self {
        Self {
            id,
            ball,
            token,
            next_seq: 1,
            acked: 0,
            outcomes: BTreeMap::new(),
            waiting: 0,
            refused: 0,
            tally: Tally::default(),
            latency_ms: None,
            silent_looks: 0,
            hits: Collisions::default(),
            messages: Bucket::full(MESSAGES_PER_S, now),
            drives: Bucket::full(DRIVES_PER_S, now),
            news: false,
            ending: None,
        }
    }

    /// Whether the token is the one that was given; takes as long for any wrong one.
    pub fn is_given(&self, token: &Token) -> bool {
        self.token.as_bytes().ct_eq(token.as_bytes()).into()
    }

    /// As it is told to the player.
    pub fn grant(&self, player: Name) -> Grant {
        let lease_s = LEASE_MILLIS as f64 * 1e-3;
        Grant { player, ball: self.ball.clone(), claim: self.id, token: self.token.clone(), lease_s }
    }

    /// Takes note of a message, whatever is in it.
    pub fn hear(&mut self, drive: &Drive) {
        self.silent_looks = 0;
        self.news = true;
        self.tally.hear(drive.number);
        self.latency_ms = drive.latency_ms.or(self.latency_ms);
        // An old message knows less than a newer one that overtook it.
        if drive.acked > self.acked {
            self.acked = drive.acked;
            self.outcomes.retain(|seq, _| *seq > drive.acked);
        }
    }

    /// Whether another command may be taken now.
    pub fn has_room(&mut self, now: Instant) -> bool {
        self.waiting < MAX_WINDOW && self.drives.take(now)
    }

    /// The expected command is on its way to its tick.
    pub const fn take_next(&mut self) {
        self.next_seq += 1;
        self.waiting += 1;
    }

    /// A command that was on its way has acted, or was refused at its tick.
    pub fn acted(&mut self, acted: Acted) {
        self.waiting = self.waiting.saturating_sub(1);
        self.note(acted);
    }

    /// The expected command is refused before it comes to a tick.
    pub fn refuse_next(&mut self, acted: Acted) {
        self.next_seq += 1;
        self.note(acted);
    }

    fn note(&mut self, acted: Acted) {
        self.news = true;
        self.refused += u64::from(!acted.is_done());
        if acted.seq > self.acked {
            self.outcomes.insert(acted.seq, acted);
        }
        // An honest player never waits for more than a window.
        if self.outcomes.len() > MAX_WINDOW {
            self.outcomes.pop_first();
        }
    }

    /// The acknowledgement, if there is news.
    pub fn take_ack(&mut self) -> Option<Ack> {
        std::mem::take(&mut self.news).then(|| self.ack(None))
    }

    /// The last acknowledgement.
    pub fn farewell(&self) -> Ack {
        self.ack(self.ending.clone())
    }

    fn ack(&self, ended: Option<String>) -> Ack {
        Ack {
            claim: self.id,
            heard: self.tally.newest,
            next_seq: self.next_seq,
            acted: self.outcomes.values().cloned().collect(),
            ended,
        }
    }

    /// As it is told to anybody; its rank is still to be found.
    pub fn row(&self, player: Name, look_s: f64) -> PlayerRow {
        PlayerRow {
            player,
            ball: self.ball.clone(),
            claim: self.id,
            hits: self.hits,
            rank: 1,
            commands: self.next_seq - 1,
            refused: self.refused,
            waiting: self.waiting,
            messages: self.tally.came,
            lost: self.tally.lost(),
            repeated: self.tally.repeated,
            latency_ms: self.latency_ms,
            silent_s: f64::from(self.silent_looks) * look_s,
        }
    }
}
