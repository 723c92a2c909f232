//! Frames, units and versions, for whoever asks.

use serde::{Deserialize, Serialize};

/// What a reader has to know to read everything else.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Info {
    /// The program.
    pub program: String,
    /// Its version.
    pub version: String,
    /// Which arena answers.
    pub arena: String,
    /// Version of the keys.
    pub wire_version: u32,
    /// Version of the binary frames.
    pub frame_version: u32,
    /// Version of scene files.
    pub scene_version: u32,
    /// The world's axes.
    pub frame: String,
    /// Units of everything whose name does not say it.
    pub units: String,
    /// Order and direction of quaternions.
    pub orientation: String,
    /// How to read the binary frames.
    pub encoding: String,
    /// Ticks a simulated second.
    pub tick_rate_hz: u32,
}

impl Info {
    /// Of an arena, as this crate defines the rest.
    pub fn new(arena: &str, tick_rate_hz: u32) -> Self {
        Self {
            program: "ballroom".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            arena: arena.into(),
            wire_version: 1,
            frame_version: crate::codec::FRAME_VERSION,
            scene_version: crate::scene::SCENE_VERSION,
            frame: "right-handed, x east, y north, z up; origin as in the scene".into(),
            units: "SI: m, s, kg, rad; each name ends in its unit".into(),
            orientation: "unit quaternions x, y, z, w that turn ball coordinates into world coordinates"
                .into(),
            encoding:
                "state and srv/snapshot: CBOR maps with RFC 8746 typed arrays, tag 86 = f64 and 85 = f32, \
                       little endian, row-major; everything else JSON, those too with ?format=json"
                    .into(),
            tick_rate_hz,
        }
    }
}
