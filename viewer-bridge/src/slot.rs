//! From the network to a logging thread: only the newest state waits, everything else is bounded and counted.
//!
//! The network side never waits for Rerun; a viewer that is slow loses states, not the server or the file.

use protocol::event::Event;
use protocol::snapshot::{Snapshot, World};
use protocol::stats::Stats;
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Hits that wait; older ones are dropped first.
pub const MAX_HITS: usize = 4096;
/// Lines of text that wait; older ones are dropped first.
pub const MAX_NOTES: usize = 64;

/// A line for people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// Something is amiss.
    pub warning: bool,
    /// What happened.
    pub text: String,
}

/// What a slot has seen since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// States that came.
    pub received: u64,
    /// States taken by the logging thread.
    pub shown: u64,
    /// States overtaken by a newer one before they were taken.
    pub dropped: u64,
    /// Ticks between states that came: at the server or on the way a newer state overtook theirs.
    pub missed: u64,
    /// Hits that are not shown: too many waited, a new world overtook them, or their numbers never came.
    pub hits_dropped: u64,
    /// Messages that a viewer never got, for it was too slow; the logging thread knows.
    pub rows_missed: u64,
}

/// All that waited, at one time.
#[derive(Debug, Default)]
pub struct News {
    /// A world to start from; comes before the rest.
    pub world: Option<Arc<World>>,
    /// The newest state.
    pub state: Option<Arc<Snapshot>>,
    /// Hits, oldest first.
    pub hits: Vec<Event>,
    /// The newest statistics.
    pub stats: Option<Stats>,
    /// Lines of text, oldest first.
    pub notes: Vec<Note>,
    /// Counts, these news included.
    pub counts: Counts,
}

/// The slot between one writer and one logging thread.
#[derive(Default)]
pub struct Slot {
    inside: Mutex<Inside>,
    changed: Condvar,
}

#[derive(Default)]
struct Inside {
    world: Option<Arc<World>>,
    state: Option<Arc<Snapshot>>,
    hits: VecDeque<Event>,
    stats: Option<Stats>,
    notes: VecDeque<Note>,
    counts: Counts,
    /// Epoch and tick of the last state that came.
    last_state: Option<[u64; 2]>,
    /// Epoch and number of the last hit that came.
    last_hit: Option<[u64; 2]>,
    closed: bool,
}

/// Numbers left out between two that came, each with its epoch; in a new epoch they begin at `first`.
const fn gap([last_epoch, last]: [u64; 2], [epoch, number]: [u64; 2], first: u64) -> u64 {
    let expected = if epoch == last_epoch { last + 1 } else { first };
    number.saturating_sub(expected)
}

impl Inside {
    fn receive(&mut self, state: &Snapshot) {
        let here = [state.epoch, state.tick];
        self.counts.received += 1;
        self.counts.missed += self.last_state.replace(here).map_or(0, |last| gap(last, here, state.tick));
    }

    fn receive_hit(&mut self, hit: Event) {
        let here = [hit.epoch, hit.sequence];
        self.counts.hits_dropped += self.last_hit.replace(here).map_or(0, |last| gap(last, here, 0));
        self.hits.push_back(hit);
    }

    fn has_news(&self) -> bool {
        self.world.is_some()
            || self.state.is_some()
            || !self.hits.is_empty()
            || self.stats.is_some()
            || !self.notes.is_empty()
    }
}

impl Slot {
    /// A world to start from; what waited before it is overtaken.
    pub fn world(&self, world: Arc<World>) {
        let mut inside = self.lock();
        inside.receive(&world.snapshot);
        inside.counts.dropped += u64::from(inside.state.take().is_some()) + u64::from(inside.world.is_some());
        inside.counts.hits_dropped += inside.hits.len() as u64;
        inside.hits.clear();
        inside.world = Some(world);
        self.changed.notify_one();
    }

    /// A newer state.
    pub fn state(&self, state: Arc<Snapshot>) {
        let mut inside = self.lock();
        inside.receive(&state);
        inside.counts.dropped += u64::from(inside.state.replace(state).is_some());
        self.changed.notify_one();
    }

    /// Hits, oldest first. They are shown with the next state and do not wake anybody.
    pub fn hits(&self, hits: impl IntoIterator<Item = Event>) {
        let mut inside = self.lock();
        hits.into_iter().for_each(|hit| inside.receive_hit(hit));
        let excess = inside.hits.len().saturating_sub(MAX_HITS);
        inside.hits.drain(..excess);
        inside.counts.hits_dropped += excess as u64;
    }

    /// Newer statistics.
    pub fn stats(&self, stats: Stats) {
        self.lock().stats = Some(stats);
        self.changed.notify_one();
    }

    /// A line of text.
    pub fn note(&self, warning: bool, text: impl Into<String>) {
        let mut inside = self.lock();
        inside.notes.push_back(Note { warning, text: text.into() });
        if inside.notes.len() > MAX_NOTES {
            inside.notes.pop_front();
        }
        self.changed.notify_one();
    }

    /// No more will come; what waits is still given out.
    pub fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_one();
    }

    /// What it has seen.
    pub fn counts(&self) -> Counts {
        self.lock().counts
    }

    /// Waits for news, at most `patience`; empty news when none came, None when closed and empty.
    pub fn take(&self, patience: Duration) -> Option<News> {
        let deadline = Instant::now() + patience;
        let mut inside = self.lock();
        while !inside.has_news() && !inside.closed {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            inside = self.changed.wait_timeout(inside, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        if inside.closed && !inside.has_news() {
            return None;
        }
        let (world, state) = (inside.world.take(), inside.state.take());
        inside.counts.shown += u64::from(world.is_some()) + u64::from(state.is_some());
        Some(News {
            world,
            state,
            hits: inside.hits.drain(..).collect(),
            stats: inside.stats.take(),
            notes: inside.notes.drain(..).collect(),
            counts: inside.counts,
        })
    }

    /// Every change of the inside is complete on its own, so a panic elsewhere leaves nothing half done.
    fn lock(&self) -> MutexGuard<'_, Inside> {
        self.inside.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::event::Other;

    fn state(tick: u64) -> Arc<Snapshot> {
        Arc::new(Snapshot { tick, ..Snapshot::default() })
    }

    fn hit(epoch: u64, sequence: u64) -> Event {
        let (ball, other) = (String::new(), Other::Wall(0));
        Event { epoch, sequence, time_s: 0.0, ball, other, point_m: [0.0; 3], impulse_n_s: 1.0 }
    }

    #[test]
    fn only_the_newest_state_waits_and_the_others_are_counted() {
        let slot = Slot::default();
        (1..=10).for_each(|tick| slot.state(state(tick)));
        let news = slot.take(Duration::ZERO).unwrap();
        assert_eq!(news.state.unwrap().tick, 10);
        assert_eq!(news.counts, Counts { received: 10, shown: 1, dropped: 9, ..Counts::default() });
    }

    #[test]
    fn every_state_is_shown_or_dropped() {
        let slot = Arc::new(Slot::default());
        let writer = {
            let slot = slot.clone();
            std::thread::spawn(move || {
                (0..5000).for_each(|tick| slot.state(state(tick)));
                slot.close();
            })
        };
        let mut last = None;
        while let Some(news) = slot.take(Duration::from_secs(1)) {
            let tick = news.state.map(|s| s.tick);
            assert!(tick > last, "states go forward");
            last = tick;
        }
        writer.join().unwrap();
        let counts = slot.counts();
        assert_eq!((last, counts.received), (Some(4999), 5000));
        assert_eq!(counts.shown + counts.dropped, counts.received);
    }

    #[test]
    fn what_never_came_is_counted_from_the_gaps() {
        let slot = Slot::default();
        for tick in [5, 6, 9] {
            slot.state(state(tick));
        }
        slot.state(Arc::new(Snapshot { epoch: 1, tick: 40, ..Snapshot::default() }));
        assert_eq!(slot.counts().missed, 2);
        slot.hits([(1, 7), (1, 8), (1, 11), (2, 1)].map(|(epoch, sequence)| hit(epoch, sequence)));
        assert_eq!(slot.counts().hits_dropped, 3);
        slot.world(Arc::new(crate::testing::original()));
        assert_eq!(slot.counts().hits_dropped, 3 + 4);
    }

    #[test]
    fn hits_and_notes_are_bounded_and_the_newest_stay() {
        let slot = Slot::default();
        slot.hits((0..5000).map(|sequence| hit(1, sequence)));
        (0..100).for_each(|i| slot.note(false, i.to_string()));
        let news = slot.take(Duration::ZERO).unwrap();
        assert_eq!((news.hits.len(), news.hits.last().unwrap().sequence), (MAX_HITS, 4999));
        assert_eq!((news.notes.len(), news.notes.last().unwrap().text.as_str()), (MAX_NOTES, "99"));
        assert_eq!(news.counts.hits_dropped, 5000 - MAX_HITS as u64);
    }

    #[test]
    fn a_closed_feed_gives_out_what_waits_and_then_ends() {
        let slot = Slot::default();
        slot.state(state(1));
        slot.close();
        assert!(slot.take(Duration::from_mins(1)).unwrap().state.is_some());
        assert!(slot.take(Duration::from_mins(1)).is_none());
    }
}
