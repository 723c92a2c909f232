//! What of a run no tick changes: its scene, who its balls are, its floor. It is shared and never altered; what changes it
//! puts another in its place, so that going back is only a swap.

use crate::scene_file::{LoadedScene, SceneError};
use ballroom_physics::{Controller, Seat, SeatFault};
use nalgebra::Vector3;
use protocol::command::{BallSetting, Refusal, code};
use protocol::snapshot::Roster;
use std::sync::{Arc, Mutex, PoisonError};

/// A scene as it is run at present.
pub struct World {
    loaded: Arc<LoadedScene>,
    /// The balls at their places in the scene: what a reset goes back to, and what a checkpoint is restored into. The floor
    /// must not be proved again between two ticks.
    start: Controller,
    roster: Arc<Roster>,
    /// The ball meant when a player names none.
    first_player: Option<usize>,
    /// The one that was loaded, when this came of it by commands.
    origin: Option<Arc<Self>>,
}

impl World {
    /// Of a scene as it was loaded.
    pub fn new(loaded: Arc<LoadedScene>) -> Result<Self, SceneError> {
        let start = loaded.controller()?;
        Ok(Self::of(loaded, start, None))
    }

    /// What `before` became: another scene, with its balls at their places in it.
    pub(crate) fn after(before: &Arc<Self>, loaded: LoadedScene, start: Controller) -> Self {
        Self::of(Arc::new(loaded), start, Some(before.origin()))
    }

    fn of(loaded: Arc<LoadedScene>, start: Controller, origin: Option<Arc<Self>>) -> Self {
        let places = start.scene_index();
        let roster = Arc::new(loaded.roster(places));
        // Of the scene's own order, not of the engine's.
        let players = places.iter().enumerate().filter(|&(id, _)| roster.player[id]);
        let first_player = players.min_by_key(|&(_, &place)| place).map(|(id, _)| id);
        Self { loaded, start, roster, first_player, origin }
    }

    /// The one that was loaded: itself, unless commands have changed the scene since.
    pub fn origin(self: &Arc<Self>) -> Arc<Self> {
        self.origin.as_ref().unwrap_or(self).clone()
    }

    /// The scene.
    pub const fn loaded(&self) -> &Arc<LoadedScene> {
        &self.loaded
    }

    /// The engine at the scene's start. It runs only if nothing has changed the scene since it was loaded.
    pub const fn start(&self) -> &Controller {
        &self.start
    }

    /// Who the balls are, by id.
    pub const fn roster(&self) -> &Arc<Roster> {
        &self.roster
    }

    /// The ball meant when a player names none: the first in the scene's list.
    pub const fn first_player(&self) -> Option<usize> {
        self.first_player
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

    /// The id of the ball of a name.
    pub fn ball(&self, name: &str) -> Result<usize, Refusal> {
        let found = self.roster.place_of(name);
        found.ok_or_else(|| Refusal::new(code::NOT_FOUND, format!("no ball is named {name:?}")))
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

/// Which world is the present one, for whoever makes things ready for it. The tick thread takes the lock when the world
/// changes, at no other time.
pub struct Present(Mutex<Arc<World>>);

impl Present {
    /// At first.
    pub const fn new(world: Arc<World>) -> Self {
        Self(Mutex::new(world))
    }

    /// The present one.
    pub fn world(&self) -> Arc<World> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(crate) fn set(&self, world: Arc<World>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = world;
    }
}
