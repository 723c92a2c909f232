//! What a client may ask of a running arena, and the answer.
//!
//! A command is one line of JSON, at most 512 bytes; what carries lists or texts may be longer when it is asked and not
//! just put ([`Command::max_bytes`]). For a hand at the keyboard there is a short form of steering:
//! `{"key":"up"}` is one press, `{"key":"up","down":true}` a key held, `{"key":"up","down":false}` the key let go.

use crate::change::{self, PointMove, check_name};
use crate::codec::{MAX_BALLS, MAX_COMMAND_BYTES, MAX_REQUEST_BYTES};
use crate::keys::Name;
use crate::listing::Selection;
use crate::parameter::Value;
pub use crate::reply::{Refusal, Reply, code};
use crate::scene::Ball;
pub use crate::state::RunState;
pub use crate::steering::{Direction, DirectionName, SteerMode};
use crate::timeline::{Rewind, SavedState};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A request. In JSON: `{"cmd":"steer","direction":"up"}`, `{"cmd":"pause"}`, `{"cmd":"step","ticks":5}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "cmd", rename_all = "snake_case", deny_unknown_fields)]
pub enum Command {
    /// Push a player's ball.
    Steer {
        /// Which ball; the scene's first player when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        ball: Option<String>,
        /// Where to.
        direction: Direction,
        /// Once, or until told otherwise.
        #[serde(default)]
        mode: SteerMode,
    },
    /// Stop the clock.
    Pause {},
    /// Let the clock run.
    Resume {},
    /// Advance a paused arena by whole ticks.
    Step {
        /// How many, 1 to 1 000 000.
        #[serde(default = "one_tick")]
        ticks: u64,
    },
    /// Advance a paused arena as fast as it goes to the first tick at or after a simulated time.
    RunUntil {
        /// Simulated seconds since the epoch began.
        time_s: f64,
    },
    /// Back to the scene's first state, or to a part of it. Held forces end.
    Reset {
        /// What of it.
        #[serde(default, skip_serializing_if = "Scope::is_all")]
        scope: Scope,
        /// Places the scene's clouds anew; the cloud at place i has this seed plus i. Without one, the scene's own.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        seed: Option<u64>,
    },
    /// Simulated seconds per wall second.
    Speed {
        /// How many.
        factor: SpeedFactor,
    },
    /// Put balls elsewhere, with another velocity or spin: all of them, or none. Either each its own, or all that are
    /// selected alike.
    SetBalls {
        /// Each its own, 1 to 1024 of them.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        balls: Vec<BallSetting>,
        /// Which, at the tick at which it acts.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        select: Option<Selection>,
        /// Velocity of those, projected to the tangent plane.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        velocity_m_per_s: Option<[f64; 3]>,
        /// Spin of those about the floor's normal.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        spin_rad_per_s: Option<f64>,
    },
    /// Add balls, shaped as in a scene file: all of them, or none. A new epoch; the clock goes on.
    Spawn {
        /// Which, 1 to 1024 of them.
        balls: Vec<Ball>,
    },
    /// Remove the balls that meet every condition at the tick at which it acts; all that are named must be there. A new
    /// epoch; the clock goes on.
    Delete(Selection),
    /// Move control points of the floor: all of them, or none. Balls keep x, y, spin and orientation. A new epoch; the
    /// clock goes on.
    MoveControlPoints {
        /// Which, each once.
        points: Vec<PointMove>,
    },
    /// Set numbers of the scene: all of them, or none. A new epoch; the clock goes on.
    SetParameters {
        /// By their names in [`Parameters`](crate::parameter::Parameters).
        values: BTreeMap<String, Value>,
    },
    /// Set what the clock does, in the words of ROS `simulation_interfaces`.
    SetState {
        /// `stopped` pauses and resets everything, `quitting` ends this arena.
        state: RunState,
    },
    /// Go on with another scene; a new epoch.
    LoadScene {
        /// One of the scenes that come with the program.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        name: Option<String>,
        /// A scene as it stands in a file.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        toml: Option<String>,
        /// Balls in all, for a scene with one cloud; as it says when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        balls: Option<u32>,
    },
    /// Read again the file or the scene that the arena was started with; a new epoch.
    ReloadScene {},
    /// Back along what happened; a new epoch that goes on from there. The clock runs or stands as before.
    Rewind(Rewind),
    /// Keep the present state under a name.
    SaveState {
        /// The name; what it held before is forgotten.
        slot: String,
    },
    /// Go on from a state that was kept, or from one that is given; a new epoch with the tick and time of that state.
    LoadState {
        /// What it was kept as.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        slot: Option<String>,
        /// A state of the present scene.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        state: Option<Box<SavedState>>,
    },
}

/// What a reset takes back, in the words of ROS `simulation_interfaces`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scope {
    /// Everything; a new epoch.
    #[default]
    All,
    /// The clock and every count; the balls stay as they are. A new epoch.
    Time,
    /// Places, velocities, spins and orientations; the clock goes on. The energy this takes counts as steering work.
    State,
    /// Balls that were spawned: they go. A new epoch if there were any; the clock goes on.
    Spawned,
}

impl Scope {
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands fields over by reference")]
    const fn is_all(&self) -> bool {
        matches!(self, Self::All)
    }
}

/// Simulated seconds per wall second.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "factor is a number from 0.01 to 100, or \"max\"")]
pub enum SpeedFactor {
    /// 0.01 to 100.
    Times(f64),
    /// By name.
    Named(SpeedName),
}

/// A speed that is no number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SpeedName {
    /// As fast as possible: no tick waits for the wall clock.
    Max,
}

/// A ball as it shall be; what is not given stays.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BallSetting {
    /// Which.
    pub name: String,
    /// x and y of its centre.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center_m: Option<[f64; 2]>,
    /// Velocity of the centre; projected to the tangent plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity_m_per_s: Option<[f64; 3]>,
    /// Spin about the floor's normal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spin_rad_per_s: Option<f64>,
}

fn one_tick() -> u64 {
    1
}

/// Most ticks of one [`Command::Step`].
pub const MAX_STEP_TICKS: u64 = 1_000_000;
/// Most ticks of one [`Command::RunUntil`]; a pause ends it before.
pub const MAX_RUN_TICKS: u64 = 100_000_000;
/// Most balls of one [`Command::SetBalls`].
pub const MAX_SET_BALLS: usize = 1024;
/// Largest coordinate, speed and spin of one, m, m/s and rad/s: as a scene file may have.
const LARGEST: f64 = 1e6;
/// Smallest and largest factor of [`Command::Speed`].
pub const SPEED_FACTORS: [f64; 2] = [0.01, 100.0];

/// Why a text is no command, and what would be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CommandFault(pub(crate) String);

impl CommandFault {
    /// With its text.
    pub(crate) fn new(why: impl Into<String>) -> Self {
        Self(why.into())
    }
}

/// The short form of steering.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Press {
    key: DirectionName,
    #[serde(default)]
    down: Option<bool>,
    #[serde(default)]
    ball: Option<String>,
}

impl From<Press> for Command {
    fn from(Press { key, down, ball }: Press) -> Self {
        let (direction, mode) = match down {
            None => (key, SteerMode::Impulse),
            Some(true) => (key, SteerMode::Force),
            Some(false) => (DirectionName::Stop, SteerMode::Force),
        };
        Self::Steer { ball, direction: Direction::Named(direction), mode }
    }
}

impl Command {
    /// Balls set each its own.
    pub const fn set_balls(balls: Vec<BallSetting>) -> Self {
        Self::SetBalls { balls, select: None, velocity_m_per_s: None, spin_rad_per_s: None }
    }

    /// Reads and checks one line of JSON in the long or the short form.
    pub fn from_json(text: &str) -> Result<Self, CommandFault> {
        // Which form it is decides whose complaint is the helpful one.
        let value: serde_json::Value =
            serde_json::from_str(text).map_err(|e| CommandFault(format!("no JSON: {e}")))?;
        let command = if value.get("key").is_some() && value.get("cmd").is_none() {
            serde_json::from_str::<Press>(text).map(Self::from)
        } else {
            serde_json::from_str::<Self>(text)
        }
        .map_err(|e| {
            CommandFault(format!("{e}; write for instance {{\"cmd\":\"pause\"}} or {{\"key\":\"up\"}}"))
        })?;
        command.check()?;
        Ok(command)
    }

    /// Longest that it may be in JSON, bytes.
    pub const fn max_bytes(&self) -> usize {
        match self {
            Self::SetBalls { .. }
            | Self::Spawn { .. }
            | Self::Delete(_)
            | Self::MoveControlPoints { .. }
            | Self::LoadScene { .. }
            | Self::LoadState { .. } => MAX_REQUEST_BYTES,
            _ => MAX_COMMAND_BYTES,
        }
    }

    /// Whether something has to be made ready before a tick can obey it. What is made ready acts in its own order; other
    /// commands overtake it.
    pub const fn needs_preparing(&self) -> bool {
        matches!(self, Self::SetBalls { .. } | Self::SaveState { .. }) || self.may_change_world()
    }

    /// Whether who the balls are or what the scene is may be other once it has acted.
    pub const fn may_change_world(&self) -> bool {
        matches!(
            self,
            Self::Spawn { .. }
                | Self::Delete(_)
                | Self::MoveControlPoints { .. }
                | Self::SetParameters { .. }
                | Self::LoadScene { .. }
                | Self::ReloadScene {}
                | Self::SetState { state: RunState::Stopped }
                | Self::Reset { .. }
                | Self::Rewind(_)
                | Self::LoadState { .. }
        )
    }

    /// Whether what it does depends on what happened before.
    pub const fn needs_the_past(&self) -> bool {
        matches!(self, Self::Rewind(_) | Self::SaveState { .. } | Self::LoadState { .. })
    }

    /// Whether it moves the clock only, and leaves the world as it is.
    pub const fn is_of_the_clock(&self) -> bool {
        matches!(
            self,
            Self::Pause {}
                | Self::Resume {}
                | Self::Step { .. }
                | Self::RunUntil { .. }
                | Self::Speed { .. }
                | Self::SetState { state: RunState::Paused | RunState::Playing | RunState::Quitting }
        )
    }

    /// Whether its numbers make sense.
    pub fn check(&self) -> Result<(), CommandFault> {
        let fault = |why: String| Err(CommandFault(why));
        match self {
            Self::Steer { ball, direction, .. } => {
                ball.as_deref().map_or(Ok(()), check_name)?;
                direction.check()
            }
            Self::Step { ticks } if !(1..=MAX_STEP_TICKS).contains(ticks) => {
                fault(format!("ticks is {ticks}: use 1 to {MAX_STEP_TICKS}"))
            }
            Self::RunUntil { time_s } if !(0.0..=1e9).contains(time_s) => {
                fault(format!("time_s is {time_s}: use 0 to 1000000000"))
            }
            Self::Speed { factor: SpeedFactor::Times(factor) }
                if !(SPEED_FACTORS[0]..=SPEED_FACTORS[1]).contains(factor) =>
            {
                let [low, high] = SPEED_FACTORS;
                fault(format!("factor is {factor}: use {low} to {high}, or \"max\""))
            }
            Self::SetBalls { balls, select, velocity_m_per_s, spin_rad_per_s } => {
                let alike = BallSetting {
                    name: "selected".into(),
                    center_m: None,
                    velocity_m_per_s: *velocity_m_per_s,
                    spin_rad_per_s: *spin_rad_per_s,
                };
                check_settings(balls, select.as_ref(), &alike)
            }
            Self::Spawn { balls } => change::check_spawn(balls),
            Self::Delete(selection) => change::check_selection(selection),
            Self::MoveControlPoints { points } => change::check_points(points),
            Self::SetParameters { values } => change::check_values(values),
            Self::LoadScene { balls: Some(balls), .. } if *balls as usize > MAX_BALLS => {
                fault(format!("{balls} balls are too many: at most {MAX_BALLS}"))
            }
            Self::LoadScene { name, toml, .. } if name.is_some() == toml.is_some() => {
                fault("give either the name of a scene or its toml".into())
            }
            Self::Rewind(rewind) => rewind.fault().map_or(Ok(()), fault),
            Self::LoadState { slot, state } if slot.is_some() == state.is_some() => {
                fault("give either the slot or the state to load".into())
            }
            Self::SaveState { slot } | Self::LoadState { slot: Some(slot), .. } => check_slot(slot),
            Self::LoadState { state: Some(state), .. } => {
                state.fault().map_or(Ok(()), |why| fault(format!("state: {why}")))
            }
            _ => Ok(()),
        }
    }
}

/// Either a list or a selection, and something to set.
fn check_settings(
    balls: &[BallSetting],
    select: Option<&Selection>,
    alike: &BallSetting,
) -> Result<(), CommandFault> {
    let fault = |why: String| Err(CommandFault(why));
    let nothing = alike.velocity_m_per_s.is_none() && alike.spin_rad_per_s.is_none();
    match select {
        Some(_) if !balls.is_empty() => fault("give either balls or select".into()),
        Some(_) if nothing => fault("select needs velocity_m_per_s or spin_rad_per_s beside it".into()),
        Some(select) => change::check_selection(select).and_then(|()| alike.check()),
        None if !nothing => {
            fault("velocity_m_per_s and spin_rad_per_s stand in each of balls, or beside select".into())
        }
        None if !(1..=MAX_SET_BALLS).contains(&balls.len()) => {
            fault(format!("{} balls are set at once: use 1 to {MAX_SET_BALLS}", balls.len()))
        }
        None => balls.iter().try_for_each(BallSetting::check),
    }
}

fn check_slot(slot: &str) -> Result<(), CommandFault> {
    slot.parse::<Name>().map(drop).map_err(|bad| CommandFault(format!("slot: {bad}")))
}

impl BallSetting {
    fn check(&self) -> Result<(), CommandFault> {
        check_name(&self.name)?;
        let numbers = self.center_m.iter().flatten().chain(self.velocity_m_per_s.iter().flatten());
        match numbers.chain(&self.spin_rad_per_s).find(|x| !(-LARGEST..=LARGEST).contains(*x)) {
            Some(x) => Err(CommandFault(format!("{} of ball {:?}: use -1e6 to 1e6", x, self.name))),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
#[path = "command_tests.rs"]
mod tests;
