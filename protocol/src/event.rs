//! One hit.

use serde::{Deserialize, Serialize};

/// A hit between two balls, or between a ball and a wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// Epoch it belongs to.
    pub epoch: u64,
    /// Number of the hit since the epoch began.
    pub sequence: u64,
    /// Simulated time of impact.
    pub time_s: f64,
    /// Name of the ball.
    pub ball: String,
    /// What it hit.
    pub other: Other,
    /// Where they touched.
    pub point_m: [f64; 3],
    /// Size of the impulse along the line of contact.
    pub impulse_n_s: f64,
}

/// What a ball hit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Other {
    /// A ball by name.
    Ball(String),
    /// A wall by its number.
    Wall(u32),
}

/// All hits of the ticks since the last message, oldest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Events {
    /// The hits.
    pub events: Vec<Event>,
    /// Hits left out since the arena started because a buffer was full; their numbers are missing from `sequence`.
    pub dropped: u64,
}
