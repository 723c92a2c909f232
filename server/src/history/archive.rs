//! The history as several threads use it: the tick thread writes pages and goes on, a thread of its own files them, and
//! others ask. The tick thread holds a lock for single pushes only and takes no memory.

use super::line::Place;
use super::past::Past;
use super::store::{Plan, Store};
use super::{Settings, point_every_ticks};
use crate::simulation::{Ground, Moment, Simulation};
use protocol::command::{Command, Refusal, code};
use protocol::timeline::{SavedState, Timeline};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Pages in circulation: one being written, one being filed.
const PAGES: usize = 2;
/// Entries that wait to be filed; a history that falls farther behind begins anew.
const MAX_ENTRIES: usize = 8192;
/// How long the present state may be waited for: a tick, however long.
const PATIENCE: Duration = Duration::from_secs(5);
/// Between two looks at whether what was made ready before has been used.
const LOOK_AGAIN: Duration = Duration::from_millis(1);

/// What happened, on its way to the store.
enum Entry {
    Point(Box<Moment>),
    Slot(String, Box<Moment>),
    Obeyed { at: Place, command: Command, then: Place, ground: Option<Arc<Ground>> },
}

struct Shelf {
    entries: Vec<Entry>,
    #[expect(clippy::vec_box, reason = "the same boxes travel in entries, which stay small")]
    spare: Vec<Box<Moment>>,
    now: Place,
    /// A page for the present state, when somebody wants it; and it, written.
    blank: Option<Box<Moment>>,
    present: Option<(Box<Moment>, Arc<Ground>)>,
    /// An entry found no room: what is filed is no longer the whole.
    overrun: bool,
    closed: bool,
}

/// Shared by all who keep, file and ask.
pub struct Archive {
    shelf: Mutex<Shelf>,
    filled: Condvar,
    answered: Condvar,
    /// Somebody wants the present state.
    wanted: AtomicBool,
    store: Mutex<Store>,
    /// Commands made ready that were used since, or refused.
    used: AtomicU64,
}

impl Archive {
    /// With the simulation's present state as the first point, and the tick thread's end of it.
    pub fn new(simulation: &Simulation, settings: Settings) -> (Arc<Self>, Diary) {
        let ground = Arc::new(simulation.ground());
        let mut store = Store::new(ground.clone(), settings);
        let mut first = Moment::with_room(&ground);
        simulation.write_moment(&mut first);
        store.point(&first);
        let is_kept = settings.max_bytes > 0;
        let pages = if is_kept { PAGES } else { 0 };
        let shelf = Shelf {
            entries: Vec::with_capacity(MAX_ENTRIES),
            spare: (0..pages).map(|_| Box::new(Moment::with_room(&ground))).collect(),
            now: (simulation.epoch(), simulation.tick()),
            blank: None,
            present: None,
            overrun: false,
            closed: false,
        };
        let archive = Arc::new(Self {
            shelf: Mutex::new(shelf),
            filled: Condvar::new(),
            answered: Condvar::new(),
            wanted: AtomicBool::new(false),
            store: Mutex::new(store),
            used: AtomicU64::new(0),
        });
        let every = point_every_ticks(simulation.tick_rate_hz());
        let diary = Diary { archive: archive.clone(), ground, every, until_due: every, is_kept };
        (archive, diary)
    }

    fn shelf(&self) -> MutexGuard<'_, Shelf> {
        self.shelf.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The store with everything filed that has happened, and where the run stands.
    fn store(&self) -> (MutexGuard<'_, Store>, Place) {
        let mut store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        let mut shelf = self.shelf();
        let entries = shelf.entries.drain(..).collect::<Vec<_>>();
        let (now, overrun) = (shelf.now, std::mem::take(&mut shelf.overrun));
        drop(shelf);
        for entry in entries {
            match entry {
                Entry::Point(page) => {
                    store.point(&page);
                    self.shelf().spare.push(page);
                }
                Entry::Slot(slot, page) => store.keep(slot, &page),
                Entry::Obeyed { at, command, then, ground } => {
                    store.obeyed(at, command, then);
                    if let Some(ground) = ground {
                        store.enter(ground);
                    }
                }
            }
        }
        if overrun {
            store.forget();
        }
        (store, now)
    }

    /// Files what happens until the tick thread has ended.
    pub fn run(&self) {
        loop {
            let mut shelf = self.shelf();
            while shelf.entries.is_empty() && !shelf.closed {
                shelf = self.filled.wait(shelf).unwrap_or_else(PoisonError::into_inner);
            }
            let closed = shelf.closed;
            drop(shelf);
            drop(self.store());
            if closed {
                return;
            }
        }
    }

    /// A command that goes back as it shall be carried out, and what for, once what was made `ready` before has been used.
    /// None when the tick thread has ended.
    pub fn plan(&self, command: Command, ready: u64) -> Option<Result<(Command, Plan), Refusal>> {
        while self.used.load(Ordering::Acquire) < ready {
            if self.shelf().closed {
                return None;
            }
            std::thread::sleep(LOOK_AGAIN);
        }
        let (store, now) = self.store();
        if let Command::SaveState { slot } = &command
            && let Err(refusal) = store.has_room_for(slot)
        {
            return Some(Err(refusal));
        }
        Some(store.plan(command, now))
    }

    /// What can be gone back to.
    pub fn timeline(&self) -> Timeline {
        let (store, now) = self.store();
        store.timeline(now)
    }

    /// What a slot holds, or the run as it stands.
    pub fn saved(&self, slot: Option<&str>) -> Result<SavedState, Refusal> {
        let past = match slot {
            Some(slot) => self.store().0.slot(slot)?.clone(),
            None => self.present()?,
        };
        past.to_saved().map_err(|fault| Refusal::new(code::OPERATION_FAILED, fault.to_string()))
    }

    /// Asks the tick thread for a page of the present.
    fn present(&self) -> Result<Arc<Past>, Refusal> {
        let ground = self.store().0.ground().clone();
        let mut shelf = self.shelf();
        shelf.blank = Some(Box::new(Moment::with_room(&ground)));
        self.wanted.store(true, Ordering::Relaxed);
        let deadline = Instant::now() + PATIENCE;
        while shelf.present.is_none() {
            let left = deadline.saturating_duration_since(Instant::now());
            if left == Duration::ZERO || shelf.closed {
                return Err(Refusal::new(
                    code::OPERATION_FAILED,
                    "no tick came to an end meanwhile: ask again",
                ));
            }
            shelf = self.answered.wait_timeout(shelf, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        let page = shelf.present.take();
        drop(shelf);
        page.map(|(page, ground)| Arc::new(Past::new(&ground, &page)))
            .ok_or_else(|| Refusal::new(code::OPERATION_FAILED, "somebody else asked: ask again"))
    }
}

/// The tick thread's end.
pub struct Diary {
    archive: Arc<Archive>,
    ground: Arc<Ground>,
    every: u64,
    until_due: u64,
    is_kept: bool,
}

impl Diary {
    /// A tick was done.
    pub fn ticked(&mut self, simulation: &Simulation) {
        if !self.is_kept {
            return;
        }
        self.until_due = self.until_due.saturating_sub(1);
        let mut shelf = self.archive.shelf();
        shelf.now = (simulation.epoch(), simulation.tick());
        if self.until_due > 0 {
            return;
        }
        // With no page at hand the next tick does as well.
        let Some(mut page) = shelf.spare.pop() else { return };
        drop(shelf);
        simulation.write_moment(&mut page);
        self.push(Entry::Point(page));
        self.until_due = self.every;
    }

    /// A command was obeyed that led here from `at`.
    pub fn obeyed(&mut self, at: Place, command: &Command, simulation: &Simulation) {
        let then = (simulation.epoch(), simulation.tick());
        self.archive.shelf().now = then;
        let changes_nothing = command.is_of_the_clock() || matches!(command, Command::SaveState { .. });
        let ground = (!self.ground.is_of(simulation)).then(|| Arc::new(simulation.ground()));
        if let Some(ground) = &ground {
            self.ground = ground.clone();
            // Running forward again through another world takes long.
            self.until_due = 1;
        }
        if ground.is_some() || (self.is_kept && !changes_nothing) {
            self.push(Entry::Obeyed { at, command: command.clone(), then, ground });
        }
    }

    /// The present state is to be kept under a name.
    pub fn save(&mut self, slot: &str, mut page: Box<Moment>, simulation: &Simulation) {
        simulation.write_moment(&mut page);
        self.push(Entry::Slot(slot.to_owned(), page));
    }

    /// Something that was made ready has been used or refused.
    pub fn used(&self) {
        self.archive.used.fetch_add(1, Ordering::Release);
    }

    /// Writes the present state where somebody wants it.
    pub fn show(&self, simulation: &Simulation) {
        if !self.archive.wanted.swap(false, Ordering::Relaxed) {
            return;
        }
        let Some(mut page) = self.archive.shelf().blank.take() else { return };
        simulation.write_moment(&mut page);
        self.archive.shelf().present = Some((page, self.ground.clone()));
        self.archive.answered.notify_all();
    }

    fn push(&self, entry: Entry) {
        let mut shelf = self.archive.shelf();
        if shelf.entries.len() < MAX_ENTRIES {
            shelf.entries.push(entry);
        } else {
            shelf.overrun = true;
        }
        drop(shelf);
        self.archive.filled.notify_one();
    }
}

impl Drop for Diary {
    /// Also when the tick thread panics: nobody may wait for ever.
    fn drop(&mut self) {
        self.archive.shelf().closed = true;
        self.archive.filled.notify_all();
        self.archive.answered.notify_all();
    }
}
