//! The messages of a recording, as they stand in the file.

use super::{MAX_HASH_EVERY_TICKS, RECORDING_VERSION};
use crate::arena::TICK_RATES_HZ;
use protocol::command::Command;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Name of the metadata record, and profile of the file.
pub(super) const BALLROOM: &str = "ballroom";

/// What stands before everything else.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Head {
    /// [`RECORDING_VERSION`].
    pub version: u32,
    /// Version of the program that recorded: another one may round otherwise.
    pub program: String,
    /// Ticks a simulated second.
    pub tick_rate_hz: u32,
    /// The first epoch.
    pub epoch: u64,
    /// Ticks between two hashes.
    pub hash_every_ticks: u64,
    /// Ticks between two states; 0 for none.
    pub state_every_ticks: u64,
}

impl Head {
    pub(super) fn to_metadata(&self) -> BTreeMap<String, String> {
        let Self { version, program, tick_rate_hz, epoch, hash_every_ticks, state_every_ticks } = self;
        let fields = [
            ("version", version.to_string()),
            ("program", program.clone()),
            ("tick_rate_hz", tick_rate_hz.to_string()),
            ("epoch", epoch.to_string()),
            ("hash_every_ticks", hash_every_ticks.to_string()),
            ("state_every_ticks", state_every_ticks.to_string()),
        ];
        fields.map(|(key, value)| (key.to_owned(), value)).into()
    }

    /// The version alone, which decides how the rest is read.
    pub(super) fn version_of(fields: &BTreeMap<String, String>) -> Option<u32> {
        fields.get("version")?.parse().ok()
    }

    /// None when a field is missing, is no number or is out of its range.
    pub(super) fn from_metadata(fields: &BTreeMap<String, String>) -> Option<Self> {
        let number = |key: &str| fields.get(key)?.parse::<u64>().ok();
        let head = Self {
            version: Self::version_of(fields)?,
            program: fields.get("program")?.clone(),
            tick_rate_hz: u32::try_from(number("tick_rate_hz")?).ok()?,
            epoch: number("epoch")?,
            hash_every_ticks: number("hash_every_ticks")?,
            state_every_ticks: number("state_every_ticks")?,
        };
        let sane = head.version == RECORDING_VERSION
            && TICK_RATES_HZ.contains(&head.tick_rate_hz)
            && (1..=MAX_HASH_EVERY_TICKS).contains(&head.hash_every_ticks);
        sane.then_some(head)
    }
}

/// The scene that is run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneLine {
    /// Where the text came from, for messages.
    pub file: String,
    /// The whole text.
    pub toml: String,
    /// How many balls were asked for, when it was not what the text says.
    pub balls: Option<u32>,
}

/// A command that was obeyed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CommandLine {
    /// Epoch in which it acted.
    pub epoch: u64,
    /// Tick after which it acted.
    pub tick: u64,
    /// Its number among the file's commands.
    pub order: u64,
    /// What was done.
    pub command: Command,
}

/// The state hash at a tick, before the commands of that tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HashLine {
    /// Epoch of the tick.
    pub epoch: u64,
    /// The tick.
    pub tick: u64,
    /// As in a state.
    #[serde(with = "protocol::snapshot::hex")]
    pub state_hash: u64,
}

/// How the recording ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EndLine {
    /// Epoch of the last tick.
    pub epoch: u64,
    /// The last tick that is recorded.
    pub tick: u64,
    /// Of the very last state, after all commands; in an incomplete recording that of the last recorded tick.
    #[serde(with = "protocol::snapshot::hex")]
    pub state_hash: u64,
    /// Commands recorded.
    pub commands: u64,
    /// Hashes recorded, without this one.
    pub hashes: u64,
    /// States recorded.
    pub states: u64,
    /// States that were due and found the recorder busy.
    pub states_dropped: u64,
    /// Whether everything is there from the start to the server's end.
    pub complete: bool,
    /// Why not; empty when complete.
    pub why: String,
}
