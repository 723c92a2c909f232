//! The arena's place on the network. Only here does the server name Zenoh.
//!
//! | file | what |
//! |---|---|
//! | `session` | one session that is its own router |
//! | `services` | commands and questions coming in |
//! | `driving` | players: claims, drive messages and acknowledgements |
//! | `budget` | how many commands and questions one source may send |
//! | `answers` | everything that is answered, on a thread of its own |
//! | `publisher` | states, hits and statistics going out, on a thread of its own |

mod answers;
mod budget;
mod driving;
mod publisher;
mod services;
mod session;

use crate::arena::ArenaOptions;
use crate::handover::Handover;
use crate::history::Archive;
use crate::inbox::Inbox;
use crate::players::Players;
use crate::simulation::{Simulation, Stage};
use crate::workshop::{Bench, Workshop};
use protocol::info::Info;
use protocol::keys::{Keys, Name, Role};
use protocol::parameter::Parameters;
use protocol::snapshot::{Snapshot, World};
use protocol::stats::Stats;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use zenoh::Wait;

/// Longest wait for an orderly end of the session.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(1);

/// Why the network cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum NetworkError {
    /// The configuration is unusable.
    #[error("Zenoh does not accept {what}: {why}")]
    Config {
        /// The file, or the setting.
        what: String,
        /// In its words.
        why: String,
    },
    /// Every port that was tried is taken.
    #[error(
        "ports {first} to {last} on 127.0.0.1 are all taken: name a free endpoint with -l tcp/127.0.0.1:PORT"
    )]
    NoPort {
        /// First tried.
        first: u16,
        /// Last tried.
        last: u16,
    },
    /// No thread could be started.
    #[error("no thread could be started: {0}")]
    Thread(#[from] std::io::Error),
    /// Zenoh failed.
    #[error("Zenoh: {0}")]
    Zenoh(#[from] zenoh::Error),
}

/// What questions are answered from. The tick thread never touches it.
pub(crate) struct Latest {
    info: Info,
    present: Mutex<Present>,
    stats: Mutex<Stats>,
}

impl Latest {
    fn world(&self) -> World {
        let present = self.present();
        let (stage, snapshot) = (present.stage.clone(), present.state.clone());
        drop(present);
        World {
            scene: (*stage.scene).clone(),
            roster: (*stage.roster).clone(),
            tick_rate_hz: self.info.tick_rate_hz,
            snapshot,
        }
    }

    fn stage(&self) -> Stage {
        self.present().stage.clone()
    }

    fn parameters(&self) -> Parameters {
        let Stage { epoch, scene, .. } = self.stage();
        Parameters { epoch, parameters: crate::parameters::list(&scene, self.info.tick_rate_hz) }
    }

    fn present(&self) -> MutexGuard<'_, Present> {
        self.present.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn stats(&self) -> Stats {
        self.stats.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn set_stats(&self, stats: Stats) {
        *self.stats.lock().unwrap_or_else(PoisonError::into_inner) = stats;
    }

    /// Keeps `state`, and what it belongs to if that is new; gives back the one kept before.
    fn replace(&self, stage: Option<Stage>, state: Snapshot) -> Snapshot {
        let mut present = self.present();
        if let Some(stage) = stage {
            present.stage = stage;
        }
        std::mem::replace(&mut present.state, state)
    }
}

/// A state and what it belongs to.
struct Present {
    stage: Stage,
    state: Snapshot,
}

/// An open session with everything declared; [`Network::run`] is the publisher's thread.
pub(crate) struct Network {
    session: zenoh::Session,
    endpoints: Vec<String>,
    publisher: publisher::Publisher,
    services: services::Services,
    driving: driving::Driving,
    answered: Receiver<()>,
    alive: zenoh::liveliness::LivelinessToken,
}

impl Network {
    pub(crate) fn open(
        options: &ArenaOptions,
        simulation: &Simulation,
        inbox: &Arc<Inbox>,
        handover: Arc<Handover>,
        archive: Arc<Archive>,
    ) -> Result<Self, NetworkError> {
        let mut first = Snapshot::default();
        simulation.write_snapshot(&mut first);
        first.paused = options.paused;
        let mut stats = Stats { paused: options.paused, speed_factor: 1.0, ..Stats::default() };
        simulation.write_stats(&mut stats);
        let latest = Arc::new(Latest {
            info: Info::new(options.arena.as_str(), options.tick_rate_hz),
            present: Mutex::new(Present { stage: simulation.stage(), state: first }),
            stats: Mutex::new(stats),
        });
        let keys = Keys::new(&options.arena);
        let (session, endpoints) = session::open(options)?;
        let workshop = Workshop::start(Bench::new(simulation), inbox.clone(), archive.clone())?;
        let players = Arc::new(Players::new(inbox.clone()));
        let (answers, answered) = answers::Answers::start(latest.clone(), archive, players.clone())?;
        let gate = services::Gate::new(inbox, &answers, workshop, &players, &latest);
        drop(answers);
        let services = services::Services::declare(&session, &keys, &gate)?;
        let driving = driving::Driving::declare(&session, &keys, &gate)?;
        let publisher = publisher::Publisher::declare(&session, &keys, latest, handover, players)?;
        // Last: who sees the token finds everything else in place. The epoch is a number, so this is a name.
        let id: Name = simulation.epoch().to_string().parse().expect("digits are a name");
        let alive = session.liveliness().declare_token(keys.alive(Role::Server, &id)).wait()?;
        Ok(Self { session, endpoints, publisher, services, driving, answered, alive })
    }

    pub(crate) fn endpoints(&self) -> &[String] {
        &self.endpoints
    }

    /// Publishes until the tick loop has ended, then closes the session.
    pub(crate) fn run(mut self) {
        self.publisher.run();
        drop((self.alive, self.services, self.driving, self.publisher));
        // What is still to be answered goes out first; a client that does not read has to do without.
        if self.answered.recv_timeout(CLOSE_TIMEOUT) == Err(RecvTimeoutError::Timeout) {
            tracing::debug!("not everything was answered");
        }
        // Closing may wait long for a link that is in trouble; nobody has to wait for that.
        let (done, closed) = std::sync::mpsc::sync_channel(1);
        let session = self.session;
        std::thread::spawn(move || drop(done.send(session.close().wait())));
        if !matches!(closed.recv_timeout(CLOSE_TIMEOUT), Ok(Ok(()))) {
            tracing::debug!("the session did not close in order");
        }
    }
}
