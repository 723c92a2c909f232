//! Where the balls of a scene may be put: what of it never moves, shared by the tick loop and whoever makes ready.

use ballroom_physics::{Controller, Seat, SeatFault};
use nalgebra::Vector3;
use protocol::command::{BallSetting, Refusal, code};
use protocol::snapshot::Roster;
use std::sync::Arc;

/// A scene's balls by name, and its floor.
#[derive(Clone)]
pub struct Places {
    /// The controller at the start: a reset must not prove the floor again between two ticks.
    start: Arc<Controller>,
    roster: Arc<Roster>,
}

impl Places {
    pub(crate) fn new(start: Controller, roster: Roster) -> Self {
        Self { start: Arc::new(start), roster: Arc::new(roster) }
    }

    /// The engine at the scene's start.
    pub fn start(&self) -> &Controller {
        &self.start
    }

    /// The same, to be kept.
    pub(crate) fn shared_start(&self) -> Arc<Controller> {
        self.start.clone()
    }

    /// Whether these are the very same.
    pub(crate) fn are(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.start, &other.start) && Arc::ptr_eq(&self.roster, &other.roster)
    }

    /// Who the balls are, by id.
    pub const fn roster(&self) -> &Arc<Roster> {
        &self.roster
    }

    /// Finds the balls that are meant, and where on the floor they are to touch it.
    pub fn seats(&self, balls: &[BallSetting]) -> Result<Vec<Seat>, Refusal> {
        let seat = |wanted: &BallSetting| {
            let ball = self.ball(&wanted.name)?;
            let spot = wanted.center_m.map(|center| self.start.spot(ball, center.into()));
            Ok(Seat {
                ball,
                spot: spot.transpose().map_err(|fault| self.refusal(&fault))?,
                velocity: wanted.velocity_m_per_s.map(Vector3::from),
                spin: wanted.spin_rad_per_s,
            })
        };
        balls.iter().map(seat).collect()
    }

    fn ball(&self, name: &str) -> Result<usize, Refusal> {
        let found = self.roster.names.binary_search_by(|known| known.as_str().cmp(name));
        found.map_err(|_| Refusal::new(code::NOT_FOUND, format!("no ball is named {name:?}")))
    }

    /// The engine's reasons with the names of balls.
    pub fn refusal(&self, fault: &SeatFault) -> Refusal {
        let name = |ball: usize| self.roster.names.get(ball).map_or("?", String::as_str);
        let why = match *fault {
            SeatFault::Overlap { ball, other, depth } => {
                format!("{:?} and {:?} would overlap by {depth:e} m", name(ball), name(other))
            }
            SeatFault::InWall { ball, wall, depth } => {
                format!("{:?} would reach {depth:e} m into wall {wall}", name(ball))
            }
            SeatFault::OffFloor { ball, why } => {
                format!("{:?} would not be over the floor: {why}", name(ball))
            }
            SeatFault::Twice { ball } => format!("{:?} is set twice", name(ball)),
            SeatFault::Slides { ball } => format!("{:?} slides: nothing changes its spin", name(ball)),
            SeatFault::Stranger { ball } | SeatFault::Number { ball } => format!("{:?}: {fault}", name(ball)),
        };
        Refusal::new(code::OPERATION_FAILED, why)
    }
}
