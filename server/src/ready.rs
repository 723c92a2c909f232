//! What was made ready for a command, and what the command then does to the world: the same in a live run, in a replay
//! and on the way back through a history.

use crate::change::Change;
use crate::simulation::{Moment, Simulation};
use crate::world::World;
use ballroom_physics::Seat;
use protocol::command::{Command, Refusal, RunState, Scope, code};
use std::sync::Arc;

/// What was made ready for a command.
#[derive(Default)]
pub enum Ready {
    /// Nothing was needed.
    #[default]
    Nothing,
    /// Places on the floor of a world.
    Seats(Arc<World>, Vec<Seat>),
    /// A change of the present world.
    Change(Box<Change>),
    /// A world, to take the place of the present one.
    World(Box<Simulation>),
    /// A page with room for the present state.
    Page(Box<Moment>),
}

impl Ready {
    /// What `command` does to the world; one that moves the clock only does nothing. What was replaced is left in here,
    /// to be let go of where nobody waits for it.
    pub fn act(&mut self, command: &Command, simulation: &mut Simulation) -> Result<(), Refusal> {
        match (&mut *self, command) {
            (Self::World(world), _) => simulation.give_way_to(world),
            (Self::Change(change), _) => return simulation.change(change),
            (Self::Seats(world, seats), _) => return simulation.set_balls(world, seats),
            (_, Command::Steer { ball, direction, mode }) => {
                let steered = simulation.steer(ball.as_deref(), *direction, *mode);
                return steered.map_err(|why| Refusal::new(code::NOT_FOUND, why));
            }
            (_, Command::Reset { scope, .. }) => return simulation.reset(*scope),
            (_, Command::SetState { state: RunState::Stopped }) => return simulation.reset(Scope::All),
            (_, Command::Delete(selection)) => {
                *self = Self::Change(Box::new(simulation.deletion(selection)?));
                return self.act(command, simulation);
            }
            (_, Command::SetBalls { select: Some(select), velocity_m_per_s, spin_rad_per_s, .. }) => {
                let velocity = velocity_m_per_s.map(Into::into);
                return simulation.set_selected(select, velocity, *spin_rad_per_s);
            }
            (Self::Nothing, command) if command.needs_preparing() => {
                return Err(Refusal::new(code::OPERATION_FAILED, "nothing was made ready for this"));
            }
            (Self::Page(_) | Self::Nothing, _) => {}
        }
        Ok(())
    }
}
