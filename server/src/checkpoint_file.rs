//! A run's state as a file: a [`SavedState`] in JSON.

use crate::history::Past;
use crate::simulation::{Moment, Simulation};
use ballroom_physics::CheckpointFault;
use protocol::timeline::SavedState;
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest file that is read, bytes: 100 000 balls take half of it.
const MAX_BYTES: u64 = 64 << 20;

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

/// Writes the run as it stands into a new file, which is there as a whole or not at all.
pub fn save(simulation: &Simulation, file: &Path) -> Result<(), CheckpointFileError> {
    let ground = Arc::new(simulation.ground());
    let mut moment = Moment::with_room(&ground);
    simulation.write_moment(&mut moment);
    let saved = Past::new(&ground, &moment).to_saved();
    write(&saved.map_err(|fault| CheckpointFileError::Fault { file: file.into(), fault })?, file)
}

/// Writes a state into a new file, which is there as a whole or not at all.
pub fn write(saved: &SavedState, file: &Path) -> Result<(), CheckpointFileError> {
    let part = file.with_added_extension("part");
    let write = || -> std::io::Result<()> {
        let mut out = BufWriter::new(File::create(&part)?);
        serde_json::to_writer(&mut out, saved)?;
        out.write_all(b"\n")?;
        out.into_inner()?.sync_all()?;
        std::fs::rename(&part, file)
    };
    write().map_err(|error| CheckpointFileError::File { file: file.into(), error })
}

/// Goes on where the file's run stood, in a simulation of the same scene and in its epoch.
pub fn load(simulation: &mut Simulation, file: &Path) -> Result<(), CheckpointFileError> {
    let saved = read(file)?;
    let epoch = simulation.epoch();
    let past = Past::of_saved(&Arc::new(simulation.ground()), &saved);
    let loaded = past.and_then(|past| past.simulation());
    *simulation = loaded.map_err(|fault| CheckpointFileError::Fault { file: file.into(), fault })?;
    simulation.set_epoch(epoch);
    Ok(())
}

/// What a file holds. Whether it belongs to a scene, only the scene can tell.
pub fn read(file: &Path) -> Result<SavedState, CheckpointFileError> {
    let open = |error| CheckpointFileError::File { file: file.into(), error };
    let wrong = |why: String| CheckpointFileError::Format { file: file.into(), why };
    let from = File::open(file).map_err(open)?;
    if from.metadata().map_err(open)?.len() > MAX_BYTES {
        return Err(wrong(format!("it is larger than {MAX_BYTES} bytes")));
    }
    let saved: SavedState = serde_json::from_reader(BufReader::new(from.take(MAX_BYTES)))
        .map_err(|error| wrong(error.to_string()))?;
    saved.fault().map_or(Ok(saved), |why| Err(wrong(why)))
}
