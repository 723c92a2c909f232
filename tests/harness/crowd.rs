//! Ten clients that misbehave, each a process of its own that takes no processor time from others: they stand for other
//! machines.

use crate::process::Process;
use crate::wait::PATIENCE;
use nix::sys::signal::Signal;
use std::time::Duration;

/// How often those that vanish do.
const LIFE: Duration = Duration::from_millis(500);
/// What the floods are.
const ROUGH: [&str; 4] = ["presses", "nonsense", "questions", "bytes"];
/// Readers that stop reading.
const STOPPED: usize = 4;
/// Readers that are killed and come again.
const VANISHING: usize = 2;

/// Four readers that have stopped reading, four that flood, two that vanish again and again.
pub struct Crowd {
    _stopped: Vec<Process>,
    _rough: Vec<Process>,
    vanishing: Vec<Process>,
    endpoint: String,
}

impl Crowd {
    /// All of them at a server.
    pub fn at(endpoint: &str) -> Self {
        let stopped: Vec<Process> = (0..STOPPED).map(|_| reader(endpoint)).collect();
        for process in &stopped {
            process.said(PATIENCE, |_| Some(()));
            process.signal(Signal::SIGSTOP);
        }
        let rough = ROUGH.map(|kind| Process::start_aside("rough-client", &[endpoint, kind]));
        for process in &rough {
            process.said(PATIENCE, |line| (line == "here").then_some(()));
        }
        let vanishing = (0..VANISHING).map(|_| reader(endpoint)).collect();
        Self { _stopped: stopped, _rough: rough.into(), vanishing, endpoint: endpoint.to_owned() }
    }

    /// Lets them be for a time.
    pub fn rage_for(&mut self, time: Duration) {
        for _ in 0..time.as_millis() / LIFE.as_millis() {
            std::thread::sleep(LIFE);
            for process in &mut self.vanishing {
                std::mem::replace(process, reader(&self.endpoint)).kill();
            }
        }
    }
}

fn reader(endpoint: &str) -> Process {
    Process::start_aside("ballroom", &["watch", "--json", "-e", endpoint])
}
