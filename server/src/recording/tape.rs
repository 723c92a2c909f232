//! From the tick thread to the recorder: bounded, without waiting or allocating.

use super::{CommandLine, HashLine, Head, TAPE_CAPACITY};
use crate::simulation::Simulation;
use ballroom_physics::Observer;
use protocol::command::Command;
use protocol::snapshot::Snapshot;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

/// State buffers in circulation; a state that finds none is dropped and counted.
const BUFFERS: usize = 4;
/// Entries that wait when steps without a clock begin to give way.
const CROWDED: usize = TAPE_CAPACITY / 2;
/// How long such a step gives way: time for a thousand entries to be written.
const GIVE_WAY: Duration = Duration::from_millis(1);

/// One thing that happened.
pub(super) enum Entry {
    /// A command was obeyed.
    Command(CommandLine),
    /// A tick was done.
    Hash(HashLine),
    /// A state was due.
    State(Box<Snapshot>),
    /// The last state of all.
    End(HashLine),
}

/// An entry, and when it was made: nanoseconds since 1970.
pub(super) struct Stamped {
    pub wall_ns: u64,
    pub entry: Entry,
}

/// Between the two threads; the lock is held for single pushes and swaps.
#[derive(Default)]
pub(super) struct Shelf {
    /// Oldest first, at most [`TAPE_CAPACITY`].
    pub entries: Vec<Stamped>,
    /// Buffers to write states into.
    #[expect(clippy::vec_box, reason = "the same boxes travel in entries, which stay small")]
    pub spare: Vec<Box<Snapshot>>,
    /// States that found no buffer.
    pub states_dropped: u64,
    /// An entry found no room: nothing is taken any more.
    pub overrun: bool,
    /// The tick thread or the recorder has ended: likewise.
    pub closed: bool,
}

/// Shared by both ends.
#[derive(Clone, Default)]
pub(super) struct Shared(Arc<Mutex<Shelf>>);

impl Shared {
    pub fn lock(&self) -> MutexGuard<'_, Shelf> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The tick thread's end; the default one records nothing.
#[derive(Default)]
pub struct Tape(Option<Reel>);

struct Reel {
    shared: Shared,
    hash_every: u64,
    state_every: u64,
    order: u64,
    crowded: bool,
    observer: Observer,
}

impl Tape {
    /// A tape that begins with the simulation's present state, and the end from which it is read.
    pub(super) fn new(head: &Head, simulation: &Simulation) -> (Self, Shared) {
        let (shared, mut observer) = (Shared::default(), Observer::default());
        let mut shelf = shared.lock();
        shelf.entries.reserve_exact(TAPE_CAPACITY);
        if head.state_every_ticks > 0 {
            let mut buffer = Box::<Snapshot>::default();
            // Both then have all the room that they need.
            simulation.write_snapshot_for(&mut observer, &mut buffer);
            shelf.spare = vec![buffer; BUFFERS];
        }
        drop(shelf);
        let mut reel = Reel {
            shared: shared.clone(),
            hash_every: head.hash_every_ticks,
            state_every: head.state_every_ticks,
            order: 0,
            crowded: false,
            observer,
        };
        reel.hash(simulation);
        (Self(Some(reel)), shared)
    }

    /// A tick was done.
    pub fn ticked(&mut self, simulation: &Simulation, paused: bool) {
        let Some(reel) = &mut self.0 else { return };
        if simulation.tick().is_multiple_of(reel.hash_every) {
            reel.hash(simulation);
        }
        if reel.state_every > 0 && simulation.tick().is_multiple_of(reel.state_every) {
            reel.state(simulation, paused);
        }
    }

    /// A command was obeyed in the epoch and after the tick of `at`.
    pub fn obeyed(&mut self, at: (u64, u64), command: Command, simulation: &Simulation) {
        let Some(reel) = &mut self.0 else { return };
        let (epoch, tick) = at;
        reel.push(Entry::Command(CommandLine { epoch, tick, order: reel.order, command }));
        reel.order += 1;
        if simulation.epoch() != epoch {
            reel.hash(simulation);
        }
    }

    /// Before a step that no clock drives: when many entries wait, it can wait for them.
    pub fn give_way(&self) {
        if self.0.as_ref().is_some_and(|reel| reel.crowded) {
            std::thread::sleep(GIVE_WAY);
        }
    }

    /// Nothing more comes.
    pub fn end(&mut self, simulation: &Simulation) {
        let Some(mut reel) = self.0.take() else { return };
        reel.push(Entry::End(hash_line(simulation)));
    }
}

impl Reel {
    fn hash(&mut self, simulation: &Simulation) {
        self.push(Entry::Hash(hash_line(simulation)));
    }

    fn state(&mut self, simulation: &Simulation, paused: bool) {
        let mut shelf = self.shared.lock();
        let Some(mut buffer) = shelf.spare.pop() else {
            shelf.states_dropped += 1;
            return;
        };
        drop(shelf);
        simulation.write_snapshot_for(&mut self.observer, &mut buffer);
        buffer.paused = paused;
        buffer.wall_ns = wall_ns();
        self.push(Entry::State(buffer));
    }

    fn push(&mut self, entry: Entry) {
        let wall_ns = wall_ns();
        let mut shelf = self.shared.lock();
        if shelf.closed || shelf.overrun {
            self.crowded = false;
        } else if shelf.entries.len() < TAPE_CAPACITY {
            shelf.entries.push(Stamped { wall_ns, entry });
            self.crowded = shelf.entries.len() > CROWDED;
        } else {
            shelf.overrun = true;
        }
    }
}

impl Drop for Reel {
    /// Also when the tick thread panics: the recorder must not wait for ever.
    fn drop(&mut self) {
        self.shared.lock().closed = true;
    }
}

fn hash_line(simulation: &Simulation) -> HashLine {
    let (epoch, tick) = (simulation.epoch(), simulation.tick());
    HashLine { epoch, tick, state_hash: simulation.state_hash() }
}

pub(super) fn wall_ns() -> u64 {
    SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_nanos() as u64
}
