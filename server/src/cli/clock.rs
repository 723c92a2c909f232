//! `pause`, `resume`, `step`, `reset` and `speed`: what they do to the clock is one line each.

use super::connection::{ANSWER_TIMEOUT, Connection};
use protocol::command::Command;
use std::time::Duration;

/// A step may be a million ticks long.
const STEP_TIMEOUT: Duration = Duration::from_hours(1);

/// Stop the clock
#[derive(clap::Args)]
pub struct Pause {
    #[command(flatten)]
    connection: Connection,
}

/// Let the clock run
#[derive(clap::Args)]
pub struct Resume {
    #[command(flatten)]
    connection: Connection,
}

/// Advance a paused arena by whole ticks; returns when they are done
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  ballroom pause && ballroom step\n  ballroom step 60")]
pub struct Step {
    /// How many ticks, 1 to 1000000
    #[arg(default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=protocol::command::MAX_STEP_TICKS))]
    ticks: u64,
    #[command(flatten)]
    connection: Connection,
}

/// Back to the scene's first state
#[derive(clap::Args)]
pub struct Reset {
    #[command(flatten)]
    connection: Connection,
}

/// Set the simulated seconds per wall second
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  ballroom speed 0.1    slow motion\n  ballroom speed 1      real time")]
pub struct Speed {
    /// 0.01 to 100
    factor: f64,
    #[command(flatten)]
    connection: Connection,
}

impl Pause {
    pub fn run(self) -> anyhow::Result<()> {
        self.connection.command(&Command::Pause {}, ANSWER_TIMEOUT)
    }
}

impl Resume {
    pub fn run(self) -> anyhow::Result<()> {
        self.connection.command(&Command::Resume {}, ANSWER_TIMEOUT)
    }
}

impl Step {
    pub fn run(self) -> anyhow::Result<()> {
        self.connection.command(&Command::Step { ticks: self.ticks }, STEP_TIMEOUT)
    }
}

impl Reset {
    pub fn run(self) -> anyhow::Result<()> {
        self.connection.command(&Command::Reset {}, ANSWER_TIMEOUT)
    }
}

impl Speed {
    pub fn run(self) -> anyhow::Result<()> {
        self.connection.command(&Command::Speed { factor: self.factor }, ANSWER_TIMEOUT)
    }
}
