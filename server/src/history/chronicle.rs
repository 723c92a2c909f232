//! The history of a run on one thread: a replay keeps it as the server did.

use super::line::Place;
use super::store::Store;
use super::{Settings, point_every_ticks};
use crate::ready::Ready;
use crate::simulation::{Ground, Moment, Simulation};
use protocol::command::{Command, Refusal};
use std::sync::Arc;

/// A store, written as the run goes.
pub struct Chronicle {
    store: Store,
    ground: Arc<Ground>,
    every: u64,
    until_due: u64,
    page: Moment,
}

impl Chronicle {
    /// With the simulation's present state as the first point.
    pub fn new(simulation: &Simulation, settings: Settings) -> Self {
        let ground = Arc::new(simulation.ground());
        let mut store = Store::new(ground.clone(), settings);
        let mut page = Moment::with_room(&ground);
        simulation.write_moment(&mut page);
        store.point(&page);
        let every = point_every_ticks(simulation.tick_rate_hz());
        Self { store, ground, every, until_due: every, page }
    }

    /// A tick was done.
    pub fn ticked(&mut self, simulation: &Simulation) {
        self.until_due = self.until_due.saturating_sub(1);
        if self.until_due == 0 {
            simulation.write_moment(&mut self.page);
            self.store.point(&self.page);
            self.until_due = self.every;
        }
    }

    /// A command was obeyed that led here from `at`.
    pub fn obeyed(&mut self, at: Place, command: Command, simulation: &Simulation) {
        if !matches!(command, Command::SaveState { .. }) {
            self.store.obeyed(at, command, (simulation.epoch(), simulation.tick()));
        }
        if !self.ground.is_of(simulation) {
            self.ground = Arc::new(simulation.ground());
            self.store.enter(self.ground.clone());
            self.until_due = 1;
        }
    }

    /// Obeys a command that goes back, as the server did.
    pub fn obey(&mut self, simulation: &mut Simulation, command: &Command) -> Result<(), Refusal> {
        let now = (simulation.epoch(), simulation.tick());
        let (command, plan) = self.store.plan(command.clone(), now)?;
        match (plan.carry_out()?, &command) {
            (Ready::World(mut ground), _) => simulation.give_way_to(&mut ground),
            (Ready::Page(mut page), Command::SaveState { slot }) => {
                simulation.write_moment(&mut page);
                self.store.keep(slot.clone(), &page);
            }
            _ => {}
        }
        self.obeyed(now, command, simulation);
        Ok(())
    }

    /// What it has kept.
    pub const fn store(&self) -> &Store {
        &self.store
    }
}
