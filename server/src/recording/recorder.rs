//! The thread that writes a recording.

use super::lines::BALLROOM;
use super::tape::{Entry, Shared, Stamped};
use super::{
    CHUNK_BYTES, EndLine, FLUSH_EVERY, HashLine, Head, MAX_FILE_BYTES, MAX_HASH_EVERY_TICKS,
    RECORDING_VERSION, RecordOptions, SceneLine, TAPE_CAPACITY, Tape,
};
use crate::simulation::Simulation;
use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, WriteOptions, Writer};
use protocol::codec;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Seek, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Time between two looks at the tape: nothing wakes this thread, which costs the tick thread nothing.
const POLL: Duration = Duration::from_millis(20);
/// The program's version, for the head.
const PROGRAM: &str = env!("CARGO_PKG_VERSION");

/// Why a recording cannot be begun.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file cannot be made.
    #[error("{}: {why}; name a file that does not exist yet, in a directory that does", file.display())]
    Create {
        /// Which.
        file: PathBuf,
        /// What the system says.
        why: std::io::Error,
    },
    /// It cannot be written.
    #[error("the recording cannot be written: {0}")]
    Write(#[from] McapError),
    /// A number is out of its range.
    #[error("a hash every {0} ticks is out of range: use 1 to {MAX_HASH_EVERY_TICKS}")]
    HashEvery(u64),
}

/// A recording being written; [`Recorder::run`] is its thread.
pub struct Recorder {
    shared: Shared,
    out: Out<BufWriter<File>>,
    file: PathBuf,
}

impl Recorder {
    /// Makes the file, writes what is known before the first tick, and gives the tick thread's end of the tape.
    pub fn create(options: &RecordOptions, simulation: &Simulation) -> Result<(Self, Tape), RecordingError> {
        if !(1..=MAX_HASH_EVERY_TICKS).contains(&options.hash_every_ticks) {
            return Err(RecordingError::HashEvery(options.hash_every_ticks));
        }
        let head = Head {
            version: RECORDING_VERSION,
            program: PROGRAM.to_owned(),
            tick_rate_hz: simulation.tick_rate_hz(),
            epoch: simulation.epoch(),
            hash_every_ticks: options.hash_every_ticks,
            state_every_ticks: options.state_every_ticks(simulation.tick_rate_hz()),
        };
        let file = options.file.clone();
        let created = File::create_new(&file);
        let created = created.map_err(|why| RecordingError::Create { file: file.clone(), why })?;
        let source = simulation.loaded().source();
        let scene = SceneLine {
            file: source.file().to_owned(),
            toml: source.text().to_owned(),
            balls: source.balls(),
        };
        let out = Out::begin(BufWriter::new(created), &head, &scene)?;
        let (tape, shared) = Tape::new(&head, simulation);
        Ok((Self { shared, out, file }, tape))
    }

    /// Writes until the tick loop has ended or the recording cannot go on. The arena goes on in either case.
    pub fn run(mut self) {
        let file = self.file.display().to_string();
        match self.write_all() {
            Ok(end) if end.complete => {
                let EndLine { commands, hashes, states, states_dropped, .. } = end;
                tracing::info!(
                    "recorded {commands} commands, {hashes} hashes and {states} states in {file}; \
                     {states_dropped} states found the recorder busy"
                );
            }
            Ok(end) => tracing::error!(
                "the recording {file} is INCOMPLETE: it ends at tick {} of epoch {}, because {}",
                end.tick,
                end.epoch,
                end.why
            ),
            Err(e) => tracing::error!("the recording {file} is INCOMPLETE: it cannot be written: {e}"),
        }
        self.shared.lock().closed = true;
    }

    fn write_all(&mut self) -> Result<EndLine, McapError> {
        let mut entries = Vec::with_capacity(TAPE_CAPACITY);
        let mut flushed = Instant::now();
        loop {
            let mut shelf = self.shared.lock();
            std::mem::swap(&mut shelf.entries, &mut entries);
            let (over, overrun) = (shelf.closed || shelf.overrun, shelf.overrun);
            self.out.states_dropped = shelf.states_dropped;
            drop(shelf);
            for stamped in entries.drain(..) {
                if let Some(buffer) = self.out.write(stamped)? {
                    self.shared.lock().spare.push(buffer);
                }
            }
            let why = if overrun {
                "the recorder fell behind"
            } else if self.out.bytes > MAX_FILE_BYTES {
                "the file has reached its greatest size"
            } else if over {
                "the tick loop ended by a fault"
            } else {
                if flushed.elapsed() >= FLUSH_EVERY {
                    self.out.writer.flush()?;
                    flushed = Instant::now();
                }
                std::thread::sleep(POLL);
                continue;
            };
            return self.out.end(why);
        }
    }
}

/// The file, with what is counted.
struct Out<W: Write + Seek> {
    writer: Writer<W>,
    channels: Channels,
    /// Bytes of all messages.
    bytes: u64,
    commands: u64,
    hashes: u64,
    states: u64,
    states_dropped: u64,
    last: Option<HashLine>,
    /// Whether `last` is the very last.
    ended: bool,
    last_wall_ns: u64,
    frame: Vec<u8>,
}

struct Channels {
    scene: u16,
    command: u16,
    hash: u16,
    state: u16,
    end: u16,
}

impl Channels {
    fn declare<W: Write + Seek>(writer: &mut Writer<W>) -> Result<Self, McapError> {
        let mut json = |topic: &str, schema: &str| {
            let schema = writer.add_schema(&format!("ballroom.{topic}"), "jsonschema", schema.as_bytes())?;
            writer.add_channel(schema, topic, "json", &BTreeMap::new())
        };
        let channels = Self {
            scene: json("scene", include_str!("schemas/scene.json"))?,
            command: json("command", include_str!("schemas/command.json"))?,
            hash: json("hash", include_str!("schemas/hash.json"))?,
            end: json("end", include_str!("schemas/end.json"))?,
            state: 0,
        };
        Ok(Self { state: writer.add_channel(0, "state", "cbor", &BTreeMap::new())?, ..channels })
    }
}

impl<W: Write + Seek> Out<W> {
    fn begin(file: W, head: &Head, scene: &SceneLine) -> Result<Self, McapError> {
        // A chunk is written when it is whole: a killed server leaves no half of one that looks like damage.
        let options = WriteOptions::new()
            .compression(None)
            .disable_seeking(true)
            .chunk_size(Some(CHUNK_BYTES))
            .profile(BALLROOM)
            .library(format!("ballroom {PROGRAM}"));
        let mut writer = options.create(file)?;
        writer.write_metadata(&Metadata { name: BALLROOM.to_owned(), metadata: head.to_metadata() })?;
        let channels = Channels::declare(&mut writer)?;
        let mut out = Self {
            writer,
            channels,
            bytes: 0,
            commands: 0,
            hashes: 0,
            states: 0,
            states_dropped: 0,
            last: None,
            ended: false,
            last_wall_ns: super::tape::wall_ns(),
            frame: Vec::new(),
        };
        out.json(out.channels.scene, 0, scene)?;
        out.writer.flush()?;
        Ok(out)
    }

    /// Writes an entry and gives back the buffer of a state.
    fn write(
        &mut self,
        Stamped { wall_ns, entry }: Stamped,
    ) -> Result<Option<Box<protocol::snapshot::Snapshot>>, McapError> {
        // The wall clock may be set back; the file's order is that of what happened.
        self.last_wall_ns = self.last_wall_ns.max(wall_ns);
        match entry {
            Entry::Command(line) => {
                self.json(self.channels.command, self.commands, &line)?;
                self.commands += 1;
            }
            Entry::Hash(line) => {
                self.json(self.channels.hash, self.hashes, &line)?;
                self.hashes += 1;
                self.last = Some(line);
            }
            Entry::State(state) => {
                codec::encode_state(&state, &mut self.frame);
                self.message(self.channels.state, self.states)?;
                self.states += 1;
                return Ok(Some(state));
            }
            Entry::End(line) => {
                self.last = Some(line);
                self.ended = true;
            }
        }
        Ok(None)
    }

    /// The last message and the index. `why` it is incomplete counts when the tick loop's own end never came.
    fn end(&mut self, why: &str) -> Result<EndLine, McapError> {
        let HashLine { epoch, tick, state_hash } =
            self.last.unwrap_or(HashLine { epoch: 0, tick: 0, state_hash: 0 });
        let end = EndLine {
            epoch,
            tick,
            state_hash,
            commands: self.commands,
            hashes: self.hashes,
            states: self.states,
            states_dropped: self.states_dropped,
            complete: self.ended,
            why: if self.ended { String::new() } else { why.to_owned() },
        };
        self.json(self.channels.end, 0, &end)?;
        self.writer.finish()?;
        Ok(end)
    }

    fn json(&mut self, channel: u16, sequence: u64, line: &impl Serialize) -> Result<(), McapError> {
        self.frame.clear();
        serde_json::to_writer(&mut self.frame, line).map_err(std::io::Error::from)?;
        self.message(channel, sequence)
    }

    fn message(&mut self, channel_id: u16, sequence: u64) -> Result<(), McapError> {
        let (log_time, publish_time) = (self.last_wall_ns, self.last_wall_ns);
        let header = MessageHeader { channel_id, sequence: sequence as u32, log_time, publish_time };
        self.bytes += self.frame.len() as u64;
        self.writer.write_to_known_channel(&header, &self.frame)
    }
}
