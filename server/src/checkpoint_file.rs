//! A run's checkpoint as a file: JSON with what it is, and the engine's words.

use crate::simulation::Simulation;
use ballroom_physics::{Checkpoint, CheckpointFault};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

/// What the file says it is.
const FORMAT: &str = "ballroom checkpoint";
/// Largest file that is read, bytes: 100 000 balls take half of it.
const MAX_BYTES: u64 = 1 << 30;

/// Why a checkpoint was not kept or not taken.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointFileError {
    /// The file cannot be read or written.
    #[error("{}: {error}", file.display())]
    File {
        /// Which.
        file: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// It is something else.
    #[error("{}: no checkpoint: {why}", file.display())]
    Format {
        /// Which.
        file: PathBuf,
        /// What is wrong.
        why: String,
    },
    /// The engine does not take it.
    #[error("{}: {fault}", file.display())]
    Fault {
        /// Which.
        file: PathBuf,
        /// Its reason.
        fault: CheckpointFault,
    },
}

#[derive(Serialize, Deserialize)]
struct Contents {
    format: String,
    /// For people; the engine knows its scene by a hash.
    scene: String,
    /// For people; the words hold it to the last bit.
    time_s: f64,
    words: Vec<u64>,
}

/// Writes the run as it stands into a new file, which is there as a whole or not at all.
pub fn save(simulation: &Simulation, file: &Path) -> Result<(), CheckpointFileError> {
    let checkpoint = simulation.checkpoint();
    let contents = Contents {
        format: FORMAT.into(),
        scene: simulation.loaded().scene().name.clone(),
        time_s: simulation.time().seconds(),
        words: checkpoint.words().to_vec(),
    };
    let part = file.with_added_extension("part");
    let write = || -> std::io::Result<()> {
        let mut out = BufWriter::new(File::create(&part)?);
        serde_json::to_writer(&mut out, &contents)?;
        out.write_all(b"\n")?;
        out.into_inner()?.sync_all()?;
        std::fs::rename(&part, file)
    };
    write().map_err(|error| CheckpointFileError::File { file: file.into(), error })
}

/// Goes on where the file's run stood, in a simulation of the same scene.
pub fn load(simulation: &mut Simulation, file: &Path) -> Result<(), CheckpointFileError> {
    let open = |error| CheckpointFileError::File { file: file.into(), error };
    let wrong = |why: String| CheckpointFileError::Format { file: file.into(), why };
    let from = File::open(file).map_err(open)?;
    if from.metadata().map_err(open)?.len() > MAX_BYTES {
        return Err(wrong(format!("it is larger than {MAX_BYTES} bytes")));
    }
    let contents: Contents = serde_json::from_reader(BufReader::new(from.take(MAX_BYTES)))
        .map_err(|error| wrong(error.to_string()))?;
    if contents.format != FORMAT {
        return Err(wrong(format!("its format is {:?}, not {FORMAT:?}", contents.format)));
    }
    let taken = simulation.restore(&Checkpoint::of_words(contents.words));
    taken.map_err(|fault| CheckpointFileError::Fault { file: file.into(), fault })
}
