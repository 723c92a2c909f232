//! What the server says of itself once a second.

use serde::{Deserialize, Serialize};

/// Statistics of an arena.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Stats {
    /// Epoch they belong to.
    pub epoch: u64,
    /// Newest tick.
    pub tick: u64,
    /// Ticks per simulated second.
    pub tick_rate_hz: u32,
    /// Whether the clock stands.
    pub paused: bool,
    /// Simulated seconds wanted per wall second.
    pub speed_factor: f64,
    /// Whether no tick waits for the wall clock; `speed_factor` is then the one from before.
    pub as_fast_as_possible: bool,
    /// Simulated seconds reached per wall second, over the last second.
    pub real_time_factor: f64,
    /// Ticks that ended after their deadline, since the server started.
    pub overruns: u64,
    /// Wall time of one tick over the last second, median, 99th percentile, largest.
    pub tick_micros: [f64; 3],
    /// Total energy now and at the epoch's start.
    pub energy_j: [f64; 2],
    /// Hits since the epoch began.
    pub collisions: crate::snapshot::Collisions,
    /// Deepest overlap found at an impact since the epoch began.
    pub deepest_penetration_m: f64,
    /// Hits slower than the rest speed, taken without rebound.
    pub rest_hits: u64,
    /// Times a ball was held for an engine quantum because hits piled up.
    pub fallbacks: u64,
    /// Ball-seconds during which the floor would have had to pull.
    pub negative_reaction_s: f64,
    /// Integration steps taken since the epoch began.
    pub steps: u64,
    /// Commands obeyed and refused since the server started.
    pub commands_accepted: u64,
    /// Refused: malformed, oversized, non-finite, unknown, or too many; questions that were refused count too.
    pub commands_refused: u64,
    /// States published, and states overtaken by a newer one before they were sent.
    pub states_published: u64,
    /// See `states_published`.
    pub states_skipped: u64,
    /// What went out over the last second, by stream.
    pub streams: Streams,
    /// How the threads get on that share the run; none where it is in one piece.
    pub division: Option<Division>,
    /// The running error estimate, where it was asked for and balls could be followed.
    pub error_estimate: Option<ErrorEstimate>,
}

/// A run that several threads share, each with a strip of the floor and copies of the balls around it. No bit depends on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Division {
    /// Parts, a thread each.
    pub shards: u32,
    /// Balls that parts have beside their own, now.
    pub copies: u64,
    /// Phases run in parts and kept, since the run was divided.
    pub kept: u64,
    /// Phases undone and run in one piece, because what a part had no copy of could have reached it.
    pub undone: u64,
    /// Phases run in one piece at once, because the last ones were undone.
    pub in_one: u64,
}

/// How far a few balls are from shadows of theirs that are computed a hundred times more exactly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ErrorEstimate {
    /// Simulated time it is of.
    pub time_s: f64,
    /// Balls that were followed up to then. A ball's shadow begins anew after a hit with another ball and after a command.
    pub balls: u32,
    /// Largest distance of a ball's centre from its shadow's.
    pub error_m: f64,
    /// How long that shadow has followed its ball.
    pub followed_s: f64,
    /// What the scene asks for over 10 s; none where its steps are fixed.
    pub asked_m: Option<f64>,
    /// Shadows given up since the epoch began because they were a tenth of a radius away: beyond that an error of
    /// integration has no meaning.
    pub lost: u64,
}

/// What goes out, by key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Streams {
    /// States.
    pub state: Stream,
    /// Hits.
    pub event: Stream,
    /// These statistics.
    pub stats: Stream,
    /// The scene at the start of an epoch.
    pub scene: Stream,
}

impl Streams {
    /// Each with its name.
    pub const fn named(&self) -> [(&'static str, Stream); 4] {
        [("state", self.state), ("event", self.event), ("stats", self.stats), ("scene", self.scene)]
    }
}

/// What goes out under one key. It is counted once, however many read it; what nobody reads is not sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Stream {
    /// Messages a second.
    pub messages_per_s: f64,
    /// Bytes of payload a second.
    pub bytes_per_s: f64,
    /// Whether anybody reads it.
    pub is_read: bool,
}
