//! What of a run can be gone back to: its history, slots with a name, and a state as a file.

use crate::codec::MAX_REQUEST_BYTES;
use serde::{Deserialize, Serialize};

/// Most slots of an arena.
pub const MAX_SLOTS: usize = 64;
/// Longest reach of a rewind by seconds, s.
pub const MAX_REWIND_S: f64 = 1e9;
/// Longest [`SavedState::words`] in a command that is asked; a file and a recording may hold more.
pub const MAX_WORDS_BYTES: usize = MAX_REQUEST_BYTES - 16_384;
/// What a saved state says it is.
pub const SAVED_STATE_FORMAT: &str = "ballroom checkpoint";
/// Version of a saved state.
pub const SAVED_STATE_VERSION: u32 = 2;

/// What can be gone back to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timeline {
    /// By rewinding.
    pub history: HistoryEntry,
    /// By name, in the order of the names.
    pub slots: Vec<SlotEntry>,
    /// What all slots take, bytes.
    pub slots_bytes: u64,
}

/// How far a rewind reaches.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HistoryEntry {
    /// Epoch of the oldest state that can be gone back to; 0 when there is none.
    pub oldest_epoch: u64,
    /// Its tick.
    pub oldest_tick: u64,
    /// How far back that is, simulated s.
    pub reach_s: f64,
    /// Points kept.
    pub points: u64,
    /// What they and the commands between them take, bytes.
    pub bytes: u64,
    /// The most that they may take; 0 when nothing is kept.
    pub max_bytes: u64,
}

/// A state kept under a name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SlotEntry {
    /// The name.
    pub name: String,
    /// Of the scene it belongs to.
    pub scene: String,
    /// Epoch in which it was kept.
    pub epoch: u64,
    /// At which tick.
    pub tick: u64,
    /// Simulated time.
    pub time_s: f64,
    /// What it takes.
    pub bytes: u64,
}

/// A run at one tick, as text: what `simulate --save` writes and `srv/checkpoint` answers. It belongs to one scene, and
/// every bit of what follows from it is that of the run it was taken from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedState {
    /// [`SAVED_STATE_FORMAT`].
    pub format: String,
    /// [`SAVED_STATE_VERSION`].
    pub version: u32,
    /// Name of the scene, for people; the engine knows its scene by a hash.
    pub scene: String,
    /// Simulated time, for people; the words hold it to the last bit.
    pub time_s: f64,
    /// Ticks a simulated second of the arena it was taken from.
    pub tick_rate_hz: u32,
    /// The last tick there.
    pub tick: u64,
    /// Total energy when its epoch began, J.
    pub energy_at_start_j: f64,
    /// Forces that are held.
    pub held: Vec<HeldForce>,
    /// The engine's words, packed and in base64.
    pub words: String,
}

impl SavedState {
    /// What is wrong with it, if anything is; whether it fits the scene only the engine knows.
    pub fn fault(&self) -> Option<String> {
        if self.format != SAVED_STATE_FORMAT || self.version != SAVED_STATE_VERSION {
            return Some(format!(
                "it is {:?} of version {}, and {SAVED_STATE_FORMAT:?} of version {SAVED_STATE_VERSION} is read",
                self.format.chars().take(64).collect::<String>(),
                self.version
            ));
        }
        let finite = self.time_s.is_finite() && self.energy_at_start_j.is_finite();
        (!finite).then(|| "time_s and energy_at_start_j must be finite".to_owned())
    }
}

/// A force that is held on a ball.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeldForce {
    /// Which ball, by its rank among the names.
    pub ball: u32,
    /// The tick that lets go.
    pub until_tick: u64,
}

/// Where a `rewind` goes, and how it is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rewind {
    /// So many simulated seconds back along what happened, through resets and other scenes too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// To this tick, of the present count of ticks or of `epoch`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tick: Option<u64>,
    /// Of an earlier epoch that led to the present one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epoch: Option<u64>,
}

impl Rewind {
    /// So many simulated seconds back.
    pub const fn by_seconds(seconds: f64) -> Self {
        Self { seconds: Some(seconds), tick: None, epoch: None }
    }

    /// To a tick of the present count.
    pub const fn to_tick(tick: u64) -> Self {
        Self { seconds: None, tick: Some(tick), epoch: None }
    }

    /// What is wrong with it, if anything is.
    pub(crate) fn fault(&self) -> Option<String> {
        match *self {
            Self { seconds: Some(seconds), tick: None, epoch: None } => (!(0.0..=MAX_REWIND_S)
                .contains(&seconds))
            .then(|| format!("seconds is {seconds}: use 0 to 1000000000")),
            Self { seconds: None, tick: Some(_), .. } => None,
            _ => Some("give either seconds, or a tick and with it an epoch or none".to_owned()),
        }
    }
}
