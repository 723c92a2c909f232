//! Where a player wants a ball to go, and for how long.

use crate::command::CommandFault;
use serde::{Deserialize, Serialize};

/// Where to: a named direction in the floor's map (up is +y), or a vector of length at most 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "direction is \"up\", \"down\", \"left\", \"right\", \"stop\" or [x, y] of length at most 1"
)]
pub enum Direction {
    /// By name.
    Named(DirectionName),
    /// x and y; longer than 1 is refused.
    Vector([f64; 2]),
}

impl From<DirectionName> for Direction {
    fn from(name: DirectionName) -> Self {
        Self::Named(name)
    }
}

impl From<[f64; 2]> for Direction {
    fn from(vector: [f64; 2]) -> Self {
        Self::Vector(vector)
    }
}

impl Direction {
    /// As a vector; `Stop` is none.
    pub const fn vector(self) -> Option<[f64; 2]> {
        match self {
            Self::Named(DirectionName::Up) => Some([0.0, 1.0]),
            Self::Named(DirectionName::Down) => Some([0.0, -1.0]),
            Self::Named(DirectionName::Left) => Some([-1.0, 0.0]),
            Self::Named(DirectionName::Right) => Some([1.0, 0.0]),
            Self::Named(DirectionName::Stop) => None,
            Self::Vector(v) => Some(v),
        }
    }

    /// Whether it is a direction. A unit vector may be longer than 1 by its rounding.
    pub fn check(self) -> Result<(), CommandFault> {
        let Self::Vector([x, y]) = self else { return Ok(()) };
        // Not `>`: NaN is refused too.
        if x.abs() <= 2.0 && y.abs() <= 2.0 && x.mul_add(x, y * y).sqrt() <= 1.0 + 1e-9 {
            Ok(())
        } else {
            Err(CommandFault(format!("direction [{x}, {y}] is not a vector of length at most 1")))
        }
    }
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
