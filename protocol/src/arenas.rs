//! Several arenas in one process: what may be asked of the process, and what it tells.
//!
//! The keys are [`COMMAND_KEY`] and [`LIST_KEY`]. No arena can be named as their third chunk is, and no wildcard for an
//! arena's name matches it, so that a rule that lets in players does not let in those who start and stop arenas.

use crate::codec::{CodecError, MAX_BALLS, MAX_REQUEST_BYTES};
use crate::command::CommandFault;
use crate::keys::Name;
use crate::state::RunState;
use serde::{Deserialize, Serialize};

/// Commands to the process, answered with a [`Reply`](crate::reply::Reply).
pub const COMMAND_KEY: &str = "ballroom/v1/@arenas/command";
/// Which arenas there are.
pub const LIST_KEY: &str = "ballroom/v1/@arenas/list";
/// Most arenas of one process.
pub const MAX_ARENAS: usize = 32;
/// Ticks a simulated second that an arena may have.
pub const TICK_RATES_HZ: std::ops::RangeInclusive<u32> = 1..=1000;

/// What the process may be asked to do. In JSON: `{"cmd":"start","arena":"left","scene":"bowl"}`,
/// `{"cmd":"stop","arena":"left"}`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "cmd", rename_all = "snake_case", deny_unknown_fields)]
pub enum ArenaCommand {
    /// Run one more arena; answered when it can be reached.
    Start {
        /// Its name, which no other has.
        arena: Name,
        /// One of the scenes that come with the program.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        scene: Option<String>,
        /// A scene as it stands in a file.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        toml: Option<String>,
        /// Balls in all, for a scene with one cloud.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        balls: Option<u32>,
        /// Ticks a simulated second.
        #[serde(default = "sixty")]
        tick_rate_hz: u32,
        /// Whether to begin with the clock standing.
        #[serde(default)]
        paused: bool,
        /// Whether to record it beside the server's own recording.
        #[serde(default)]
        record: bool,
    },
    /// End an arena; answered when it has ended.
    Stop {
        /// Which.
        arena: Name,
    },
}

const fn sixty() -> u32 {
    60
}

impl ArenaCommand {
    /// Reads and checks one line of JSON.
    pub fn from_json(bytes: &[u8]) -> Result<Self, CodecError> {
        if bytes.len() > MAX_REQUEST_BYTES {
            return Err(CodecError::TooLong { bytes: bytes.len(), limit: MAX_REQUEST_BYTES });
        }
        let command: Self =
            serde_json::from_slice(bytes).map_err(|e| CodecError::Malformed(e.to_string()))?;
        command.check()?;
        Ok(command)
    }

    /// Whether its numbers make sense.
    pub fn check(&self) -> Result<(), CommandFault> {
        let Self::Start { scene, toml, balls, tick_rate_hz, .. } = self else { return Ok(()) };
        if scene.is_some() == toml.is_some() {
            return Err(CommandFault::new("give either the name of a scene or its toml"));
        }
        if !TICK_RATES_HZ.contains(tick_rate_hz) {
            let (low, high) = (TICK_RATES_HZ.start(), TICK_RATES_HZ.end());
            return Err(CommandFault::new(format!("tick_rate_hz is {tick_rate_hz}: use {low} to {high}")));
        }
        if balls.is_some_and(|balls| balls as usize > MAX_BALLS) {
            return Err(CommandFault::new(format!("at most {MAX_BALLS} balls")));
        }
        Ok(())
    }

    /// Which arena is meant.
    pub const fn arena(&self) -> &Name {
        match self {
            Self::Start { arena, .. } | Self::Stop { arena } => arena,
        }
    }
}

/// The arenas of a process, in the order of their names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Arenas {
    /// One by one.
    pub arenas: Vec<ArenaRow>,
    /// How many there may be.
    pub max_arenas: usize,
}

/// One of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArenaRow {
    /// Its name in the keys.
    pub arena: String,
    /// The scene it runs.
    pub scene: String,
    /// What its clock does.
    pub state: RunState,
    /// Epoch of the newest tick.
    pub epoch: u64,
    /// The newest tick.
    pub tick: u64,
    /// Simulated time.
    pub time_s: f64,
    /// Ticks a simulated second.
    pub tick_rate_hz: u32,
    /// How many balls.
    pub balls: usize,
    /// Whether it is recorded.
    pub recorded: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reads(text: &str) -> Result<ArenaCommand, CodecError> {
        ArenaCommand::from_json(text.as_bytes())
    }

    #[test]
    fn a_command_to_the_process_survives_json() {
        let start = reads(r#"{"cmd":"start","arena":"left","scene":"bowl"}"#).unwrap();
        let ArenaCommand::Start { tick_rate_hz: 60, paused: false, record: false, .. } = &start else {
            panic!("{start:?}")
        };
        let full = ArenaCommand::Start {
            arena: "right".parse().unwrap(),
            scene: None,
            toml: Some("version = 1".into()),
            balls: Some(40),
            tick_rate_hz: 240,
            paused: true,
            record: true,
        };
        for command in [start, full, ArenaCommand::Stop { arena: "left".parse().unwrap() }] {
            assert_eq!(reads(&serde_json::to_string(&command).unwrap()).unwrap(), command);
        }
    }

    #[test]
    fn a_name_that_is_none_and_a_rate_out_of_range_are_refused() {
        for bad in [
            r#"{"cmd":"stop"}"#,
            r#"{"cmd":"stop","arena":"@arenas"}"#,
            r#"{"cmd":"stop","arena":"a/b"}"#,
            r#"{"cmd":"stop","arena":"a","now":true}"#,
            r#"{"cmd":"start","arena":"a"}"#,
            r#"{"cmd":"start","arena":"a","scene":"bowl","toml":""}"#,
            r#"{"cmd":"start","arena":"a","scene":"bowl","tick_rate_hz":0}"#,
            r#"{"cmd":"start","arena":"a","scene":"bowl","tick_rate_hz":1001}"#,
            r#"{"cmd":"start","arena":"a","scene":"gas","balls":100001}"#,
        ] {
            assert!(reads(bad).is_err(), "{bad}");
        }
        assert!(matches!(reads(&" ".repeat(MAX_REQUEST_BYTES + 1)), Err(CodecError::TooLong { .. })));
    }
}
