//! What a client may ask of a running arena, and the answer.
//!
//! A command is one line of JSON, at most 512 bytes. For a hand at the keyboard there is a short form of steering:
//! `{"key":"up"}` is one press, `{"key":"up","down":true}` a key held, `{"key":"up","down":false}` the key let go.

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

/// Most ticks of one [`Command::Step`].
pub const MAX_STEP_TICKS: u64 = 1_000_000;
/// Smallest and largest factor of [`Command::Speed`].
pub const SPEED_FACTORS: [f64; 2] = [0.01, 100.0];

/// Why a text is no command, and what would be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CommandFault(String);

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

    /// Whether its numbers make sense.
    pub fn check(&self) -> Result<(), CommandFault> {
        match self {
            Self::Steer { ball, direction, .. } => {
                if ball
                    .as_ref()
                    .is_some_and(|name| name.is_empty() || name.len() > crate::codec::MAX_BALL_NAME_BYTES)
                {
                    return Err(CommandFault("ball is a name of 1 to 64 bytes".into()));
                }
                direction.check()
            }
            Self::Step { ticks } if !(1..=MAX_STEP_TICKS).contains(ticks) => {
                Err(CommandFault(format!("ticks is {ticks}: use 1 to {MAX_STEP_TICKS}")))
            }
            Self::Speed { factor } if !(SPEED_FACTORS[0]..=SPEED_FACTORS[1]).contains(factor) => Err(
                CommandFault(format!("factor is {factor}: use {} to {}", SPEED_FACTORS[0], SPEED_FACTORS[1])),
            ),
            _ => Ok(()),
        }
    }
}

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

    /// A unit vector may be longer than 1 by its rounding.
    fn check(self) -> Result<(), CommandFault> {
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

/// The answer to a [`Command`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// Whether it was done.
    pub ok: bool,
    /// Tick at which it acted; 0 when it was refused before it came to one.
    pub tick: u64,
    /// Epoch of that tick; 0 likewise.
    pub epoch: u64,
    /// Why not, and what would do; empty when done.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub error: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steer(direction: DirectionName, mode: SteerMode) -> Command {
        Command::Steer { ball: None, direction: Direction::Named(direction), mode }
    }

    #[test]
    fn long_and_short_forms_mean_the_same() {
        let up = steer(DirectionName::Up, SteerMode::Impulse);
        assert_eq!(Command::from_json(r#"{"cmd":"steer","direction":"up"}"#).unwrap(), up);
        assert_eq!(Command::from_json(r#"{"key":"up"}"#).unwrap(), up);
        let held = steer(DirectionName::Left, SteerMode::Force);
        assert_eq!(Command::from_json(r#"{"cmd":"steer","direction":"left","mode":"force"}"#).unwrap(), held);
        assert_eq!(Command::from_json(r#"{"key":"left","down":true}"#).unwrap(), held);
        let free = steer(DirectionName::Stop, SteerMode::Force);
        assert_eq!(Command::from_json(r#"{"key":"left","down":false}"#).unwrap(), free);
    }

    #[test]
    fn every_command_survives_json() {
        let all = [
            steer(DirectionName::Stop, SteerMode::Impulse),
            Command::Steer {
                ball: Some("red".into()),
                direction: Direction::Vector([0.6, -0.8]),
                mode: SteerMode::Force,
            },
            Command::Pause {},
            Command::Resume {},
            Command::Step { ticks: 5 },
            Command::Reset {},
            Command::Speed { factor: 0.5 },
        ];
        for command in all {
            let text = serde_json::to_string(&command).unwrap();
            assert_eq!(Command::from_json(&text).unwrap(), command, "{text}");
        }
        assert_eq!(Command::from_json(r#"{"cmd":"step"}"#).unwrap(), Command::Step { ticks: 1 });
    }

    #[test]
    fn nonsense_is_refused() {
        for text in [
            "",
            "up",
            "{}",
            "[]",
            "null",
            r#"{"cmd":"fly"}"#,
            r#"{"cmd":"pause","now":true}"#,
            r#"{"cmd":"pause","key":"up"}"#,
            r#"{"cmd":"pause","cmd":"resume"}"#,
            r#"{"key":"sideways"}"#,
            r#"{"key":"up","up":true}"#,
            r#"{"cmd":"step","ticks":0}"#,
            r#"{"cmd":"step","ticks":1000001}"#,
            r#"{"cmd":"step","ticks":-1}"#,
            r#"{"cmd":"step","ticks":1.5}"#,
            r#"{"cmd":"speed","factor":0}"#,
            r#"{"cmd":"speed","factor":1e999}"#,
            r#"{"cmd":"speed","factor":"NaN"}"#,
            r#"{"cmd":"speed","factor":null}"#,
            r#"{"cmd":"steer","direction":[1,1]}"#,
            r#"{"cmd":"steer","direction":[1e308,1e308]}"#,
            r#"{"cmd":"steer","direction":[1]}"#,
            r#"{"cmd":"steer","direction":[1,0,0]}"#,
            r#"{"cmd":"steer","direction":"up","ball":""}"#,
            r#"{"cmd":"pause"} {"cmd":"pause"}"#,
        ] {
            assert!(Command::from_json(text).is_err(), "{text}");
        }
        let nan = Command::Steer {
            ball: None,
            direction: Direction::Vector([f64::NAN, 0.0]),
            mode: SteerMode::Impulse,
        };
        assert!(nan.check().is_err());
        assert!(Command::Speed { factor: f64::NAN }.check().is_err());
    }

    #[test]
    fn a_refusal_says_what_would_do() {
        let says = |text: &str| Command::from_json(text).unwrap_err().to_string();
        assert!(says(r#"{"cmd":"fly"}"#).contains("`pause`"), "{}", says(r#"{"cmd":"fly"}"#));
        assert!(says(r#"{"cmd":"steer","direction":"north"}"#).contains("\"left\""));
        assert!(says(r#"{"cmd":"speed","factor":1000}"#).contains("0.01 to 100"));
    }
}
