//! The state of all balls at a tick. Arrays have one entry a ball, in the order of `Roster::names`.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// All balls at one tick.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Snapshot {
    /// Changes with every start and reset of the arena, and whenever who the balls are or what the scene is was changed from
    /// outside: who sees another one asks for the world again.
    pub epoch: u64,
    /// Number of the tick since the clock began; an epoch that a reset or another scene begins has it begin at 0, any other
    /// lets it go on.
    pub tick: u64,
    /// Simulated time.
    pub time_s: f64,
    /// Wall time at the server when the tick was done, nanoseconds since 1970.
    pub wall_ns: u64,
    /// Whether the clock stands.
    pub paused: bool,
    /// Total energy: translation, rotation, height.
    pub energy_j: f64,
    /// Energy put in from outside since tick 0: by steering, and by setting, adding and removing balls or changing the scene
    /// under them. Energy less this is constant while hits are elastic.
    pub steering_work_j: f64,
    /// Ball-ball and ball-wall hits since tick 0.
    pub collisions: Collisions,
    /// Hash of everything that influences the future; 16 hexadecimal digits in JSON, where not every reader holds 64 bits.
    #[serde(with = "hex")]
    pub state_hash: u64,
    /// Parameters of the touching point.
    pub uv: Vec<[f64; 2]>,
    /// Centres.
    pub center_m: Vec<[f64; 3]>,
    /// Velocities of the centres.
    pub velocity_m_per_s: Vec<[f64; 3]>,
    /// Angular velocities.
    pub omega_rad_per_s: Vec<[f64; 3]>,
    /// Orientations, ball to world.
    pub orientation_xyzw: Vec<[f64; 4]>,
}

/// Counts of hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Collisions {
    /// Between two balls.
    pub ball_ball: u64,
    /// Between a ball and a wall.
    pub ball_wall: u64,
}

/// What does not change between ticks: who the balls are.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Roster {
    /// Unique names, in byte order.
    pub names: Vec<String>,
    /// Radii.
    pub radius_m: Vec<f64>,
    /// Masses.
    pub mass_kg: Vec<f64>,
    /// Moments of inertia over m r^2, 0 to 2/3.
    pub inertia_factor: Vec<f64>,
    /// Red, green, blue.
    pub color_rgb: Vec<[u8; 3]>,
    /// Whether a player may steer it.
    pub player: Vec<bool>,
    /// The balls that have a tag, by their places in the lists above, ascending.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub tags: BTreeMap<String, Vec<usize>>,
    /// Those that were spawned, likewise.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spawned: Vec<usize>,
}

impl Roster {
    /// The place of the ball of a name.
    pub fn place_of(&self, name: &str) -> Option<usize> {
        self.names.binary_search_by(|known| known.as_str().cmp(name)).ok()
    }

    /// Whether the ball at a place has a tag.
    pub fn is_tagged(&self, place: usize, tag: &str) -> bool {
        self.tags.get(tag).is_some_and(|places| places.binary_search(&place).is_ok())
    }

    /// Whether the ball at a place was spawned.
    pub fn is_spawned(&self, place: usize) -> bool {
        self.spawned.binary_search(&place).is_ok()
    }
}

/// Everything a late joiner needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct World {
    /// The scene as served.
    pub scene: crate::scene::Scene,
    /// Who the balls are.
    pub roster: Roster,
    /// Ticks per simulated second.
    pub tick_rate_hz: u32,
    /// The newest state.
    pub snapshot: Snapshot,
}

/// A u64 as 16 hexadecimal digits, for serde's `with`.
pub mod hex {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    /// Writes it.
    pub fn serialize<S: Serializer>(hash: &u64, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&format_args!("{hash:016x}"))
    }

    /// Reads it back.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
        let text = String::deserialize(deserializer)?;
        let digits = text.len() == 16 && text.bytes().all(|b| b.is_ascii_hexdigit());
        let hash = if digits { u64::from_str_radix(&text, 16).ok() } else { None };
        hash.ok_or_else(|| D::Error::custom("state_hash is not 16 hexadecimal digits"))
    }
}
