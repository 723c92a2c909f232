//! `ballroom serve` on a free port, and its twin without a network.

use crate::process::{Output, Process, run};
use crate::wait::PATIENCE;
use ballroom_client::{Client, ClientOptions, Patience};
use nix::sys::signal::Signal;
use protocol::snapshot::Collisions;
use serde::Deserialize;
use std::time::{Duration, Instant};

/// A server's process and where it listens.
pub struct Server {
    process: Process,
    endpoint: String,
    listening_since: Instant,
}

impl Server {
    /// Serves on a port that was free.
    pub fn start(arguments: &[&str]) -> Self {
        Self::start_at("tcp/127.0.0.1:0", arguments)
    }

    /// Serves on an endpoint of one's choice.
    pub fn start_at(endpoint: &str, arguments: &[&str]) -> Self {
        Self::of(Process::start("ballroom", &[&["serve", "-l", endpoint], arguments].concat()))
    }

    /// Waits until a server that was started elsewhere says where it listens.
    pub fn of(process: Process) -> Self {
        let endpoint = process.said(PATIENCE, |line| line.starts_with("tcp/").then(|| line.to_owned()));
        Self { process, endpoint, listening_since: Instant::now() }
    }

    /// Where clients connect to.
    pub fn endpoint(&self) -> &str {
        &self.endpoint
    }

    /// How long ago it said that it listens.
    pub fn age(&self) -> Duration {
        self.listening_since.elapsed()
    }

    /// The process.
    pub const fn process(&self) -> &Process {
        &self.process
    }

    /// A session with it.
    pub fn client(&self) -> Client {
        connect(&self.endpoint)
    }

    /// Runs a subcommand of `ballroom` against it.
    pub fn tool(&self, arguments: &[&str]) -> Output {
        run("ballroom", &[arguments, &["-e", &self.endpoint]].concat())
    }

    /// Ends it as a power cut would, and gives back its endpoint.
    pub fn kill(self) -> String {
        self.process.kill();
        self.endpoint
    }

    /// Sends a signal and waits for the end.
    pub fn end(self, signal: Signal) -> Output {
        self.process.signal(signal);
        self.process.end(PATIENCE)
    }
}

/// A session with the server at an endpoint.
pub fn connect(endpoint: &str) -> Client {
    let options = ClientOptions {
        endpoints: vec![endpoint.to_owned()],
        patience: Patience::GiveUpAfter(PATIENCE),
        ..ClientOptions::default()
    };
    Client::open(options).unwrap_or_else(|e| panic!("{e}"))
}

/// What `simulate --json` says of one state; of the numbers only what tests compare.
#[derive(Debug, Deserialize)]
pub struct State {
    /// Number of the tick.
    pub tick: u64,
    /// Hash of everything that influences the future, as the program writes it.
    pub state_hash: String,
    /// Hits since the start.
    pub collisions: Collisions,
    /// The balls by name.
    pub balls: Vec<BallState>,
}

/// One ball of a [`State`].
#[derive(Debug, Deserialize)]
pub struct BallState {
    /// Its name.
    pub name: String,
    /// Its centre.
    pub center_m: [f64; 3],
}

impl State {
    /// Where a ball is.
    pub fn center_m(&self, name: &str) -> [f64; 3] {
        let ball = self.balls.iter().find(|ball| ball.name == name);
        ball.unwrap_or_else(|| panic!("no ball is named {name}")).center_m
    }
}

/// The undisturbed run of a scene, tick by tick at 60 Hz.
pub fn simulate(scene: &str, until_s: u32) -> Vec<State> {
    let every = (1.0_f64 / 60.0).to_string();
    let output =
        run("ballroom", &["simulate", scene, "--until", &until_s.to_string(), "--every", &every, "--json"]);
    assert_eq!(output.code, Some(0), "{}", output.stderr);
    let states: Vec<State> =
        output.stdout.lines().map(|line| serde_json::from_str(line).expect("a state")).collect();
    assert!(states.iter().map(|state| state.tick).eq(0..=u64::from(until_s) * 60), "every tick once");
    states
}
