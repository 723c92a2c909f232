//! The command line: one file a subcommand, and what they share.

mod arenas;
mod ball_count;
mod balls;
mod check;
mod clock;
mod completions;
mod connection;
mod dial;
mod exit;
mod floor;
mod hardcases;
mod lines;
mod metrics;
mod numbers;
mod pad;
mod parameters;
mod play;
mod players;
mod replay;
mod report;
mod resume;
mod serve;
mod sight;
mod signals;
mod simulate;
mod steer;
mod timeline;
mod top;
mod watch;
mod world;

use clap::{Parser, Subcommand};
use std::io::IsTerminal;
use std::process::ExitCode;
use tracing_subscriber::EnvFilter;

const EXIT_CODES: &str = "\
Exit codes:
  0    done; also: ended by Ctrl-C or SIGTERM, or nobody reads the output any more
  1    failed
  2    the command line is wrong
  3    no server was found
  4    the server refused
  5    the scene is wrong
  130  ended by a signal before the work was done, or by a second Ctrl-C

RUST_LOG sets what is logged to stderr, for instance RUST_LOG=debug,zenoh=warn.";

/// Balls rolling and colliding on Bezier floors: the server and its tools.
#[derive(Parser)]
#[command(name = "ballroom", version, after_help = EXIT_CODES, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Subcommands,
}

#[derive(Subcommand)]
enum Subcommands {
    Serve(serve::Serve),
    Arenas(Box<arenas::Arenas>),
    Check(check::Check),
    Steer(steer::Steer),
    Pause(clock::Pause),
    Resume(clock::Resume),
    State(clock::State),
    Step(clock::Step),
    RunUntil(clock::RunUntil),
    Reset(clock::Reset),
    Speed(clock::Speed),
    Balls(Box<balls::Balls>),
    Floor(floor::Floor),
    Parameters(parameters::Parameters),
    Rewind(timeline::Rewind),
    Save(timeline::Save),
    LoadState(timeline::LoadState),
    Slots(timeline::Slots),
    Load(world::Load),
    Reload(world::Reload),
    Scenes(world::Scenes),
    Features(world::Features),
    Play(play::Play),
    Players(players::Players),
    Watch(watch::Watch),
    Top(top::Top),
    Metrics(metrics::Metrics),
    Simulate(simulate::Simulate),
    Replay(replay::Replay),
    Hardcases(hardcases::Hardcases),
    Report(report::Report),
    Completions(completions::Completions),
}

/// Runs the subcommand and says in one line what went wrong.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("info,zenoh=error"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(server::terminal::screen::LogLines::default)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false)
        .init();
    let done = match cli.command {
        Subcommands::Serve(serve) => serve.run(),
        Subcommands::Arenas(arenas) => arenas.run(),
        Subcommands::Check(check) => check.run(),
        Subcommands::Steer(steer) => steer.run(),
        Subcommands::Pause(pause) => pause.run(),
        Subcommands::Resume(resume) => resume.run(),
        Subcommands::State(state) => state.run(),
        Subcommands::Step(step) => step.run(),
        Subcommands::RunUntil(run) => run.run(),
        Subcommands::Balls(balls) => balls.run(),
        Subcommands::Floor(floor) => floor.run(),
        Subcommands::Parameters(parameters) => parameters.run(),
        Subcommands::Rewind(rewind) => rewind.run(),
        Subcommands::Save(save) => save.run(),
        Subcommands::LoadState(load) => load.run(),
        Subcommands::Slots(slots) => slots.run(),
        Subcommands::Load(load) => load.run(),
        Subcommands::Reload(reload) => reload.run(),
        Subcommands::Scenes(scenes) => scenes.run(),
        Subcommands::Features(features) => features.run(),
        Subcommands::Reset(reset) => reset.run(),
        Subcommands::Speed(speed) => speed.run(),
        Subcommands::Play(play) => play.run(),
        Subcommands::Players(players) => players.run(),
        Subcommands::Watch(watch) => watch.run(),
        Subcommands::Top(top) => top.run(),
        Subcommands::Metrics(metrics) => metrics.run(),
        Subcommands::Simulate(simulate) => simulate.run(),
        Subcommands::Replay(replay) => replay.run(),
        Subcommands::Hardcases(hardcases) => hardcases.run(),
        Subcommands::Report(report) => report.run(),
        Subcommands::Completions(completions) => completions.run(),
    };
    done.map_or_else(|error| exit::code_of(&error), |()| ExitCode::SUCCESS)
}
