//! Everything that can be gone back to, and how a command that goes back is made ready.

use super::line::{Line, Place, Way, What, bytes_of_all};
use super::past::Past;
use super::{MAX_SLOT_BYTES, Settings};
use crate::ready::Ready;
use crate::recording::obey;
use crate::simulation::{Ground, Moment, Simulation};
use crate::workshop::Bench;
use ballroom_physics::Time;
use protocol::command::{Command, Refusal, code};
use protocol::timeline::{MAX_SLOTS, Rewind, SavedState, SlotEntry, Timeline};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The history of a run, and its slots.
pub struct Store {
    line: Line,
    slots: BTreeMap<String, Arc<Past>>,
    ground: Arc<Ground>,
}

/// What is needed to make a command ready, taken from a store that goes on meanwhile.
pub enum Plan {
    /// Go to a place of the past.
    Go(Way),
    /// Be what a slot holds.
    Enter(Arc<Past>),
    /// Be what is given.
    Load(Box<SavedState>, Arc<Ground>),
    /// Keep the present.
    Save(Arc<Ground>),
}

impl Store {
    /// Nothing yet, for a run in `world`.
    pub fn new(ground: Arc<Ground>, settings: Settings) -> Self {
        let line = Line::new(ground.tick_rate_hz(), settings.max_bytes, settings.forgets);
        Self { line, slots: BTreeMap::new(), ground }
    }

    /// The run is in another world from now on.
    pub fn enter(&mut self, ground: Arc<Ground>) {
        self.ground = ground;
    }

    /// The world that the run is in.
    pub const fn ground(&self) -> &Arc<Ground> {
        &self.ground
    }

    /// A point of the run, as a tick has left it.
    pub fn point(&mut self, moment: &Moment) {
        self.line.point(Arc::new(Past::new(&self.ground, moment)));
    }

    /// The present is kept under a name.
    pub fn keep(&mut self, slot: String, moment: &Moment) {
        self.slots.insert(slot, Arc::new(Past::new(&self.ground, moment)));
    }

    /// Forgets what happened; slots stay.
    pub fn forget(&mut self) {
        self.line.clear();
    }

    /// A command was obeyed, and led from one place to another.
    pub fn obeyed(&mut self, at: Place, command: Command, then: Place) {
        match command {
            Command::Rewind(Rewind { tick: Some(tick), epoch: Some(epoch), .. }) => {
                self.line.went_back((epoch, tick), then);
            }
            Command::LoadState { slot: Some(slot), .. } => match self.slots.get(&slot) {
                Some(past) => self.line.done(at, What::Entered(past.clone()), then),
                None => self.line.clear(),
            },
            command => self.line.done(at, What::Command(Arc::new(command)), then),
        }
    }

    /// A command as it shall be carried out and written down, and what is needed for it, when the run stands at `now`.
    pub fn plan(&self, command: Command, now: Place) -> Result<(Command, Plan), Refusal> {
        match command {
            Command::Rewind(rewind) => {
                let place = self.line.find(&rewind, now)?;
                let gone = || Refusal::new(code::OPERATION_FAILED, "the history does not reach that far");
                let way = self.line.way(place).ok_or_else(gone)?;
                let exactly = Rewind { epoch: Some(place.0), ..Rewind::to_tick(place.1) };
                Ok((Command::Rewind(exactly), Plan::Go(way)))
            }
            Command::LoadState { slot: Some(slot), .. } => {
                let past = self.slot(&slot)?.clone();
                Ok((Command::LoadState { slot: Some(slot), state: None }, Plan::Enter(past)))
            }
            Command::LoadState { slot, state: Some(state) } => {
                let plan = Plan::Load(state.clone(), self.ground.clone());
                Ok((Command::LoadState { slot, state: Some(state) }, plan))
            }
            command => Ok((command, Plan::Save(self.ground.clone()))),
        }
    }

    /// Whether another state may be kept under this name.
    pub fn has_room_for(&self, slot: &str) -> Result<(), Refusal> {
        let kept = self.slots.iter().filter(|(name, _)| *name != slot);
        if kept.clone().count() >= MAX_SLOTS {
            let why = format!("{MAX_SLOTS} slots are taken: save into one of them");
            return Err(Refusal::new(code::OPERATION_FAILED, why));
        }
        let one = size_of::<u64>() * self.ground.stand().run_words();
        let bytes = bytes_of_all(kept.map(|(_, past)| past)) + one as u64;
        if bytes > MAX_SLOT_BYTES {
            let why = format!(
                "slots would take {bytes} bytes, and may {MAX_SLOT_BYTES}: save into one that is taken"
            );
            return Err(Refusal::new(code::OPERATION_FAILED, why));
        }
        Ok(())
    }

    /// What a slot holds.
    pub fn slot(&self, slot: &str) -> Result<&Arc<Past>, Refusal> {
        self.slots.get(slot).ok_or_else(|| {
            let names: Vec<&str> = self.slots.keys().map(String::as_str).take(8).collect();
            let there = if names.is_empty() {
                format!("none was saved yet: `ballroom save {slot}`")
            } else {
                format!("there are {}", names.join(", "))
            };
            Refusal::new(code::NOT_FOUND, format!("no slot is named {slot:?}; {there}"))
        })
    }

    /// For whoever asks, when the run stands at `now`.
    pub fn timeline(&self, now: Place) -> Timeline {
        let entry = |(name, past): (&String, &Arc<Past>)| {
            let (epoch, tick) = past.place();
            let scene = past.ground().loaded().scene().name.clone();
            SlotEntry { name: name.clone(), scene, epoch, tick, time_s: past.time_s(), bytes: past.bytes() }
        };
        Timeline {
            history: self.line.entry(now),
            slots: self.slots.iter().map(entry).collect(),
            slots_bytes: bytes_of_all(self.slots.values()),
        }
    }
}

impl Plan {
    /// Makes it ready; what takes long.
    pub fn carry_out(self) -> Result<Ready, Refusal> {
        let simulation = match self {
            Self::Go(way) => way.go()?,
            Self::Enter(past) => past.simulation().map_err(|fault| failed(&fault))?,
            Self::Load(saved, ground) => {
                let past = Past::of_saved(&ground, &saved).map_err(|fault| failed(&fault))?;
                past.simulation().map_err(|fault| failed(&fault))?
            }
            Self::Save(ground) => return Ok(Ready::Page(Box::new(Moment::with_room(&ground)))),
        };
        Ok(Ready::World(Box::new(simulation)))
    }
}

impl Way {
    /// Goes it: from the point before, with the commands that were obeyed since.
    pub fn go(self) -> Result<Simulation, Refusal> {
        let mut simulation = self.from.simulation().map_err(|fault| failed(&fault))?;
        let mut bench = Bench::new(&simulation);
        for deed in self.deeds {
            advance_to(&mut simulation, deed.at.1);
            match &deed.what {
                What::Command(command) => again(&mut simulation, &mut bench, command)?,
                What::Entered(past) => {
                    simulation = past.simulation().map_err(|fault| failed(&fault))?;
                    bench = Bench::new(&simulation);
                }
                What::WentBack => {}
            }
            simulation.set_epoch(deed.then.0);
        }
        advance_to(&mut simulation, self.to.1);
        Ok(simulation)
    }
}

/// Without looking at every tick on the way, which changes no bit.
fn advance_to(simulation: &mut Simulation, tick: u64) {
    simulation.advance_to(Time::of_tick(tick, simulation.tick_rate_hz()));
}

/// What was obeyed once is obeyed again.
fn again(simulation: &mut Simulation, bench: &mut Bench, command: &Command) -> Result<(), Refusal> {
    if let Command::LoadState { state: Some(state), .. } = command {
        let past = Past::of_saved(&Arc::new(simulation.ground()), state).map_err(|fault| failed(&fault))?;
        *simulation = past.simulation().map_err(|fault| failed(&fault))?;
        *bench = Bench::new(simulation);
        return Ok(());
    }
    obey(simulation, bench, command).map_err(|why| Refusal::new(code::OPERATION_FAILED, why))
}

fn failed(fault: &ballroom_physics::CheckpointFault) -> Refusal {
    Refusal::new(code::OPERATION_FAILED, fault.to_string())
}
