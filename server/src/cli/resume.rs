//! `serve --resume`: where a file's run ended, as the scene to begin with and the commands that lead there.

use anyhow::{Context, bail};
use protocol::command::{Command, Scope};
use protocol::timeline::SavedState;
use server::history::Past;
use server::recording::{Ending, Reader, begin, replay_before};
use server::simulation::{Moment, Simulation};
use server::{SceneText, checkpoint_file};
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// First bytes of an MCAP file.
const MCAP: &[u8] = b"\x89MCAP0\r\n";

/// Where a run is to go on.
pub struct Resumed {
    /// The scene; none if a saved state does not say which.
    pub scene: Option<SceneText>,
    /// What leads from its start to there.
    pub first: Vec<Command>,
    /// Ticks a simulated second, as they were.
    pub tick_rate_hz: u32,
}

impl Resumed {
    /// Reads a saved state, or replays a recording to its end.
    pub fn from_file(file: &Path, stop: impl Fn() -> bool) -> anyhow::Result<Self> {
        let mut first_bytes = [0; MCAP.len()];
        let opened = File::open(file).with_context(|| file.display().to_string())?;
        let read = opened.take(MCAP.len() as u64).read(&mut first_bytes);
        let read = read.with_context(|| file.display().to_string())?;
        if first_bytes[..read] == *MCAP {
            return Self::from_recording(file, stop);
        }
        let saved = checkpoint_file::read(file)?;
        let scene = SceneText::built_in(&saved.scene).ok();
        let tick_rate_hz = saved.tick_rate_hz;
        Ok(Self { scene, first: vec![load(saved)], tick_rate_hz })
    }

    fn from_recording(file: &Path, stop: impl Fn() -> bool) -> anyhow::Result<Self> {
        let name = || file.display().to_string();
        let mut reader = Reader::open(file).with_context(name)?;
        let start = begin(&mut reader).with_context(name)?;
        let (verdict, simulation) = replay_before(&mut reader, start, stop).with_context(name)?;
        if let Some(difference) = verdict.difference {
            let (tick, epoch) = (difference.tick, difference.epoch);
            bail!(
                "{}: its run is another one from tick {tick} of epoch {epoch}: see `ballroom replay`",
                name()
            );
        }
        if verdict.ending != Some(Ending::Complete) {
            tracing::warn!("{} is cut short: it goes on from tick {}", name(), verdict.last_tick);
        }
        Self::from_run(&simulation).with_context(name)
    }

    /// The scene as its text has it, then its seed, then the state.
    fn from_run(simulation: &Simulation) -> anyhow::Result<Self> {
        let ground = Arc::new(simulation.ground());
        let mut moment = Moment::with_room(&ground);
        simulation.write_moment(&mut moment);
        let state = load(Past::new(&ground, &moment).to_saved()?);
        let source = simulation.loaded().source();
        let reseeded = source.seed().map(|seed| Command::Reset { scope: Scope::All, seed: Some(seed) });
        Ok(Self {
            scene: Some(source.clone().with_seed(None)),
            first: reseeded.into_iter().chain([state]).collect(),
            tick_rate_hz: simulation.tick_rate_hz(),
        })
    }
}

fn load(state: SavedState) -> Command {
    Command::LoadState { slot: None, state: Some(Box::new(state)) }
}
