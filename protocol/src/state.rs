//! Whether an arena's clock runs, in the words and numbers of ROS `simulation_interfaces`.

use serde::{Deserialize, Serialize};

/// What the clock of an arena does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunState {
    /// It stands where the last reset of everything put it.
    Stopped,
    /// It runs.
    #[default]
    Playing,
    /// It stands.
    Paused,
    /// The arena ends.
    Quitting,
}

impl RunState {
    /// Every state, in the order of their numbers.
    pub const ALL: [Self; 4] = [Self::Stopped, Self::Playing, Self::Paused, Self::Quitting];

    /// Its number in ROS `SimulationState`.
    pub const fn number(self) -> u8 {
        match self {
            Self::Stopped => 0,
            Self::Playing => 1,
            Self::Paused => 2,
            Self::Quitting => 3,
        }
    }

    /// The state of a number.
    pub const fn of_number(number: u8) -> Option<Self> {
        match number {
            0 => Some(Self::Stopped),
            1 => Some(Self::Playing),
            2 => Some(Self::Paused),
            3 => Some(Self::Quitting),
            _ => None,
        }
    }

    /// Its name, as on the wire.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stopped => "stopped",
            Self::Playing => "playing",
            Self::Paused => "paused",
            Self::Quitting => "quitting",
        }
    }
}

impl std::str::FromStr for RunState {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let state = Self::ALL.into_iter().find(|state| state.name() == text);
        state.ok_or_else(|| "use stopped, playing, paused or quitting".to_owned())
    }
}

/// The answer to `srv/state`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// What the clock does.
    pub state: RunState,
    /// Its number in ROS `SimulationState`.
    pub number: u8,
    /// Epoch of the newest tick.
    pub epoch: u64,
    /// The newest tick.
    pub tick: u64,
    /// Simulated time.
    pub time_s: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_numbers_lead_back_to_the_state() {
        for state in RunState::ALL {
            assert_eq!(state.name().parse(), Ok(state));
            assert_eq!(RunState::of_number(state.number()), Some(state));
            assert_eq!(serde_json::to_value(state).unwrap(), state.name());
        }
        assert!("running".parse::<RunState>().is_err() && RunState::of_number(4).is_none());
    }
}
