//! Recordings: what a run was given, so that it can be run again, and what became of it, so that the two can be
//! compared.
//!
//! # What a run is a function of
//!
//! The scene as text with the number of balls asked for (its clouds carry their seeds), the tick rate, and the commands
//! by tick in their order. Everything else follows: a held force ends by the count of ticks, a reset returns to the
//! scene and begins the next epoch; the seed of a reset, other places of balls and another scene as text stand in their
//! commands. A scene loaded by name is the one of that name in the program that replays;
//! one read again from its file is recorded as the text that was read. A rewind stands there with the
//! epoch and tick that it went to, and a replay keeps a history of its own to go back in; slots are filled and read as
//! they were. Wall time, pauses, the speed of the clock and who asked are no part of it; commands
//! to the clock are recorded all the same, because they tell what happened. Refused commands leave no trace in a run,
//! nor here.
//!
//! # The file, version 1
//!
//! An [MCAP](https://mcap.dev/spec) file of profile `ballroom`, uncompressed, in chunks with checksums and an index.
//! Its one metadata record, `ballroom`, is written first: [`Head`]. Then messages, stamped with wall time:
//!
//! | topic | encoding | when | fields |
//! |---|---|---|---|
//! | `scene` | JSON | once (a later one stands in its command), before all others | `file`, `toml`, `balls` |
//! | `command` | JSON | when it acted | `epoch`, `tick`, `order`, `command` |
//! | `hash` | JSON | at tick 0 of an epoch and every `hash_every_ticks` | `epoch`, `tick`, `state_hash` |
//! | `state` | CBOR | every `state_every_ticks` | the frame of [`protocol::codec`] |
//! | `end` | JSON | last | `epoch`, `tick`, `state_hash`, counts, `complete`, `why` |
//!
//! A hash at a tick is that of the state before the commands of that tick; `order` counts the commands of the file.
//!
//! # Faults
//!
//! Chunks are closed and given to the system every [`FLUSH_EVERY`]: a server that is killed loses less than a second, and
//! the file before stays readable (a power cut may cost what the system had not written yet). The tick thread never
//! waits for the file: when [`TAPE_CAPACITY`] entries are not enough, the recording ends there, and the log and the `end`
//! message say `incomplete`. Only states may be missing from a complete recording; they are counted.
//!
//! | file | what |
//! |---|---|
//! | `lines` | the messages |
//! | `tape` | from the tick thread to the recorder: bounded, without waiting or allocating |
//! | `recorder` | the thread that writes |
//! | `reader` | a file, message by message, refused where it is damaged |
//! | `replay` | the run again, compared |

mod lines;
mod reader;
mod recorder;
mod replay;
mod tape;

pub use lines::{CommandLine, EndLine, HashLine, Head, SceneLine};
pub use reader::{Line, Reader, RecordingFault};
pub use recorder::{Recorder, RecordingError};
pub(crate) use replay::obey;
pub use replay::{Audience, Difference, Ending, ReplayError, Verdict, begin, replay, replay_before};
pub use tape::Tape;

use std::path::PathBuf;
use std::time::Duration;

/// Version of the file.
pub const RECORDING_VERSION: u32 = 1;
/// Entries that wait for the recorder: 18 minutes of ticks at 60 Hz.
pub const TAPE_CAPACITY: usize = 1 << 16;
/// Time between two chunks at most.
pub const FLUSH_EVERY: Duration = Duration::from_millis(500);
/// Size at which a chunk is closed before its time.
pub const CHUNK_BYTES: u64 = 1 << 20;
/// Size at which a recording ends as incomplete: a disk must not fill up unseen.
pub const MAX_FILE_BYTES: u64 = 64 << 30;
/// Most ticks between two hashes, which is the longest that a reader runs without a record.
pub const MAX_HASH_EVERY_TICKS: u64 = 10_000;

/// What to record, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordOptions {
    /// The file, which must not exist.
    pub file: PathBuf,
    /// Ticks between two hashes, 1 to [`MAX_HASH_EVERY_TICKS`].
    pub hash_every_ticks: u64,
    /// States a simulated second; 0 for none. No more than there are ticks.
    pub states_hz: u32,
}

impl RecordOptions {
    /// Every tick hashed, ten states a second.
    pub const fn new(file: PathBuf) -> Self {
        Self { file, hash_every_ticks: 1, states_hz: 10 }
    }

    /// Ticks between two states; 0 for none.
    const fn state_every_ticks(&self, tick_rate_hz: u32) -> u64 {
        if self.states_hz == 0 {
            return 0;
        }
        let every = tick_rate_hz / self.states_hz;
        if every == 0 { 1 } else { every as u64 }
    }
}

#[cfg(test)]
mod tests;
