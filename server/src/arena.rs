//! One world being run and served: simulation, inbox, tick loop and its place on the network.

use crate::crew::{Crew, cores_to_tick_on};
use crate::handover::Handover;
use crate::history::{Archive, DEFAULT_HISTORY_BYTES, Plan, Settings};
use crate::inbox::{Inbox, Request};
use crate::network::{Latest, Link, Network, NetworkError};
use crate::ready::Ready;
use crate::recording::{RecordOptions, Recorder, RecordingError, Tape};
use crate::scene_file::{SceneError, SceneText};
use crate::shadows::shadows;
use crate::simulation::Simulation;
use crate::tick_loop::TickLoop;
use crate::workshop::Bench;
use ballroom_client::Setting;
pub use protocol::arenas::TICK_RATES_HZ;
use protocol::command::{Command, Refusal};
use protocol::keys::{DEFAULT_ARENA, Name};
use protocol::state::RunState;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::SystemTime;

/// How to run an arena.
#[derive(Clone, Debug)]
pub struct ArenaOptions {
    /// Its name in the keys.
    pub arena: Name,
    /// Ticks a simulated second, 1 to 1000.
    pub tick_rate_hz: u32,
    /// Threads that a large scene is run on, at least 1. They change no bit.
    pub threads: usize,
    /// Whether to begin with the clock standing.
    pub paused: bool,
    /// What to record, if anything.
    pub record: Option<RecordOptions>,
    /// What the history may take, bytes; 0 for none.
    pub history_bytes: u64,
    /// Balls whose errors are estimated while they run, at most [`SHADOWS_MAX`](crate::shadows::SHADOWS_MAX); 0 for none.
    pub shadows: usize,
    /// Obeyed before the first tick, in this order; none may depend on the past.
    pub first: Vec<Command>,
    /// Where it can be reached, unless it shares the session of other arenas.
    pub network: NetworkOptions,
}

/// Where the arenas of a process can be reached.
#[derive(Clone, Debug, Default)]
pub struct NetworkOptions {
    /// Endpoints to listen on; with none, loopback at 7447 or the next free port.
    pub listen: Vec<String>,
    /// Routers to connect to.
    pub connect: Vec<String>,
    /// A Zenoh configuration file, taken as it stands but for the endpoints above.
    pub config: Option<PathBuf>,
    /// Single settings of Zenoh, applied last.
    pub settings: Vec<Setting>,
}

impl Default for ArenaOptions {
    fn default() -> Self {
        Self {
            arena: DEFAULT_ARENA.parse().expect("a valid name"),
            tick_rate_hz: 60,
            threads: cores_to_tick_on(),
            paused: false,
            record: None,
            history_bytes: DEFAULT_HISTORY_BYTES,
            shadows: 0,
            first: Vec::new(),
            network: NetworkOptions::default(),
        }
    }
}

/// Why an arena did not start.
#[derive(Debug, thiserror::Error)]
pub enum ArenaError {
    /// The scene cannot be run.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The network cannot be reached.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The recording cannot be begun.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The rate is out of its range.
    #[error("a tick rate of {0} Hz is out of range: use 1 to 1000")]
    Rate(u32),
    /// A command that was to be obeyed before the first tick cannot be.
    #[error("it cannot begin like this: {0}")]
    First(Refusal),
    /// There is no place of that name.
    #[error("{0}")]
    Name(String),
    /// No thread could be started.
    #[error("no thread could be started: {0}")]
    Thread(#[from] std::io::Error),
}

/// Where arenas begin.
pub struct Arena;

impl Arena {
    /// Loads the scene, opens a session of its own, and starts ticking.
    pub fn start(scene: &SceneText, options: &ArenaOptions) -> Result<ArenaHandle, ArenaError> {
        let simulation = Self::set_up(scene, options)?;
        let link = Link::open(&options.network)?;
        let mut handle = Self::run(simulation, options, &link)?;
        handle.own_link = Some(link);
        Ok(handle)
    }

    /// Loads the scene and starts ticking on a session that others share.
    pub(crate) fn start_on(
        link: &Link,
        scene: &SceneText,
        options: &ArenaOptions,
    ) -> Result<ArenaHandle, ArenaError> {
        Self::run(Self::set_up(scene, options)?, options, link)
    }

    fn set_up(scene: &SceneText, options: &ArenaOptions) -> Result<Simulation, ArenaError> {
        if !TICK_RATES_HZ.contains(&options.tick_rate_hz) {
            return Err(ArenaError::Rate(options.tick_rate_hz));
        }
        let simulation = Simulation::new(Arc::new(scene.load()?), options.tick_rate_hz, first_epoch())?;
        Ok(simulation.run_by(Crew::of(options.threads)?))
    }

    fn run(simulation: Simulation, options: &ArenaOptions, link: &Link) -> Result<ArenaHandle, ArenaError> {
        let inbox = Arc::new(Inbox::default());
        let handover = Arc::new(Handover::new());
        handover.set_run_state(if options.paused { RunState::Paused } else { RunState::Playing });
        let stop = Arc::new(AtomicBool::new(false));
        give_first(&options.first, &simulation, &inbox)?;
        let (archive, diary) = Archive::new(&simulation, Settings::live(options.history_bytes));
        let network = Network::open(link, options, &simulation, &inbox, handover.clone(), archive.clone())?;
        let latest = network.latest().clone();
        let (tape, recorder) = match &options.record {
            Some(record) => {
                let (recorder, tape) = Recorder::create(record, &simulation)?;
                let thread = std::thread::Builder::new().name("record".into());
                (tape, Some(thread.spawn(move || recorder.run())?))
            }
            None => (Tape::default(), None),
        };
        let (sampler, follower) = (options.shadows > 0).then(|| shadows(options.shadows)).unzip();
        let tick_loop = TickLoop::new(simulation, inbox, handover, stop.clone(), options.paused)
            .recorded_on(tape)
            .remembered_in(diary)
            .followed_by(sampler);
        let mut threads = vec![
            std::thread::Builder::new().name("tick".into()).spawn(move || tick_loop.run())?,
            std::thread::Builder::new().name("publish".into()).spawn(move || network.run())?,
            std::thread::Builder::new().name("history".into()).spawn(move || archive.run())?,
        ];
        if let Some(follower) = follower {
            threads.push(std::thread::Builder::new().name("shadows".into()).spawn(move || follower.run())?);
        }
        Ok(ArenaHandle {
            endpoints: link.endpoints().to_vec(),
            stop,
            threads,
            recorder,
            latest,
            own_link: None,
        })
    }
}

/// Has commands obeyed before the first tick.
fn give_first(first: &[Command], simulation: &Simulation, inbox: &Inbox) -> Result<(), ArenaError> {
    let bench = Bench::new(simulation);
    let mut ground = Arc::new(simulation.ground());
    for command in first {
        let made = match command {
            Command::LoadState { state: Some(state), .. } => {
                Plan::Load(state.clone(), ground.clone()).carry_out()
            }
            command => bench.prepare(command),
        };
        let ready = made.map_err(ArenaError::First)?;
        if let Ready::World(there) = &ready {
            ground = Arc::new(there.ground());
        }
        let request = Request { command: command.clone(), ready, answer: None };
        inbox.offer(request).map_err(|refused| ArenaError::First(refused.why))?;
    }
    Ok(())
}

/// Milliseconds since 1970: later starts have larger epochs, and every reader of JSON can hold them.
fn first_epoch() -> u64 {
    SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_millis() as u64
}

/// A running arena; it stops when this is dropped.
pub struct ArenaHandle {
    endpoints: Vec<String>,
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
    /// Apart: a recording that ends early does not end the arena.
    recorder: Option<JoinHandle<()>>,
    latest: Arc<Latest>,
    /// The session, if no other arena uses it.
    own_link: Option<Link>,
}

impl ArenaHandle {
    /// Where clients connect to: the first endpoint listened on.
    pub fn endpoint(&self) -> &str {
        self.endpoints.first().map_or("", String::as_str)
    }

    /// All endpoints listened on.
    pub fn endpoints(&self) -> &[String] {
        &self.endpoints
    }

    /// What questions about it are answered from.
    pub(crate) const fn latest(&self) -> &Arc<Latest> {
        &self.latest
    }

    /// Has one of its threads end as by a fault.
    #[cfg(test)]
    pub(crate) fn break_down(&mut self) {
        self.threads.push(std::thread::spawn(|| panic!("broken on purpose")));
    }

    /// Asks it to stop.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether it has ended, by request or by a fault.
    pub fn is_finished(&self) -> bool {
        self.threads.iter().any(JoinHandle::is_finished)
    }

    /// Whether it was asked to end by a client, and ends in order.
    pub fn has_quit(&self) -> bool {
        self.latest.state().state == RunState::Quitting
    }

    /// Stops it and waits for the end; false when one of its threads had panicked.
    pub fn join(mut self) -> bool {
        self.finish()
    }

    fn finish(&mut self) -> bool {
        self.stop();
        // Not short-circuiting: every thread is waited for.
        let well = self
            .threads
            .drain(..)
            .chain(self.recorder.take())
            .map(JoinHandle::join)
            .fold(true, |well, ended| well & ended.is_ok());
        if let Some(link) = self.own_link.take() {
            link.close();
        }
        well
    }
}

impl Drop for ArenaHandle {
    fn drop(&mut self) {
        self.finish();
    }
}
