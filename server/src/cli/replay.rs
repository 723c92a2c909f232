//! `replay`: a recording run again and compared.

use super::signals::abort_on_signal;
use anyhow::{Context, bail};
use server::recording::{Ending, Reader, ReplayError, Verdict, replay};
use std::io::{Write, stdout};
use std::path::PathBuf;

/// Run a recording again from the file alone, as fast as it goes, and compare every hash and state
#[derive(clap::Args)]
#[command(after_help = "\
Exit code 1 when anything differs, or when the file is damaged or of another version. A file that is cut short, because
the server was killed, is compared as far as it goes, and stderr says so.

Examples:
  ballroom serve thousand --record ride.mcap
  ballroom replay ride.mcap
  ballroom replay ride.mcap --json")]
pub struct Replay {
    /// What `serve --record` wrote
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// One JSON object
    #[arg(long)]
    json: bool,
}

impl Replay {
    pub fn run(self) -> anyhow::Result<()> {
        let name = || self.file.display().to_string();
        let abort = abort_on_signal()?;
        let mut reader = Reader::open(&self.file).with_context(name)?;
        let verdict = match replay(&mut reader, || abort.is_aborted()) {
            Err(ReplayError::Stopped) => return Err(super::exit::Interrupted.into()),
            Err(ReplayError::Scene(error)) => return Err(error.into()),
            other => other.with_context(name)?,
        };
        warn(&verdict);
        if self.json {
            writeln!(stdout(), "{}", serde_json::to_string(&verdict)?)?;
        }
        let Verdict { ticks, commands, hashes, states, difference, .. } = verdict;
        if let Some(first) = difference {
            bail!(
                "{}: the first difference is at tick {} of epoch {}: the {} was {}, and is now {}",
                self.file.display(),
                first.tick,
                first.epoch,
                first.what,
                first.recorded,
                first.replayed
            );
        }
        if !self.json {
            writeln!(
                stdout(),
                "{ticks} ticks, {commands} commands, every hash equal ({hashes} hashes, {states} states)"
            )?;
        }
        Ok(())
    }
}

fn warn(verdict: &Verdict) {
    let program = env!("CARGO_PKG_VERSION");
    if verdict.program != program {
        tracing::warn!("recorded by ballroom {}, replayed by {program}", verdict.program);
    }
    match &verdict.ending {
        Some(Ending::Cut) => {
            tracing::warn!("the recording is cut short: what follows holds for what is there");
        }
        Some(Ending::Incomplete(why)) => tracing::warn!("the recording is incomplete, because {why}"),
        Some(Ending::Complete) | None => {}
    }
}
