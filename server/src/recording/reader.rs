//! A recording, message by message. Nothing in a file is believed: checksums come before contents, every length has a
//! limit, and what does not fit is named.

use super::lines::BALLROOM;
use super::{CommandLine, EndLine, HashLine, Head, RECORDING_VERSION, SceneLine};
use mcap::McapError;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use protocol::codec::MAX_STATE_BYTES;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// Longest record or chunk: a chunk that has room for one more message, and the longest message. Scenes are 16 MiB as
/// text, and JSON may write a byte as six.
const MAX_RECORD_BYTES: usize = 128 << 20;
const _: () = assert!(MAX_RECORD_BYTES > 6 * protocol::scene_text::MAX_SCENE_BYTES + MAX_STATE_BYTES);
/// Most channels of a file; it has five.
const MAX_CHANNELS: usize = 64;

/// Why a file is not read on.
#[derive(Debug, thiserror::Error)]
pub enum RecordingFault {
    /// The system does not give it.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// Another kind of file.
    #[error("is no recording of ballroom: {0}")]
    Foreign(String),
    /// A newer or older format.
    #[error("has format {0}, and this program reads {RECORDING_VERSION}: use the release that recorded it")]
    Version(u32),
    /// It ends in the middle: the server was killed, or the file was not copied whole.
    #[error("is cut short")]
    Cut,
    /// A checksum, a length or a message is wrong.
    #[error("is damaged: {0}")]
    Damaged(String),
}

/// A message.
#[derive(Clone, Debug, PartialEq)]
pub enum Line {
    /// The scene.
    Scene(SceneLine),
    /// A command.
    Command(CommandLine),
    /// A hash.
    Hash(HashLine),
    /// The frame of a state.
    State(Vec<u8>),
    /// The end.
    End(EndLine),
}

/// A file being read.
pub struct Reader<R = BufReader<File>> {
    file: R,
    mcap: LinearReader,
    topics: BTreeMap<u16, String>,
    head: Head,
}

impl Reader {
    /// Opens a file and reads its head.
    pub fn open(path: &Path) -> Result<Self, RecordingFault> {
        Self::new(BufReader::with_capacity(1 << 20, File::open(path)?))
    }
}

impl<R: Read> Reader<R> {
    /// Reads the head from any source.
    pub fn new(file: R) -> Result<Self, RecordingFault> {
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_check_finishes_after_end_magic(true)
            .with_record_length_limit(MAX_RECORD_BYTES);
        let mcap = LinearReader::new_with_options(options);
        let head = Head {
            version: 0,
            program: String::new(),
            tick_rate_hz: 1,
            epoch: 0,
            hash_every_ticks: 1,
            state_every_ticks: 0,
        };
        let mut reader = Self { file, mcap, topics: BTreeMap::new(), head };
        reader.head = reader.read_head()?;
        Ok(reader)
    }

    /// What stands before everything else.
    pub const fn head(&self) -> &Head {
        &self.head
    }

    /// The next message; none after the file's end.
    pub fn next_line(&mut self) -> Result<Option<Line>, RecordingFault> {
        loop {
            match self.next_record()? {
                None => return Ok(None),
                Some(Record::Channel(channel)) => {
                    if self.topics.len() >= MAX_CHANNELS {
                        return Err(RecordingFault::Damaged("it has too many channels".to_owned()));
                    }
                    self.topics.insert(channel.id, channel.topic);
                }
                Some(Record::Message { header, data }) => {
                    let topic = self.topics.get(&header.channel_id).map(String::as_str);
                    if let Some(line) = line(topic, &data)? {
                        return Ok(Some(line));
                    }
                }
                Some(_) => {}
            }
        }
    }

    fn read_head(&mut self) -> Result<Head, RecordingFault> {
        let foreign = |why: &str| RecordingFault::Foreign(why.to_owned());
        match self.next_record()? {
            Some(Record::Header(header)) if header.profile == BALLROOM => {}
            Some(Record::Header(header)) => {
                return Err(RecordingFault::Foreign(format!("its profile is {:?}", header.profile)));
            }
            _ => return Err(foreign("it has no header")),
        }
        let Some(Record::Metadata(metadata)) = self.next_record()? else {
            return Err(foreign("its second record says nothing of a run"));
        };
        match Head::version_of(&metadata.metadata) {
            Some(version) if version != RECORDING_VERSION => Err(RecordingFault::Version(version)),
            _ => Head::from_metadata(&metadata.metadata)
                .ok_or_else(|| RecordingFault::Damaged("its metadata makes no sense".to_owned())),
        }
    }

    fn next_record(&mut self) -> Result<Option<Record<'static>>, RecordingFault> {
        while let Some(event) = self.mcap.next_event() {
            match event.map_err(fault)? {
                LinearReadEvent::ReadRequest(bytes) => {
                    let read = self.file.read(self.mcap.insert(bytes))?;
                    self.mcap.notify_read(read);
                }
                LinearReadEvent::Record { opcode, data } => {
                    let record = mcap::parse_record(opcode, data).map_err(fault)?;
                    return Ok(Some(record.into_owned()));
                }
            }
        }
        Ok(None)
    }
}

fn fault(error: McapError) -> RecordingFault {
    match error {
        McapError::UnexpectedEof => RecordingFault::Cut,
        McapError::BadMagic => RecordingFault::Foreign("it is no MCAP file".to_owned()),
        McapError::Io(e) => RecordingFault::Io(e),
        other => RecordingFault::Damaged(other.to_string()),
    }
}

/// A message of a topic that is ours; others may be added by tools.
fn line(topic: Option<&str>, data: &[u8]) -> Result<Option<Line>, RecordingFault> {
    Ok(Some(match topic {
        Some("scene") => Line::Scene(json("scene", data)?),
        Some("command") => Line::Command(json("command", data)?),
        Some("hash") => Line::Hash(json("hash", data)?),
        Some("end") => Line::End(json("end", data)?),
        Some("state") => Line::State(data.to_owned()),
        _ => return Ok(None),
    }))
}

fn json<T: DeserializeOwned>(topic: &str, data: &[u8]) -> Result<T, RecordingFault> {
    serde_json::from_slice(data).map_err(|e| RecordingFault::Damaged(format!("a message of {topic}: {e}")))
}
