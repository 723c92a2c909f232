//! `replay`: a recording run again and compared.

use super::connection::ZenohFlags;
use super::signals::abort_on_signal;
use anyhow::{Context, bail};
use ballroom_client::Abort;
use protocol::command::SpeedFactor;
use protocol::keys::Name;
use server::recording::{Ending, Reader, ReplayError, Verdict, replay};
use server::screening::{Screening, ScreeningError};
use server::{ArenaOptions, NetworkOptions, begin_with_enough_threads};
use std::io::{Write, stdout};
use std::path::PathBuf;

/// Run a recording again from the file alone and compare every hash and state: as fast as it goes, or shown to viewers
#[derive(clap::Args)]
#[command(after_help = "\
Exit code 1 when anything differs, or when the file is damaged or of another version. A file that is cut short, because
the server was killed, is compared as far as it goes, and stderr says so.

With --serve it is published like a live run, and its clock obeys pause, resume, step and speed; it ends with the recording.

Examples:
  ballroom serve thousand --record ride.mcap
  ballroom replay ride.mcap
  ballroom replay ride.mcap --json
  ballroom replay ride.mcap --serve --speed 4 --paused     then `ballroom-viewer`, and `ballroom resume`")]
pub struct Replay {
    /// What `serve --record` wrote
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// One JSON object
    #[arg(long)]
    json: bool,
    /// Publish it like a live run; stdout begins with the endpoint
    #[arg(long)]
    serve: bool,
    #[command(flatten)]
    show: Show,
}

/// How a recording is shown.
#[derive(clap::Args)]
struct Show {
    /// Simulated seconds per wall second: 0.01 to 100, or max
    #[arg(long, default_value = "1", requires = "serve", value_parser = super::clock::factor)]
    speed: SpeedFactor,
    /// Begin with the clock standing
    #[arg(long, requires = "serve")]
    paused: bool,
    /// Endpoint to listen on, for instance tcp/127.0.0.1:0 for any free port
    #[arg(short = 'l', long = "listen", value_name = "ENDPOINT", requires = "serve")]
    listen: Vec<String>,
    #[command(flatten)]
    zenoh: ZenohFlags,
    /// Name of the arena in the keys
    #[arg(long, default_value = protocol::keys::DEFAULT_ARENA, value_name = "NAME")]
    arena: Name,
}

impl Show {
    fn run(self, reader: Reader, abort: &Abort) -> Result<Verdict, ScreeningError> {
        let options = ArenaOptions {
            arena: self.arena,
            paused: self.paused,
            network: NetworkOptions {
                listen: self.listen,
                connect: Vec::new(),
                config: self.zenoh.config,
                settings: self.zenoh.cfg,
            },
            ..ArenaOptions::default()
        };
        let screening = Screening::open(reader, &options)?;
        tracing::info!("the recording is shown as arena {} on {}", options.arena, screening.endpoint());
        // Scripts wait for this line; nobody has to.
        drop(writeln!(stdout(), "{}", screening.endpoint()));
        screening.run(self.speed, || abort.is_aborted())
    }
}

impl Replay {
    pub fn run(self) -> anyhow::Result<()> {
        if self.serve {
            begin_with_enough_threads();
        }
        let name = || self.file.display().to_string();
        let abort = abort_on_signal()?;
        let mut reader = Reader::open(&self.file).with_context(name)?;
        let verdict = if self.serve {
            match self.show.run(reader, &abort) {
                Err(ScreeningError::Arena(error)) => return Err(error.into()),
                Err(ScreeningError::Replay(error)) => Err(error),
                Ok(verdict) => Ok(verdict),
            }
        } else {
            replay(&mut reader, || abort.is_aborted())
        };
        let verdict = match verdict {
            Err(ReplayError::Stopped) => return Err(super::exit::Interrupted.into()),
            Err(ReplayError::Scene(error)) => return Err(error.into()),
            other => other.with_context(name)?,
        };
        warn(&verdict);
        if self.json {
            writeln!(stdout(), "{}", serde_json::to_string(&verdict)?)?;
        }
        let Verdict { ticks, commands, hashes, states, difference, ending, .. } = verdict;
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
        if hashes == 0 && states == 0 && ending != Some(Ending::Complete) {
            bail!("{}: nothing could be compared: it ends before its first hash", self.file.display());
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
