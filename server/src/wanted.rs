//! Players' commands that wait for the tick they are wanted at: bounded, in order, drained by the tick loop.

use crate::inbox::Request;
use protocol::command::{Refusal, code};
use protocol::player::{MAX_PLAYERS, MAX_TICKS_AHEAD, MAX_WINDOW};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Most that wait: a full window of every player.
pub const WANTED_CAPACITY: usize = MAX_PLAYERS * MAX_WINDOW;

/// A tick boundary of an epoch: after `tick`, before the next one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moment {
    /// Number of the epoch.
    pub epoch: u64,
    /// Number of the tick.
    pub tick: u64,
}

/// When a command is wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct When {
    /// At this tick; at the next boundary without one.
    pub tick: Option<u64>,
    /// Of this epoch; of the present one without one.
    pub epoch: Option<u64>,
}

/// What waits, the next one first. Commands of one claim come out in the order in which they went in.
#[derive(Default)]
pub struct Wanted {
    now: Moment,
    waiting: BinaryHeap<Reverse<Entry>>,
    /// Number of the next entry.
    order: u64,
    /// The tick of each claim's last command, as long as the epoch lasts.
    last: BTreeMap<u64, u64>,
}

struct Entry {
    due: u64,
    order: u64,
    claim: u64,
    request: Request,
}

impl Entry {
    const fn key(&self) -> (u64, u64) {
        (self.due, self.order)
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for Entry {}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.key().cmp(&other.key())
    }
}

impl Wanted {
    /// Takes a command of a claim, or says why not.
    pub fn push(&mut self, claim: u64, when: When, request: Request) -> Result<(), Refusal> {
        if self.waiting.len() >= WANTED_CAPACITY {
            return Err(Refusal::new(code::TOO_MANY, "too many commands wait for their ticks"));
        }
        let is_over = when.epoch.is_some_and(|epoch| epoch != self.now.epoch);
        let wanted = when.tick.filter(|_| !is_over).unwrap_or(0).max(self.now.tick);
        let latest = self.now.tick.saturating_add(MAX_TICKS_AHEAD);
        if wanted > latest {
            let why = format!("tick {wanted} is too far ahead: at most {latest} now");
            return Err(Refusal::new(code::OPERATION_FAILED, why));
        }
        let last = self.last.entry(claim).or_default();
        *last = wanted.max(*last);
        let (due, order) = (*last, self.order);
        self.order += 1;
        self.waiting.push(Reverse(Entry { due, order, claim, request }));
        Ok(())
    }

    /// Moves what is due at `now` to the end of `out`, in order; everything once another epoch has begun.
    pub fn drain_into(&mut self, out: &mut Vec<Request>, now: Moment) {
        let is_over = now.epoch != self.now.epoch;
        self.now = now;
        while self.waiting.peek().is_some_and(|Reverse(next)| is_over || next.due <= now.tick) {
            out.extend(self.waiting.pop().map(|Reverse(next)| next.request));
        }
        if is_over {
            self.last.clear();
        }
    }

    /// Takes back what waits of a claim.
    pub fn withdraw(&mut self, claim: u64) -> Vec<Request> {
        self.last.remove(&claim);
        let waiting = std::mem::take(&mut self.waiting).into_vec();
        let (gone, kept): (Vec<_>, Vec<_>) = waiting.into_iter().partition(|entry| entry.0.claim == claim);
        self.waiting = kept.into();
        let mut gone: Vec<Entry> = gone.into_iter().map(|Reverse(entry)| entry).collect();
        gone.sort_unstable();
        gone.into_iter().map(|entry| entry.request).collect()
    }

    /// The tick of the next one; the largest number when none waits.
    pub fn next_tick(&self) -> u64 {
        self.waiting.peek().map_or(u64::MAX, |Reverse(next)| next.due)
    }

    /// Whether one is due at the present moment.
    pub fn is_due(&self) -> bool {
        self.next_tick() <= self.now.tick
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ready::Ready;
    use protocol::command::Command;

    /// A command that can be told from others.
    fn request(name: u64) -> Request {
        Request { command: Command::Step { ticks: name }, ready: Ready::Nothing, answer: None }
    }

    fn names(requests: &[Request]) -> Vec<u64> {
        let name = |request: &Request| if let Command::Step { ticks } = request.command { ticks } else { 0 };
        requests.iter().map(name).collect()
    }

    fn due(wanted: &mut Wanted, epoch: u64, tick: u64) -> Vec<u64> {
        let mut out = Vec::new();
        wanted.drain_into(&mut out, Moment { epoch, tick });
        names(&out)
    }

    fn at(tick: u64) -> When {
        When { tick: Some(tick), epoch: None }
    }

    #[test]
    fn commands_act_at_their_tick_or_at_once_when_it_is_past() {
        let mut wanted = Wanted::default();
        assert!(due(&mut wanted, 1, 10).is_empty());
        for (claim, when, name) in
            [(1, at(12), 1), (2, at(11), 2), (3, at(3), 3), (4, When::default(), 4), (2, at(12), 5)]
        {
            wanted.push(claim, when, request(name)).unwrap();
        }
        assert!(wanted.is_due());
        assert_eq!(due(&mut wanted, 1, 10), [3, 4]);
        assert_eq!(wanted.next_tick(), 11);
        assert_eq!(due(&mut wanted, 1, 11), [2]);
        assert_eq!(due(&mut wanted, 1, 12), [1, 5]);
        assert_eq!(wanted.next_tick(), u64::MAX);
    }

    #[test]
    fn a_claims_commands_never_overtake_each_other() {
        let mut wanted = Wanted::default();
        due(&mut wanted, 1, 10);
        wanted.push(1, at(20), request(1)).unwrap();
        wanted.push(1, at(15), request(2)).unwrap();
        wanted.push(1, When::default(), request(3)).unwrap();
        wanted.push(2, at(15), request(4)).unwrap();
        assert_eq!(due(&mut wanted, 1, 19), [4]);
        assert_eq!(due(&mut wanted, 1, 20), [1, 2, 3]);
    }

    #[test]
    fn when_an_epoch_is_over_what_was_wanted_in_it_acts_at_once() {
        let mut wanted = Wanted::default();
        due(&mut wanted, 1, 500);
        wanted.push(1, at(600), request(1)).unwrap();
        wanted.push(1, at(601), request(2)).unwrap();
        assert_eq!(due(&mut wanted, 2, 0), [1, 2]);
        // One that comes late for its epoch, and one of the new epoch, which the old ticks do not hold up.
        wanted.push(1, When { tick: Some(610), epoch: Some(1) }, request(3)).unwrap();
        wanted.push(1, When { tick: Some(5), epoch: Some(2) }, request(4)).unwrap();
        assert_eq!(due(&mut wanted, 2, 1), [3]);
        assert_eq!(due(&mut wanted, 2, 5), [4]);
    }

    #[test]
    fn what_is_too_far_ahead_or_too_much_is_refused() {
        let mut wanted = Wanted::default();
        due(&mut wanted, 1, 10);
        assert!(wanted.push(1, at(10 + MAX_TICKS_AHEAD), request(1)).is_ok());
        let refused = wanted.push(1, at(11 + MAX_TICKS_AHEAD), request(2)).unwrap_err();
        assert_eq!(refused.code, code::OPERATION_FAILED);
        for i in 1..WANTED_CAPACITY {
            wanted.push(i as u64, at(20), request(0)).unwrap();
        }
        assert_eq!(wanted.push(1, at(20), request(0)).unwrap_err().code, code::TOO_MANY);
    }

    #[test]
    fn what_waits_of_a_claim_can_be_taken_back() {
        let mut wanted = Wanted::default();
        for (claim, name) in [(1, 1), (2, 2), (1, 3), (2, 4)] {
            wanted.push(claim, at(10 + name), request(name)).unwrap();
        }
        assert_eq!(names(&wanted.withdraw(1)), [1, 3]);
        assert_eq!(due(&mut wanted, 0, 100), [2, 4]);
    }
}
