//! `arenas`: which there are in a server's process; starting and stopping them.

use super::connection::{ANSWER_TIMEOUT, Asked, LONG_TIMEOUT};
use super::world::name_or_text;
use protocol::arenas::ArenaCommand;
use protocol::keys::Name;
use std::io::Write;

/// List the arenas of a server, start one more, or stop one
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
#[command(after_help = "\
Examples:
  ballroom arenas
  ballroom arenas --json
  ballroom arenas start left gas --balls 2000 --paused
  ballroom arenas start right my_scene.toml --rate 240
  ballroom arenas stop left")]
pub struct Arenas {
    #[command(subcommand)]
    verb: Option<Verb>,
    #[command(flatten)]
    asked: Asked,
}

#[derive(clap::Subcommand)]
enum Verb {
    Start(Start),
    Stop(Stop),
}

/// Run one more arena in the server's process; returns when it can be reached
#[derive(clap::Args)]
#[command(after_help = "\
A file is read here and sent to the server, which refuses it with line and field if it cannot be run. A recording is
written by the server, beside the file it was started with: --record ride.mcap gives ride-NAME.mcap.

Examples:
  ballroom arenas start left gas --balls 2000
  ballroom arenas start right my_scene.toml --rate 240 --paused")]
struct Start {
    /// Its name in the keys: 1 to 32 of a-z, 0-9, _ and -
    name: Name,
    /// Name of a built-in scene, or a file ending in .toml
    scene: String,
    /// Balls in all, for a scene with one cloud
    #[arg(long, value_name = "N")]
    balls: Option<u32>,
    /// Ticks a simulated second
    #[arg(long, value_name = "HZ", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rate: u32,
    /// Begin with the clock standing
    #[arg(long)]
    paused: bool,
    /// Record it, if the server was started with --record
    #[arg(long)]
    record: bool,
    #[command(flatten)]
    asked: Asked,
}

/// End an arena; returns when it has ended. The server ends with its last
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  ballroom arenas stop left")]
struct Stop {
    /// Which
    name: Name,
    #[command(flatten)]
    asked: Asked,
}

impl Arenas {
    pub fn run(self) -> anyhow::Result<()> {
        match self.verb {
            Some(Verb::Start(start)) => return start.run(),
            Some(Verb::Stop(stop)) => {
                let command = ArenaCommand::Stop { arena: stop.name };
                return stop.asked.arena_command(&command, LONG_TIMEOUT);
            }
            None => {}
        }
        let arenas = self.asked.client(ANSWER_TIMEOUT)?.arenas()?;
        let mut out = std::io::stdout().lock();
        if self.asked.wants_json() {
            writeln!(out, "{}", serde_json::to_string(&arenas)?)?;
            return Ok(());
        }
        for row in arenas.arenas {
            let recorded = if row.recorded { "  recorded" } else { "" };
            writeln!(
                out,
                "{:16} {:20} {:8} tick {:>8}  t {:>12.6} s  {:>4} Hz  {:>6} balls{recorded}",
                row.arena,
                row.scene,
                row.state.name(),
                row.tick,
                row.time_s,
                row.tick_rate_hz,
                row.balls
            )?;
        }
        Ok(())
    }
}

impl Start {
    fn run(self) -> anyhow::Result<()> {
        let (scene, toml) = name_or_text(&self.scene)?;
        let Self { name: arena, balls, rate: tick_rate_hz, paused, record, .. } = self;
        let command = ArenaCommand::Start { arena, scene, toml, balls, tick_rate_hz, paused, record };
        self.asked.arena_command(&command, LONG_TIMEOUT)
    }
}
