//! A run at one instant: what moves apart from what stays, so that a point of the past costs what moves.

use super::Simulation;
use crate::crew::Crew;
use crate::scene_file::LoadedScene;
use crate::world::{Present, World};
use ballroom_physics::{CheckpointFault, Controller, Time};
use std::sync::Arc;

/// What of a run stays from tick to tick, shared by all its moments.
#[derive(Clone)]
pub struct Ground {
    world: Arc<World>,
    tick_rate_hz: u32,
}

/// What moves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// Epoch.
    pub epoch: u64,
    /// Tick of it.
    pub tick: u64,
    /// Simulated time, s.
    pub time_s: f64,
    /// Total energy when the epoch began, J.
    pub energy_at_start: f64,
    /// Balls held by a force, and the tick that lets them go.
    pub held: Vec<(usize, u64)>,
    /// The engine's own words.
    pub words: Vec<u64>,
}

impl Moment {
    /// With room for a moment on a ground: writing one takes no memory.
    pub fn with_room(ground: &Ground) -> Self {
        let players = ground.world.roster().player.iter().filter(|player| **player).count();
        Self {
            words: Vec::with_capacity(ground.stand().run_words()),
            held: Vec::with_capacity(players),
            ..Self::default()
        }
    }
}

impl Ground {
    /// What a run at `moment` is.
    pub fn at(&self, moment: &Moment) -> Result<Simulation, CheckpointFault> {
        let Self { world, tick_rate_hz } = self.clone();
        if moment.held.iter().any(|(ball, _)| *ball >= world.roster().names.len()) {
            return Err(CheckpointFault::Damaged);
        }
        let controller = world.start().at_run(&moment.words)?;
        let (tick, time) = (moment.tick, controller.time());
        if !(Time::of_tick(tick, tick_rate_hz) <= time && time < Time::of_tick(tick + 1, tick_rate_hz)) {
            return Err(CheckpointFault::Damaged);
        }
        Ok(Simulation {
            present: Arc::new(Present::new(world.clone())),
            world,
            controller,
            crew: Crew::default(),
            tick_rate_hz,
            epoch: moment.epoch,
            tick,
            energy_at_start: moment.energy_at_start,
            held: moment.held.iter().copied().collect(),
        })
    }

    /// Whether it is the one that `simulation` runs in.
    pub fn is_of(&self, simulation: &Simulation) -> bool {
        Arc::ptr_eq(&self.world, &simulation.world)
    }

    /// The scene.
    pub fn loaded(&self) -> &Arc<LoadedScene> {
        self.world.loaded()
    }

    /// A controller of it, at whatever time.
    pub fn stand(&self) -> &Controller {
        self.world.start()
    }

    /// Ticks a simulated second.
    pub const fn tick_rate_hz(&self) -> u32 {
        self.tick_rate_hz
    }

    /// About how much memory it takes, bytes.
    pub fn bytes(&self) -> u64 {
        const A_BALL: u64 = 2048;
        self.stand().balls().len() as u64 * A_BALL + self.loaded().source().text().len() as u64
    }
}

impl Simulation {
    /// What of it stays.
    pub fn ground(&self) -> Ground {
        // A field that is neither here nor in a moment does not compile.
        let Self {
            world,
            present: _,
            controller: _,
            crew: _,
            tick_rate_hz,
            epoch: _,
            tick: _,
            energy_at_start: _,
            held: _,
        } = self;
        Ground { world: world.clone(), tick_rate_hz: *tick_rate_hz }
    }

    /// What of it moves, into a buffer that keeps its room.
    pub fn write_moment(&self, out: &mut Moment) {
        let Moment { epoch, tick, time_s, energy_at_start, held, words } = out;
        (*epoch, *tick) = (self.epoch, self.tick);
        *time_s = self.controller.time().seconds();
        *energy_at_start = self.energy_at_start;
        held.clear();
        held.extend(self.held.iter().map(|(ball, until)| (*ball, *until)));
        words.clear();
        self.controller.write_run(words);
    }

    /// The last tick at or before a time.
    pub(crate) fn last_tick_at(time: Time, rate_hz: u32) -> u64 {
        let near = (time.seconds() * f64::from(rate_hz)) as u64;
        // The product may be off by its rounding.
        let around = near.saturating_sub(1)..=near + 1;
        around.rev().find(|tick| Time::of_tick(*tick, rate_hz) <= time).unwrap_or(0)
    }

    /// Numbers the epoch anew.
    pub(crate) const fn set_epoch(&mut self, epoch: u64) {
        self.epoch = epoch;
    }
}
