//! What of a run can be gone back to: its own past, states kept under names, and states from files.
//!
//! Every simulated second the tick thread writes the run's moving words onto a page, which goes to the history's thread; it
//! packs them (two hundred bytes a ball) and keeps them as a point, with the commands obeyed in between. Going back takes
//! the point before the wanted tick, runs forward from it with the same commands, beside the running clock, and swaps the
//! outcome in: bit for bit the state that was published then, in a new epoch that goes on from its tick.
//!
//! # How far back
//!
//! As far as the memory allows that was set (`serve --history`, MiB). When it is full, points go where they lie closest:
//! within [`RECENT_S`] all gaps are alike, beyond they grow with the square of the age, so that everything farther back
//! takes no more room than the last ten minutes. The past reaches through resets and other scenes; what lies behind a
//! rewind on the line that was left is gone. When commands take more than half of the memory, the oldest go.
//!
//! | file | what |
//! |---|---|
//! | `line` | points and commands, where a rewind leads, what goes when room is short |
//! | `past` | a moment, packed; as a file |
//! | `pack` | words without their zero bytes |
//! | `store` | line and slots, and commands that go back made ready |
//! | `archive` | shared with the tick thread, which never waits |
//! | `chronicle` | the same on one thread, for a run that is replayed |

mod archive;
mod chronicle;
mod line;
mod pack;
mod past;
mod store;
#[cfg(test)]
mod tests;

pub use archive::{Archive, Diary};
pub use chronicle::Chronicle;
pub use line::Place;
pub use past::Past;
pub use store::{Plan, Store};

/// Simulated time between two points, s.
pub const POINT_EVERY_S: f64 = 1.0;
/// How far back points lie as close as any, s.
pub const RECENT_S: f64 = 600.0;
/// Most points.
pub const MAX_POINTS: usize = 4096;
/// What a history may take unless told otherwise, bytes.
pub const DEFAULT_HISTORY_BYTES: u64 = 256 << 20;
/// What all slots may take with the worlds that they belong to, bytes.
pub const MAX_SLOT_BYTES: u64 = 256 << 20;

/// How much is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// What points and commands may take, bytes; 0 for none.
    pub max_bytes: u64,
    /// Whether the oldest goes when the commands alone take too much.
    pub forgets: bool,
}

impl Settings {
    /// Of a server.
    pub const fn live(max_bytes: u64) -> Self {
        Self { max_bytes, forgets: true }
    }

    /// Of a replay, which must reach as far as whoever recorded.
    pub const REPLAY: Self = Self { max_bytes: DEFAULT_HISTORY_BYTES, forgets: false };
}

/// Ticks between two points.
pub fn point_every_ticks(tick_rate_hz: u32) -> u64 {
    (POINT_EVERY_S * f64::from(tick_rate_hz)).ceil() as u64
}
