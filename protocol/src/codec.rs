//! Bytes to values and back; every limit on size stands here.
//!
//! # Binary frames, version 1
//!
//! A frame is one CBOR item (RFC 8949): a map of text keys, `"v": 1` first. An array over the balls is one byte
//! string under an RFC 8746 tag, row-major without padding: tag 86 is f64, tag 85 f32, both little endian. Python's
//! `cbor2` gives `CBORTag(86, b"…")`, and `numpy.frombuffer(tag.value, "<f8").reshape(-1, 3)` views it in place.
//!
//! | key | type | unit | per ball | on `state` | in `srv/snapshot` |
//! |---|---|---|---|---|---|
//! | `v` | unsigned | | | 1 | 1 |
//! | `epoch`, `tick` | unsigned | | | | |
//! | `time_s` | f64 | s | | | |
//! | `wall_ns` | unsigned | ns since 1970 | | | |
//! | `paused` | bool | | | | |
//! | `energy_j`, `steering_work_j` | f64 | J | | | |
//! | `collisions` | map `ball_ball`, `ball_wall` | hits | | | |
//! | `state_hash` | unsigned, 64 bits | | | | |
//! | `uv` | typed array | | 2 | f64 | f64 |
//! | `center_m` | typed array | m | 3 | f64 | f64 |
//! | `velocity_m_per_s` | typed array | m/s | 3 | f32 | f64 |
//! | `omega_rad_per_s` | typed array | rad/s | 3 | f32 | f64 |
//! | `orientation_xyzw` | typed array | ball to world | 4 | f32 | f64 |
//!
//! `srv/snapshot` answers with the map `{"v": 1, "scene", "roster", "tick_rate_hz", "snapshot"}`, where `snapshot` is
//! such a frame as a nested map and the others are shaped as in JSON.
//!
//! Everything else on the wire, and a frame on request, is JSON; there `state_hash` is 16 hexadecimal digits.
//!
//! A decoder takes nothing it does not understand: unknown or missing keys, other tags, arrays of unequal length,
//! numbers that are not finite and bytes after the end are errors. It allocates no more than a small multiple of its input.

use crate::command::{Command, CommandFault};
use crate::event::Events;
use crate::scene::MAX_TAGS;
use crate::snapshot::{Collisions, Snapshot, World};
use crate::timeline::SavedState;
use ciborium::tag::Captured;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_bytes::{ByteBuf, Bytes};

/// Version of the binary frames.
pub const FRAME_VERSION: u32 = 1;
/// Most balls of an arena.
pub const MAX_BALLS: usize = 100_000;
/// Longest state frame: 80 bytes a ball, and room to spare.
pub const MAX_STATE_BYTES: usize = 9 << 20;
/// Longest world: 120 bytes a ball for its state, the rest for names and the scene.
pub const MAX_WORLD_BYTES: usize = 64 << 20;
/// Longest command, but for those that are asked and carry a list or a text.
pub const MAX_COMMAND_BYTES: usize = 512;
/// Longest of those.
pub const MAX_REQUEST_BYTES: usize = 512 << 10;
/// Most hits in one message; the rest is counted as dropped.
pub const MAX_EVENTS: usize = 4096;
/// Longest JSON message other than a command or a world.
pub const MAX_JSON_BYTES: usize = 4 << 20;
/// Longest name of a ball.
pub const MAX_BALL_NAME_BYTES: usize = 64;
/// Deepest nesting in a binary frame; a scene needs seven.
const MAX_DEPTH: usize = 16;

const TAG_F32_LE: u64 = 85;
const TAG_F64_LE: u64 = 86;

// Every array of a largest frame, the fixed fields and the keys fit.
const _: () = assert!(MAX_BALLS * 80 + 4096 <= MAX_STATE_BYTES);
const _: () =
    assert!(MAX_BALLS * (120 + 2 * MAX_BALL_NAME_BYTES + 200 + 9 * (MAX_TAGS + 1)) <= MAX_WORLD_BYTES);

/// Why bytes were refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CodecError {
    /// Too long to look at.
    #[error("{bytes} bytes are too many: at most {limit} are read")]
    TooLong {
        /// How long.
        bytes: usize,
        /// What is read.
        limit: usize,
    },
    /// No CBOR or JSON of the expected shape.
    #[error("not understood: {0}")]
    Malformed(String),
    /// Another version of the format.
    #[error("frame version {0}, this program reads version {FRAME_VERSION}: use programs of one release")]
    Version(u32),
    /// An array that does not fit the others.
    #[error("{field} {what}")]
    Array {
        /// Which.
        field: &'static str,
        /// What is wrong.
        what: &'static str,
    },
    /// A number that is not finite.
    #[error("{0} holds a number that is not finite")]
    NotFinite(&'static str),
    /// A command that makes no sense.
    #[error(transparent)]
    Command(#[from] CommandFault),
}

/// A [`Snapshot`] as it stands in a frame.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Frame<B> {
    v: u32,
    epoch: u64,
    tick: u64,
    time_s: f64,
    wall_ns: u64,
    paused: bool,
    energy_j: f64,
    steering_work_j: f64,
    collisions: Collisions,
    state_hash: u64,
    uv: Captured<B>,
    center_m: Captured<B>,
    velocity_m_per_s: Captured<B>,
    omega_rad_per_s: Captured<B>,
    orientation_xyzw: Captured<B>,
}

/// How exact the velocities and orientations of a frame are; places are always f64.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Width {
    Single,
    Double,
}

/// The state frame of `snapshot`, replacing what `out` held.
pub fn encode_state(snapshot: &Snapshot, out: &mut Vec<u8>) {
    out.clear();
    let arrays = Arrays::of(snapshot, Width::Single);
    ciborium::into_writer(&arrays.frame(snapshot), out).expect("a vector takes every byte");
}

/// A snapshot back from its frame of either width.
pub fn decode_state(bytes: &[u8]) -> Result<Snapshot, CodecError> {
    from_cbor::<Frame<ByteBuf>>(bytes, MAX_STATE_BYTES)?.into_snapshot()
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WorldFrame {
    v: u32,
    scene: crate::scene::Scene,
    roster: crate::snapshot::Roster,
    tick_rate_hz: u32,
    snapshot: Frame<ByteBuf>,
}

/// The full-width frame of a world.
pub fn encode_world(world: &World) -> Vec<u8> {
    WorldHead::new(&world.scene, &world.roster, world.tick_rate_hz).with(&world.snapshot)
}

/// The part of a world's frame that no tick changes, encoded once for all who ask: it takes longer than the state does.
pub struct WorldHead(Vec<u8>);

/// The first fields of a [`WorldFrame`].
#[derive(Serialize)]
struct HeadFrame<'a> {
    v: u32,
    scene: &'a crate::scene::Scene,
    roster: &'a crate::snapshot::Roster,
    tick_rate_hz: u32,
}

/// A CBOR map of so many pairs begins with this byte more.
const CBOR_MAP: u8 = 0xa0;
/// Pairs of a [`HeadFrame`] and of a [`WorldFrame`].
const PAIRS: [u8; 2] = [4, 5];

impl WorldHead {
    /// Of a scene with its balls.
    pub fn new(scene: &crate::scene::Scene, roster: &crate::snapshot::Roster, tick_rate_hz: u32) -> Self {
        let mut bytes = cbor(&HeadFrame { v: FRAME_VERSION, scene, roster, tick_rate_hz });
        assert_eq!(bytes[0], CBOR_MAP + PAIRS[0], "a struct is a short map");
        bytes[0] = CBOR_MAP + PAIRS[1];
        bytes.append(&mut cbor(&"snapshot"));
        Self(bytes)
    }

    /// The full-width frame of the world in this state.
    pub fn with(&self, snapshot: &Snapshot) -> Vec<u8> {
        let arrays = Arrays::of(snapshot, Width::Double);
        let mut out = Vec::with_capacity(self.0.len() + 1024 + snapshot.center_m.len() * 128);
        out.extend_from_slice(&self.0);
        ciborium::into_writer(&arrays.frame(snapshot), &mut out).expect("a vector takes every byte");
        out
    }
}

fn cbor<T: Serialize>(value: &T) -> Vec<u8> {
    let mut out = Vec::new();
    ciborium::into_writer(value, &mut out).expect("a vector takes every byte");
    out
}

/// A world back from its frame.
pub fn decode_world(bytes: &[u8]) -> Result<World, CodecError> {
    let frame: WorldFrame = from_cbor(bytes, MAX_WORLD_BYTES)?;
    if frame.v != FRAME_VERSION {
        return Err(CodecError::Version(frame.v));
    }
    let world = World {
        scene: frame.scene,
        roster: frame.roster,
        tick_rate_hz: frame.tick_rate_hz,
        snapshot: frame.snapshot.into_snapshot()?,
    };
    check_world(&world)?;
    Ok(world)
}

fn check_world(world: &World) -> Result<(), CodecError> {
    let n = world.snapshot.center_m.len();
    let r = &world.roster;
    let numbers = [&r.radius_m, &r.mass_kg, &r.inertia_factor];
    let lengths = [r.names.len(), r.color_rgb.len(), r.player.len()];
    if lengths.into_iter().chain(numbers.map(Vec::len)).any(|length| length != n) {
        return Err(CodecError::Array { field: "roster", what: "has not one entry a ball" });
    }
    if r.names.iter().any(|name| name.len() > MAX_BALL_NAME_BYTES) {
        return Err(CodecError::Array { field: "roster.names", what: "holds a name of more than 64 bytes" });
    }
    let places = r.tags.values().flatten().chain(&r.spawned);
    if places.copied().any(|place| place >= n) {
        return Err(CodecError::Array { field: "roster.tags", what: "names a ball that is not there" });
    }
    if !numbers.into_iter().flatten().all(|x| x.is_finite()) {
        return Err(CodecError::NotFinite("roster"));
    }
    // The scene is a tree of many kinds of numbers; as a plain value they are all alike.
    let scene =
        ciborium::Value::serialized(&world.scene).map_err(|e| CodecError::Malformed(e.to_string()))?;
    if is_finite(&scene) { Ok(()) } else { Err(CodecError::NotFinite("scene")) }
}

/// As deep as the scene's own types, hence bounded.
fn is_finite(value: &ciborium::Value) -> bool {
    match value {
        ciborium::Value::Float(x) => x.is_finite(),
        ciborium::Value::Array(items) => items.iter().all(is_finite),
        ciborium::Value::Map(pairs) => pairs.iter().all(|(_, item)| is_finite(item)),
        _ => true,
    }
}

/// A command from one line of JSON.
pub fn decode_command(bytes: &[u8]) -> Result<Command, CodecError> {
    check_length(bytes, MAX_REQUEST_BYTES)?;
    let text = std::str::from_utf8(bytes).map_err(|e| CodecError::Malformed(e.to_string()))?;
    let command = Command::from_json(text)?;
    check_length(bytes, command.max_bytes())?;
    Ok(command)
}

/// Hits from JSON.
pub fn decode_events(bytes: &[u8]) -> Result<Events, CodecError> {
    let events: Events = decode_json(bytes)?;
    if events.events.len() > MAX_EVENTS {
        return Err(CodecError::Array { field: "events", what: "holds more than 4096 hits" });
    }
    Ok(events)
}

/// Anything but a command or a frame from JSON, which cannot carry a number that is not finite.
pub fn decode_json<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, CodecError> {
    check_length(bytes, MAX_JSON_BYTES)?;
    serde_json::from_slice(bytes).map_err(|e| CodecError::Malformed(e.to_string()))
}

/// A saved state from JSON; of many balls it is long.
pub fn decode_saved_state(bytes: &[u8]) -> Result<SavedState, CodecError> {
    check_length(bytes, MAX_WORLD_BYTES)?;
    let saved: SavedState =
        serde_json::from_slice(bytes).map_err(|e| CodecError::Malformed(e.to_string()))?;
    saved.fault().map_or(Ok(saved), |why| Err(CodecError::Malformed(why)))
}

/// Anything as one line of JSON. The types of this crate all have text keys, so it cannot fail for them.
pub fn encode_json<T: Serialize>(value: &T) -> Vec<u8> {
    serde_json::to_vec(value).expect("the words of the wire are JSON")
}

fn from_cbor<T: DeserializeOwned>(bytes: &[u8], limit: usize) -> Result<T, CodecError> {
    check_length(bytes, limit)?;
    let mut rest = bytes;
    let value = ciborium::de::from_reader_with_recursion_limit(&mut rest, MAX_DEPTH)
        .map_err(|e| CodecError::Malformed(e.to_string()))?;
    if rest.is_empty() {
        Ok(value)
    } else {
        Err(CodecError::Malformed(format!("{} bytes after the end", rest.len())))
    }
}

fn check_length(bytes: &[u8], limit: usize) -> Result<(), CodecError> {
    if bytes.len() > limit { Err(CodecError::TooLong { bytes: bytes.len(), limit }) } else { Ok(()) }
}

/// The arrays of a snapshot as bytes.
struct Arrays {
    uv: Vec<u8>,
    center: Vec<u8>,
    velocity: Vec<u8>,
    omega: Vec<u8>,
    orientation: Vec<u8>,
    width: Width,
}

impl Arrays {
    fn of(snapshot: &Snapshot, width: Width) -> Self {
        Self {
            uv: to_bytes(&snapshot.uv, Width::Double),
            center: to_bytes(&snapshot.center_m, Width::Double),
            velocity: to_bytes(&snapshot.velocity_m_per_s, width),
            omega: to_bytes(&snapshot.omega_rad_per_s, width),
            orientation: to_bytes(&snapshot.orientation_xyzw, width),
            width,
        }
    }

    fn frame<'a>(&'a self, snapshot: &Snapshot) -> Frame<&'a Bytes> {
        let tag = if self.width == Width::Single { TAG_F32_LE } else { TAG_F64_LE };
        let places = |bytes: &'a [u8]| Captured(Some(TAG_F64_LE), Bytes::new(bytes));
        let others = |bytes: &'a [u8]| Captured(Some(tag), Bytes::new(bytes));
        Frame {
            v: FRAME_VERSION,
            epoch: snapshot.epoch,
            tick: snapshot.tick,
            time_s: snapshot.time_s,
            wall_ns: snapshot.wall_ns,
            paused: snapshot.paused,
            energy_j: snapshot.energy_j,
            steering_work_j: snapshot.steering_work_j,
            collisions: snapshot.collisions,
            state_hash: snapshot.state_hash,
            uv: places(&self.uv),
            center_m: places(&self.center),
            velocity_m_per_s: others(&self.velocity),
            omega_rad_per_s: others(&self.omega),
            orientation_xyzw: others(&self.orientation),
        }
    }
}

fn to_bytes<const N: usize>(rows: &[[f64; N]], width: Width) -> Vec<u8> {
    let numbers = rows.as_flattened().iter();
    match width {
        Width::Double => numbers.flat_map(|x| x.to_le_bytes()).collect(),
        Width::Single => numbers.flat_map(|x| (*x as f32).to_le_bytes()).collect(),
    }
}

impl Frame<ByteBuf> {
    fn into_snapshot(self) -> Result<Snapshot, CodecError> {
        if self.v != FRAME_VERSION {
            return Err(CodecError::Version(self.v));
        }
        if ![self.time_s, self.energy_j, self.steering_work_j].iter().all(|x| x.is_finite()) {
            return Err(CodecError::NotFinite("time_s, energy_j or steering_work_j"));
        }
        let center_m = from_bytes("center_m", &self.center_m, None)?;
        let n = Some(center_m.len());
        Ok(Snapshot {
            epoch: self.epoch,
            tick: self.tick,
            time_s: self.time_s,
            wall_ns: self.wall_ns,
            paused: self.paused,
            energy_j: self.energy_j,
            steering_work_j: self.steering_work_j,
            collisions: self.collisions,
            state_hash: self.state_hash,
            uv: from_bytes("uv", &self.uv, n)?,
            velocity_m_per_s: from_bytes("velocity_m_per_s", &self.velocity_m_per_s, n)?,
            omega_rad_per_s: from_bytes("omega_rad_per_s", &self.omega_rad_per_s, n)?,
            orientation_xyzw: from_bytes("orientation_xyzw", &self.orientation_xyzw, n)?,
            center_m,
        })
    }
}

/// `rows` rows of N numbers each; any number of them up to [`MAX_BALLS`] when not given.
fn from_bytes<const N: usize>(
    field: &'static str,
    array: &Captured<ByteBuf>,
    rows: Option<usize>,
) -> Result<Vec<[f64; N]>, CodecError> {
    let width = match array.0 {
        Some(TAG_F64_LE) => 8,
        Some(TAG_F32_LE) => 4,
        _ => return Err(CodecError::Array { field, what: "carries neither tag 85 nor tag 86" }),
    };
    let bytes = array.1.as_slice();
    let count = bytes.len() / (width * N);
    if !bytes.len().is_multiple_of(width * N) || rows.is_some_and(|rows| rows != count) {
        return Err(CodecError::Array { field, what: "has not one entry a ball" });
    }
    if count > MAX_BALLS {
        return Err(CodecError::Array { field, what: "has more than 100000 balls" });
    }
    let mut out = vec![[0.0; N]; count];
    for (number, chunk) in out.as_flattened_mut().iter_mut().zip(bytes.chunks_exact(width)) {
        *number = match <[u8; 8]>::try_from(chunk) {
            Ok(chunk) => f64::from_le_bytes(chunk),
            Err(_) => f64::from(f32::from_le_bytes([chunk[0], chunk[1], chunk[2], chunk[3]])),
        };
    }
    if out.as_flattened().iter().all(|x| x.is_finite()) { Ok(out) } else { Err(CodecError::NotFinite(field)) }
}

#[cfg(test)]
#[path = "codec_tests.rs"]
mod tests;
