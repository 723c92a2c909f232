//! An arena's place on the network. Only here does the server name Zenoh.
//!
//! | file | what |
//! |---|---|
//! | `session` | one session that is its own router |
//! | `threads` | as many as a server needs, whoever stops reading |
//! | `link` | that session, shared by the arenas of a process |
//! | `doors` | what the process is asked: its arenas |
//! | `services` | commands and questions coming in |
//! | `driving` | players: claims, drive messages and acknowledgements |
//! | `budget` | how many commands and questions one source may send |
//! | `throttle` | whoever is refused is read more slowly |
//! | `answers` | everything that is answered, on threads of its own |
//! | `readers` | who reads the states, as they say themselves |
//! | `outlet` | one stream going out, numbered and counted |
//! | `publisher` | states, hits and statistics going out, on a thread of its own |

mod answers;
mod budget;
mod doors;
mod driving;
mod link;
mod outlet;
mod publisher;
mod readers;
mod services;
mod session;
mod threads;
mod throttle;

pub use budget::{ANSWERS_PER_S, PRESSES_PER_S};
pub use session::MAX_SESSIONS;
pub use threads::begin_with_enough_threads;
pub use throttle::REFUSED_PER_S;

use crate::arena::ArenaOptions;
use crate::bucket::Bucket;
use crate::handover::Handover;
use crate::history::Archive;
use crate::inbox::Inbox;
use crate::players::Players;
use crate::simulation::{Simulation, Stage};
use crate::workshop::{Bench, Workshop};
pub(crate) use doors::{Doors, Job as DoorJob};
pub(crate) use link::Link;
use protocol::arenas::ArenaRow;
use protocol::codec::WorldHead;
use protocol::command::Reply;
use protocol::info::Info;
use protocol::keys::{Keys, Name, Role};
use protocol::parameter::Parameters;
use protocol::snapshot::{Snapshot, World};
use protocol::state::State;
use protocol::stats::Stats;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use zenoh::Wait;

/// Longest wait for an orderly end.
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
    /// Somebody listens there already.
    #[error("{0} is taken: name another endpoint, or none with -l for the next free port")]
    Taken(String),
    /// No thread could be started.
    #[error("no thread could be started: {0}")]
    Thread(#[from] std::io::Error),
    /// Zenoh failed.
    #[error("Zenoh: {0}")]
    Zenoh(#[from] zenoh::Error),
}

/// Bytes a second of answers that grow with the balls, for all who ask together: 20 worlds of 10 000 balls.
pub const WHOLE_BYTES_PER_S: f64 = (32 << 20) as f64;

/// What questions are answered from. The tick thread never touches it.
pub(crate) struct Latest {
    info: Info,
    present: Mutex<Present>,
    stats: Mutex<Stats>,
    handover: Arc<Handover>,
    recorded: bool,
    readers: readers::Readers,
    /// Bytes of answers that grow with the balls.
    whole: Mutex<Bucket>,
    /// What all worlds of a stage begin with, once somebody has asked for one.
    head: Mutex<Option<(Stage, Arc<WorldHead>)>>,
}

impl Latest {
    /// Whether answers that grow with the balls may take so many bytes more now. Refusing is cheap, such an answer is not.
    fn may_take(&self, bytes: f64) -> bool {
        bytes == 0.0 || self.whole.lock().unwrap_or_else(PoisonError::into_inner).draw(bytes, Instant::now())
    }

    fn world(&self) -> World {
        let (stage, kept) = self.now();
        World {
            scene: (*stage.scene).clone(),
            roster: (*stage.roster).clone(),
            tick_rate_hz: self.info.tick_rate_hz,
            snapshot: kept.state.clone(),
        }
    }

    /// The same as its frame, of which only the state is encoded afresh.
    fn world_frame(&self) -> Vec<u8> {
        let (stage, kept) = self.now();
        self.head_of(&stage).with(&kept.state)
    }

    fn head_of(&self, stage: &Stage) -> Arc<WorldHead> {
        let mut kept = self.head.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((of, head)) = &*kept
            && Arc::ptr_eq(&of.scene, &stage.scene)
            && Arc::ptr_eq(&of.roster, &stage.roster)
        {
            return head.clone();
        }
        let head = Arc::new(WorldHead::new(&stage.scene, &stage.roster, self.info.tick_rate_hz));
        *kept = Some((stage.clone(), head.clone()));
        head
    }

    /// What the clock does.
    pub(crate) fn state(&self) -> State {
        let (_, kept) = self.now();
        let Snapshot { epoch, tick, time_s, .. } = kept.state;
        let state = self.handover.run_state();
        State { state, number: state.number(), epoch, tick, time_s }
    }

    /// The arena in a list of several.
    pub(crate) fn row(&self) -> ArenaRow {
        let State { state, epoch, tick, time_s, .. } = self.state();
        let stage = self.stage();
        ArenaRow {
            arena: self.info.arena.clone(),
            scene: stage.scene.name.clone(),
            state,
            epoch,
            tick,
            time_s,
            tick_rate_hz: self.info.tick_rate_hz,
            balls: stage.roster.names.len(),
            recorded: self.recorded,
        }
    }

    fn stage(&self) -> Stage {
        self.present().stage.clone()
    }

    fn parameters(&self) -> Parameters {
        let Stage { epoch, scene, .. } = self.stage();
        Parameters { epoch, parameters: crate::parameters::list(&scene, self.info.tick_rate_hz) }
    }

    /// The newest state and what it belongs to. The publisher never waits for whoever reads them.
    fn now(&self) -> (Stage, Arc<Kept>) {
        let present = self.present();
        (present.stage.clone(), present.state.clone())
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

    /// Keeps `state`, and what it belongs to if that is new.
    fn replace(&self, stage: Option<Stage>, state: Snapshot) {
        let kept = Kept::new(state, &self.handover);
        let mut present = self.present();
        if let Some(stage) = stage {
            present.stage = stage;
        }
        let before = std::mem::replace(&mut present.state, kept);
        drop((present, before));
    }
}

/// A state and what it belongs to.
struct Present {
    stage: Stage,
    state: Arc<Kept>,
}

/// A state that several may read at once; its buffer goes round again when the last of them has.
struct Kept {
    state: Snapshot,
    handover: Arc<Handover>,
}

impl Kept {
    fn new(state: Snapshot, handover: &Arc<Handover>) -> Arc<Self> {
        Arc::new(Self { state, handover: handover.clone() })
    }
}

impl Drop for Kept {
    fn drop(&mut self) {
        self.handover.recycle(std::mem::take(&mut self.state));
    }
}

/// Everything of an arena declared; [`Network::run`] is the publisher's thread.
pub(crate) struct Network {
    latest: Arc<Latest>,
    publisher: publisher::Publisher,
    services: services::Services,
    driving: driving::Driving,
    answered: [Receiver<()>; 2],
    alive: zenoh::liveliness::LivelinessToken,
}

impl Network {
    pub(crate) fn open(
        link: &Link,
        options: &ArenaOptions,
        simulation: &Simulation,
        inbox: &Arc<Inbox>,
        handover: Arc<Handover>,
        archive: Arc<Archive>,
    ) -> Result<Self, NetworkError> {
        let mut first = Snapshot::default();
        simulation.write_snapshot(&mut first);
        first.paused = options.paused;
        handover.stock(&first);
        let mut stats = Stats { paused: options.paused, speed_factor: 1.0, ..Stats::default() };
        simulation.write_stats(&mut stats);
        let latest = Arc::new(Latest {
            info: Info::new(options.arena.as_str(), options.tick_rate_hz),
            present: Mutex::new(Present { stage: simulation.stage(), state: Kept::new(first, &handover) }),
            stats: Mutex::new(stats),
            handover: handover.clone(),
            recorded: options.record.is_some(),
            readers: readers::Readers::default(),
            whole: Mutex::new(Bucket::full(WHOLE_BYTES_PER_S, Instant::now())),
            head: Mutex::default(),
        });
        let keys = Keys::new(&options.arena);
        let session = link.session();
        let ready_so_far = options.first.iter().filter(|command| command.needs_preparing()).count() as u64;
        let workshop = Workshop::start(Bench::new(simulation), inbox.clone(), archive.clone(), ready_so_far)?;
        let players = Arc::new(Players::new(inbox.clone()));
        let (known, drivers) = (latest.clone(), players.clone());
        let (answers, answered) = answers::Answers::start(move |query, answer| {
            answers::send(&known, &archive, &drivers, query, answer);
        })?;
        // Replies to commands do not wait behind answers to questions.
        let (replies, replied) =
            answers::Answers::start(|query, reply: Reply| answers::send_json(query, &reply))?;
        let gate = services::Gate::new(inbox, answers, replies, workshop, &players, &latest);
        let services = services::Services::declare(link, &keys, &gate, &latest)?;
        let driving = driving::Driving::declare(session, &keys, &gate)?;
        let publisher = publisher::Publisher::declare(session, &keys, latest.clone(), handover, players)?;
        // Last: who sees the token finds everything else in place. The epoch is a number, so this is a name.
        let id: Name = simulation.epoch().to_string().parse().expect("digits are a name");
        let alive = session.liveliness().declare_token(keys.alive(Role::Server, &id)).wait()?;
        Ok(Self { latest, publisher, services, driving, answered: [answered, replied], alive })
    }

    /// What questions are answered from.
    pub(crate) const fn latest(&self) -> &Arc<Latest> {
        &self.latest
    }

    /// Publishes until the tick loop has ended, then takes everything back.
    pub(crate) fn run(mut self) {
        self.publisher.run();
        drop((self.alive, self.services, self.driving, self.publisher));
        // What is still to be answered goes out first; a client that does not read has to do without.
        for answered in self.answered {
            if answered.recv_timeout(CLOSE_TIMEOUT) == Err(RecvTimeoutError::Timeout) {
                tracing::debug!("not everything was answered");
            }
        }
    }
}
