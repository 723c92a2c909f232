//! What a client may ask of a running arena, and the answer.

use serde::{Deserialize, Serialize};

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
    /// Back to the scene's first state; a new epoch.
    Reset {},
    /// Simulated seconds per wall second.
    Speed {
        /// 0.01 to 100.
        factor: f64,
    },
}

fn one_tick() -> u64 {
    1
}

/// Where to: a named direction in the floor's map (up is +y), or a vector of length at most 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Direction {
    /// By name.
    Named(DirectionName),
    /// x and y; longer than 1 is refused.
    Vector([f64; 2]),
}

/// The arrow keys, and let go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DirectionName {
    /// +y
    Up,
    /// -y
    Down,
    /// -x
    Left,
    /// +x
    Right,
    /// Let go of a held force; as an impulse it does nothing else.
    Stop,
}

/// Once, or until told otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SteerMode {
    /// One press: a change of velocity.
    #[default]
    Impulse,
    /// A held key: a force until another steer, or half a simulated second without one.
    Force,
}

/// The answer to a [`Command`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// Whether it was done.
    pub ok: bool,
    /// Tick at which it acted.
    pub tick: u64,
    /// Epoch of that tick.
    pub epoch: u64,
    /// Why not, and what would do; empty when done.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub error: String,
}
