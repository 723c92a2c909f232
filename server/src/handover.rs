//! What the tick thread hands to the publisher: the newest state only, every hit, every answer. Nothing here blocks
//! the tick: the lock is held for swaps, buffers go round, and what does not fit is counted.

use crate::inbox::Answered;
use crate::simulation::{NumberedHit, Stage};
use protocol::snapshot::Snapshot;
use protocol::state::RunState;
use protocol::stats::Stats;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Hits kept while the publisher is busy.
pub const HITS_CAPACITY: usize = 16_384;
/// Snapshot buffers kept ready: for one being written, one waiting, one being sent, one being asked for.
const BUFFERS: usize = 4;

/// Everything since the publisher last looked.
#[derive(Default)]
pub struct Batch {
    /// The newest state, if there is a new one.
    pub state: Option<Snapshot>,
    /// Every hit, oldest first.
    pub hits: Vec<NumberedHit>,
    /// Hits that found no room so far.
    pub hits_dropped: u64,
    /// Scenes and rosters that came to be, oldest first; each before the first state of its epoch.
    pub stages: Vec<Stage>,
    /// Worlds that ended and others that did not come to be, to be forgotten where nobody waits for it.
    pub ended_worlds: Vec<Box<dyn Send>>,
    /// Replies to be sent.
    pub answers: Vec<Answered>,
    /// Statistics, once a second.
    pub stats: Option<Stats>,
    /// Whether no more will come.
    pub ended: bool,
}

impl Batch {
    fn is_empty(&self) -> bool {
        self.state.is_none()
            && self.hits.is_empty()
            && self.stages.is_empty()
            && self.answers.is_empty()
            && self.stats.is_none()
            && !self.ended
    }
}

#[derive(Default)]
struct Shelf {
    batch: Batch,
    spare: Vec<Snapshot>,
    skipped: u64,
}

/// The place between the two threads.
#[derive(Default)]
pub struct Handover {
    shelf: Mutex<Shelf>,
    filled: Condvar,
    run_state: AtomicU8,
}

impl Handover {
    /// With room for hits already taken.
    pub fn new() -> Self {
        let handover = Self::default();
        handover.lock().batch.hits.reserve_exact(HITS_CAPACITY);
        handover
    }

    fn lock(&self) -> MutexGuard<'_, Shelf> {
        self.shelf.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Says what the clock does; whoever is answered afterwards finds it so.
    pub fn set_run_state(&self, state: RunState) {
        self.run_state.store(state.number(), Ordering::Release);
    }

    /// What the clock does.
    pub fn run_state(&self) -> RunState {
        RunState::of_number(self.run_state.load(Ordering::Acquire)).unwrap_or_default()
    }

    /// A buffer to write the next state into.
    pub fn buffer(&self) -> Snapshot {
        self.lock().spare.pop().unwrap_or_default()
    }

    /// Puts a state out, taking the place of one not fetched yet, and hits and answers with it; both lists are emptied.
    pub fn put(
        &self,
        state: Option<Snapshot>,
        hits: &mut Vec<NumberedHit>,
        answers: &mut Vec<Answered>,
        stats: Option<Stats>,
    ) {
        let mut shelf = self.lock();
        if let Some(state) = state
            && let Some(overtaken) = shelf.batch.state.replace(state)
        {
            shelf.skipped += 1;
            drop(give_back(&mut shelf.spare, overtaken));
        }
        let room = HITS_CAPACITY.saturating_sub(shelf.batch.hits.len()).min(hits.len());
        shelf.batch.hits_dropped += (hits.len() - room) as u64;
        shelf.batch.hits.extend(hits.drain(..).take(room));
        shelf.batch.answers.append(answers);
        if stats.is_some() {
            shelf.batch.stats = stats;
        }
        drop(shelf);
        self.filled.notify_one();
    }

    /// Puts out what the next state belongs to.
    pub fn put_stage(&self, stage: Stage) {
        self.lock().batch.stages.push(stage);
    }

    /// Takes a world that ended, or that did not come to be.
    pub fn forget(&self, ended: Box<dyn Send>) {
        self.lock().batch.ended_worlds.push(ended);
    }

    /// Counts hits that found no room before they came here.
    pub fn count_dropped(&self, hits: u64) {
        self.lock().batch.hits_dropped += hits;
    }

    /// Says that nothing more will come.
    pub fn end(&self) {
        self.lock().batch.ended = true;
        self.filled.notify_one();
    }

    /// Swaps what has gathered for `batch`, whose lists must be empty, waiting at most `timeout` for something.
    pub fn take(&self, batch: &mut Batch, timeout: Duration) {
        batch.hits.reserve_exact(HITS_CAPACITY);
        let mut shelf = self.lock();
        if shelf.batch.is_empty() {
            shelf = self.filled.wait_timeout(shelf, timeout).unwrap_or_else(PoisonError::into_inner).0;
        }
        std::mem::swap(&mut shelf.batch, batch);
        shelf.batch.hits_dropped = batch.hits_dropped;
        shelf.batch.ended = batch.ended;
        shelf.batch.state = None;
        shelf.batch.stats = None;
    }

    /// Gives a buffer back to be written again.
    pub fn recycle(&self, buffer: Snapshot) {
        // What there is no room for is freed when the tick need not wait for it.
        let left = give_back(&mut self.lock().spare, buffer);
        drop(left);
    }

    /// Fills up the buffers with copies of `state`, so that a tick finds one while others are being read.
    pub fn stock(&self, state: &Snapshot) {
        (0..BUFFERS).for_each(|_| self.recycle(state.clone()));
    }

    /// States overtaken by a newer one before they were fetched.
    pub fn skipped(&self) -> u64 {
        self.lock().skipped
    }
}

/// Keeps a buffer, or hands it back when there are enough.
fn give_back(spare: &mut Vec<Snapshot>, buffer: Snapshot) -> Option<Snapshot> {
    if spare.len() < BUFFERS {
        spare.push(buffer);
        return None;
    }
    Some(buffer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stocked_tick_finds_buffers_with_room_while_others_are_read() {
        let handover = Handover::default();
        handover.stock(&Snapshot { center_m: vec![[0.0; 3]; 7], ..Snapshot::default() });
        for _ in 0..BUFFERS {
            assert!(handover.buffer().center_m.capacity() >= 7);
        }
        assert_eq!(handover.buffer().center_m.capacity(), 0);
    }

    #[test]
    fn only_the_newest_state_waits_and_buffers_go_round() {
        let handover = Handover::new();
        for tick in 1..=3 {
            let mut state = handover.buffer();
            state.tick = tick;
            handover.put(Some(state), &mut Vec::new(), &mut Vec::new(), None);
        }
        let mut batch = Batch::default();
        handover.take(&mut batch, Duration::ZERO);
        let state = batch.state.take().unwrap();
        assert_eq!((state.tick, handover.skipped()), (3, 2));
        handover.recycle(state);
        handover.take(&mut batch, Duration::ZERO);
        assert!(batch.state.is_none());
    }
}
