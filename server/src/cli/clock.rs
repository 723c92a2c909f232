//! `pause`, `resume`, `state`, `step`, `run-until`, `reset` and `speed`: what they do to the clock is one line each.

use super::connection::{ANSWER_TIMEOUT, Asked, LONG_TIMEOUT};
use protocol::command::{Command, RunState, Scope, SpeedFactor, SpeedName};
use std::io::Write;

/// Stop the clock
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  ballroom pause\n  ballroom pause --json | jq .tick")]
pub struct Pause {
    #[command(flatten)]
    asked: Asked,
}

/// Let the clock run
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  ballroom resume\n  ballroom resume --arena left")]
pub struct Resume {
    #[command(flatten)]
    asked: Asked,
}

/// Say what the clock does, or set it
#[derive(clap::Args)]
#[command(after_help = "\
States: stopped = paused, and everything reset; playing; paused; quitting = this arena ends, and the server with its last.
The words and numbers are those of ROS simulation_interfaces.

Examples:
  ballroom state
  ballroom state stopped
  ballroom state quitting --arena left")]
pub struct State {
    /// stopped, playing, paused or quitting
    state: Option<RunState>,
    #[command(flatten)]
    asked: Asked,
}

/// Advance a paused arena by whole ticks; returns when they are done
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  ballroom pause && ballroom step\n  ballroom step 60")]
pub struct Step {
    /// How many ticks, 1 to 1000000
    #[arg(default_value_t = 1, allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=protocol::command::MAX_STEP_TICKS))]
    ticks: u64,
    #[command(flatten)]
    asked: Asked,
}

/// Advance a paused arena as fast as it goes to a simulated time; returns when it is reached
#[derive(clap::Args)]
#[command(after_help = "\
The arena stays paused. It ends at the first tick at or after the time; a pause ends it before.

Examples:
  ballroom pause && ballroom run-until 60
  ballroom run-until 2.5 --json")]
pub struct RunUntil {
    /// Simulated seconds since the epoch began
    #[arg(value_name = "T")]
    time_s: f64,
    #[command(flatten)]
    asked: Asked,
}

/// Back to the scene's first state, or to a part of it
#[derive(clap::Args)]
#[command(after_help = "\
Scopes: all = everything, a new epoch; time = the clock and every count, the balls stay as they are, a new epoch;
state = places, velocities and spins, the clock goes on; spawned = balls that were spawned go,
the clock goes on.

Examples:
  ballroom reset
  ballroom reset --seed 7           clouds placed anew; the cloud at place i of the scene has the seed 7 + i
  ballroom reset --scope state")]
pub struct Reset {
    /// What of it: all, time, state or spawned
    #[arg(long, default_value = "all", value_parser = scope)]
    scope: Scope,
    /// Places the scene's clouds anew; without it they are as the scene says
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    #[command(flatten)]
    asked: Asked,
}

/// Set the simulated seconds per wall second
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  ballroom speed 0.1    slow motion\n  ballroom speed 1      real time\n  ballroom speed max    as fast as it goes"
)]
pub struct Speed {
    /// 0.01 to 100, or max
    #[arg(allow_negative_numbers = true, value_parser = factor)]
    factor: SpeedFactor,
    #[command(flatten)]
    asked: Asked,
}

impl Pause {
    pub fn run(self) -> anyhow::Result<()> {
        self.asked.command(&Command::Pause {}, ANSWER_TIMEOUT)
    }
}

impl Resume {
    pub fn run(self) -> anyhow::Result<()> {
        self.asked.command(&Command::Resume {}, ANSWER_TIMEOUT)
    }
}

impl State {
    pub fn run(self) -> anyhow::Result<()> {
        if let Some(state) = self.state {
            return self.asked.command(&Command::SetState { state }, LONG_TIMEOUT);
        }
        let state = self.asked.client(ANSWER_TIMEOUT)?.state()?;
        let mut out = std::io::stdout();
        if self.asked.wants_json() {
            writeln!(out, "{}", serde_json::to_string(&state)?)?;
        } else {
            let name = state.state.name();
            writeln!(out, "{name} at tick {} of epoch {}, {} s", state.tick, state.epoch, state.time_s)?;
        }
        Ok(())
    }
}

impl Step {
    pub fn run(self) -> anyhow::Result<()> {
        self.asked.command(&Command::Step { ticks: self.ticks }, LONG_TIMEOUT)
    }
}

impl RunUntil {
    pub fn run(self) -> anyhow::Result<()> {
        self.asked.command(&Command::RunUntil { time_s: self.time_s }, LONG_TIMEOUT)
    }
}

impl Reset {
    pub fn run(self) -> anyhow::Result<()> {
        let timeout = if self.seed.is_some() { LONG_TIMEOUT } else { ANSWER_TIMEOUT };
        self.asked.command(&Command::Reset { scope: self.scope, seed: self.seed }, timeout)
    }
}

impl Speed {
    pub fn run(self) -> anyhow::Result<()> {
        self.asked.command(&Command::Speed { factor: self.factor }, ANSWER_TIMEOUT)
    }
}

fn scope(text: &str) -> Result<Scope, String> {
    match text {
        "all" => Ok(Scope::All),
        "time" => Ok(Scope::Time),
        "state" => Ok(Scope::State),
        "spawned" => Ok(Scope::Spawned),
        _ => Err("use all, time, state or spawned".into()),
    }
}

pub(super) fn factor(text: &str) -> Result<SpeedFactor, String> {
    match text {
        "max" => Ok(SpeedFactor::Named(SpeedName::Max)),
        _ => text.parse().map(SpeedFactor::Times).map_err(|_| "use 0.01 to 100, or max".into()),
    }
}
