//! The answer to a command: done at which tick, or why not.

use serde::{Deserialize, Serialize};

/// What came of a command, as numbers. Up to 5 they are those of ROS `simulation_interfaces`.
pub mod code {
    /// It was done.
    pub const OK: u16 = 1;
    /// This program does not do that.
    pub const FEATURE_UNSUPPORTED: u16 = 2;
    /// No ball or scene of that name.
    pub const NOT_FOUND: u16 = 3;
    /// Not while the clock runs, or stands, or is being stepped.
    pub const INCORRECT_STATE: u16 = 4;
    /// It was tried and cannot be done, for instance because balls would overlap.
    pub const OPERATION_FAILED: u16 = 5;
    /// No command, or numbers out of their range.
    pub const MALFORMED: u16 = 100;
    /// Too many at once: send fewer.
    pub const TOO_MANY: u16 = 101;
    /// Longer than it may be.
    pub const TOO_LONG: u16 = 102;
    /// Begun, and ended by another command before it was done.
    pub const INTERRUPTED: u16 = 103;
    /// The server ends.
    pub const ENDING: u16 = 104;
    /// The scene cannot be run; the text names line and field.
    pub const BAD_SCENE: u16 = 105;
}

/// The answer to a [`Command`](crate::command::Command).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reply {
    /// Whether it was done.
    pub ok: bool,
    /// One of [`code`].
    pub code: u16,
    /// Tick at which it acted; 0 when it was refused before it came to one.
    pub tick: u64,
    /// Epoch of that tick; 0 likewise.
    pub epoch: u64,
    /// Why not, and what would do; empty when done.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub error: String,
}

/// Why a command was not done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{why}")]
pub struct Refusal {
    /// One of [`code`].
    pub code: u16,
    /// Why, and what would do.
    pub why: String,
}

impl Refusal {
    /// With its code.
    pub fn new(code: u16, why: impl Into<String>) -> Self {
        Self { code, why: why.into() }
    }
}

impl Reply {
    /// What came of a command at a tick of an epoch.
    pub fn of(done: Result<(), Refusal>, tick: u64, epoch: u64) -> Self {
        match done {
            Ok(()) => Self { ok: true, code: code::OK, tick, epoch, error: String::new() },
            Err(Refusal { code, why }) => Self { ok: false, code, tick, epoch, error: why },
        }
    }
}

impl From<Refusal> for Reply {
    /// Before it came to a tick.
    fn from(refusal: Refusal) -> Self {
        Self::of(Err(refusal), 0, 0)
    }
}
