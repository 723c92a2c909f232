//! What happens at one instant is written down in an order that the queue does not decide: by id.
//!
//! Events of one time that do not touch each other may be taken in any order, and the order of hits in their list and of
//! addends in a sum shall not tell which was taken. So both wait until the clock goes on and are then put in the order of
//! the balls they belong to; those of one ball stay in the order in which they happened.

use super::Controller;
use crate::schedule::time::Time;
use crate::tolerance::HITS_KEPT;

/// Addends of one instant that there is room for from the start.
const ADDENDS: usize = 256;

/// What waits for its instant to end.
#[derive(Debug)]
pub(super) struct Ledger {
    /// The instant.
    pub(super) time: Time,
    /// Whether events are being taken; what is booked between advances does not wait.
    open: bool,
    /// Place in the list of hits of the instant's first.
    first_hit: usize,
    addends: Vec<Addend>,
}

/// What a ball adds to sums whose bits depend on the order of their addends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Addend {
    pub ball: u32,
    /// Steering work, J.
    pub work: f64,
    /// Negative reaction, s.
    pub pulled: f64,
}

impl Ledger {
    pub(super) fn new() -> Self {
        Self { time: Time::ZERO, open: false, first_hit: 0, addends: Vec::with_capacity(ADDENDS) }
    }
}

/// A copy has as much room: what is rarely booked must not take memory in the middle of a run.
impl Clone for Ledger {
    fn clone(&self) -> Self {
        let mut addends = Vec::with_capacity(self.addends.len().max(ADDENDS));
        addends.extend_from_slice(&self.addends);
        Self { time: self.time, open: self.open, first_hit: self.first_hit, addends }
    }
}

/// Sorts what is nearly sorted, in place, and keeps equals in their order.
fn sort_by_ball<T>(list: &mut [T], ball: impl Fn(&T) -> usize) {
    for end in 1..list.len() {
        let mut place = end;
        while place > 0 && ball(&list[place - 1]) > ball(&list[place]) {
            list.swap(place - 1, place);
            place -= 1;
        }
    }
}

impl Controller {
    /// An event of `time` is due: if that is later than the last one's, the instant between is over.
    #[inline]
    pub(super) fn open_instant(&mut self, time: Time) {
        if self.ledger.time != time || !self.ledger.open {
            self.close_instant();
            (self.ledger.time, self.ledger.open) = (time, true);
        }
    }

    /// Enters what has waited.
    pub(super) fn close_instant(&mut self) {
        let first = self.ledger.first_hit.min(self.hits.len());
        if self.hits.len() > first + 1 {
            sort_by_ball(&mut self.hits[first..], |hit| hit.ball);
        }
        if self.hits.len() > HITS_KEPT {
            self.drop_hits(self.hits.len() - HITS_KEPT);
            self.hits.truncate(HITS_KEPT);
        }
        self.ledger.first_hit = self.hits.len();
        self.ledger.open = false;
        if self.ledger.addends.is_empty() {
            return;
        }
        let mut addends = std::mem::take(&mut self.ledger.addends);
        sort_by_ball(&mut addends, |addend| addend.ball as usize);
        for addend in addends.drain(..) {
            self.add_up(addend);
        }
        self.ledger.addends = addends;
    }

    /// Whether the list of hits is full: one that fills up within an instant takes all of that instant first.
    pub(super) fn hits_are_full(&self) -> bool {
        self.hits.len() >= HITS_KEPT && self.ledger.first_hit >= HITS_KEPT
    }

    /// Those in the list stay as they are.
    pub(super) fn keep_hits(&mut self) {
        self.ledger.first_hit = self.hits.len();
    }

    pub(super) fn clear_hits(&mut self) {
        self.hits.clear();
        self.ledger.first_hit = 0;
    }

    /// Adds to the sums: at the end of the instant, if there is one.
    #[inline]
    pub(super) fn book(&mut self, ball: usize, work: f64, pulled: f64) {
        if work == 0.0 && pulled == 0.0 {
            return;
        }
        let addend = Addend { ball: ball as u32, work, pulled };
        if self.ledger.open {
            self.ledger.addends.push(addend);
        } else {
            self.add_up(addend);
        }
    }
}
