//! Several arenas in one process, over one session. Each has threads of its own and shares nothing with the others but
//! the session; one that stalls, ends or panics is no business of theirs.

use crate::arena::{Arena, ArenaError, ArenaHandle, ArenaOptions, NetworkOptions};
use crate::inbox::{Answer, ENDING};
use crate::network::{DoorJob, Doors, Latest, Link, NetworkError};
use crate::recording::RecordOptions;
use crate::scene_file::SceneText;
use protocol::arenas::{ArenaCommand, Arenas as List, MAX_ARENAS};
use protocol::command::{Refusal, Reply, code};
use protocol::keys::Name;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How often it is looked at who has ended.
const LOOK_AROUND: Duration = Duration::from_millis(20);
/// Most who wait for the end of one arena.
const MAX_TOLD: usize = 16;
/// Most recordings begun by request in the life of a process: nobody fills a directory from afar.
pub const MAX_RECORDINGS: usize = 256;

/// The arenas of a process.
pub struct Arenas {
    link: Link,
    board: Board,
    places: BTreeMap<Name, Place>,
    jobs: Receiver<DoorJob>,
    started: (SyncSender<Started>, Receiver<Started>),
    /// What requests may record beside.
    record: Option<RecordOptions>,
    recordings: usize,
    faults: Vec<Name>,
    doors: Doors,
}

/// Where an arena of a name stands.
enum Place {
    /// Its scene is being loaded.
    Starting,
    /// It runs, or has been told to stop by these.
    Running(Box<ArenaHandle>, Vec<Answer>),
}

/// What came of a start.
struct Started {
    name: Name,
    arena: Result<Box<ArenaHandle>, ArenaError>,
    answer: Answer,
}

/// What a list is made from.
#[derive(Clone, Default)]
struct Board(Arc<Mutex<BTreeMap<Name, Arc<Latest>>>>);

impl Board {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<Name, Arc<Latest>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn list(&self) -> List {
        List { arenas: self.lock().values().map(|latest| latest.row()).collect(), max_arenas: MAX_ARENAS }
    }
}

impl Arenas {
    /// Opens the session. `record` is what arenas started by request are recorded like and beside, if they may be.
    pub fn open(network: &NetworkOptions, record: Option<RecordOptions>) -> Result<Self, NetworkError> {
        let link = Link::open(network)?;
        let board = Board::default();
        let listed = board.clone();
        let (doors, jobs) = Doors::declare(&link, move || listed.list())?;
        Ok(Self {
            link,
            board,
            places: BTreeMap::new(),
            jobs,
            started: sync_channel(MAX_ARENAS),
            record,
            recordings: 0,
            faults: Vec::new(),
            doors,
        })
    }

    /// Where clients connect to: the first endpoint listened on.
    pub fn endpoint(&self) -> &str {
        self.link.endpoints().first().map_or("", String::as_str)
    }

    /// Starts an arena, and waits until it runs; `options.network` is not used.
    pub fn start(&mut self, scene: &SceneText, options: &ArenaOptions) -> Result<(), ArenaError> {
        self.check_room(&options.arena).map_err(|refusal| ArenaError::Name(refusal.why))?;
        let arena = Arena::start_on(&self.link, scene, options)?;
        self.settle(options.arena.clone(), Box::new(arena));
        Ok(())
    }

    /// Obeys requests until told to stop or until every arena has ended; then ends all and gives the names of those
    /// that ended by a fault.
    pub fn run(mut self, is_asked_to_stop: impl Fn() -> bool) -> Vec<Name> {
        while !is_asked_to_stop() {
            self.sweep();
            if self.places.is_empty() {
                break;
            }
            match self.jobs.recv_timeout(LOOK_AROUND) {
                Ok((command, answer)) => self.obey(command, answer),
                Err(RecvTimeoutError::Timeout) => {}
                // The doors are closed below only.
                Err(RecvTimeoutError::Disconnected) => std::thread::sleep(LOOK_AROUND),
            }
        }
        self.end()
    }

    fn obey(&mut self, command: ArenaCommand, answer: Answer) {
        let refused = match command {
            ArenaCommand::Stop { arena } => match self.places.get_mut(&arena) {
                Some(Place::Running(_, told)) if told.len() >= MAX_TOLD => {
                    (answer, Refusal::new(code::TOO_MANY, format!("arena {arena} was told to stop already")))
                }
                Some(Place::Running(handle, told)) => {
                    handle.stop();
                    told.push(answer);
                    return;
                }
                Some(Place::Starting) => {
                    (answer, Refusal::new(code::INCORRECT_STATE, format!("arena {arena} is being started")))
                }
                None => (answer, self.unknown(&arena)),
            },
            ArenaCommand::Start { .. } => match self.begin(command) {
                Ok(begin) => {
                    begin(answer);
                    return;
                }
                Err(refusal) => (answer, refusal),
            },
        };
        (refused.0)(&refused.1.into());
    }

    fn unknown(&self, arena: &Name) -> Refusal {
        let names: Vec<&str> = self.places.keys().map(Name::as_str).collect();
        Refusal::new(code::NOT_FOUND, format!("no arena {arena}: there are {}", names.join(", ")))
    }

    fn check_room(&self, arena: &Name) -> Result<(), Refusal> {
        if self.places.contains_key(arena) {
            let why = format!("arena {arena} runs already: choose another name, or stop it");
            return Err(Refusal::new(code::OPERATION_FAILED, why));
        }
        if self.places.len() >= MAX_ARENAS {
            let why = format!("{MAX_ARENAS} arenas run already: stop one");
            return Err(Refusal::new(code::OPERATION_FAILED, why));
        }
        Ok(())
    }

    /// Keeps the place, and gives what starts the arena on a thread of its own: loading may take long.
    fn begin(&mut self, command: ArenaCommand) -> Result<impl FnOnce(Answer) + use<>, Refusal> {
        let ArenaCommand::Start { arena, scene, toml, balls, tick_rate_hz, paused, record } = command else {
            return Err(Refusal::new(code::MALFORMED, "no start"));
        };
        self.check_room(&arena)?;
        let record = if record { Some(self.recording_of(&arena)?) } else { None };
        let text = match (scene, toml) {
            (Some(scene), _) => {
                SceneText::built_in(&scene).map_err(|e| Refusal::new(code::NOT_FOUND, e.to_string()))?
            }
            (None, toml) => SceneText::new("toml", toml.unwrap_or_default()),
        };
        let text = text.with_balls(balls);
        self.places.insert(arena.clone(), Place::Starting);
        let options = ArenaOptions { arena, tick_rate_hz, paused, record, ..ArenaOptions::default() };
        let (link, started) = (self.link.clone(), self.started.0.clone());
        Ok(move |answer| {
            std::thread::spawn(move || {
                let arena = Arena::start_on(&link, &text, &options).map(Box::new);
                // Nobody listens any more once the process ends; the arena then ends here.
                drop(started.send(Started { name: options.arena, arena, answer }));
            });
        })
    }

    fn recording_of(&mut self, arena: &Name) -> Result<RecordOptions, Refusal> {
        let Some(record) = &self.record else {
            let why = "this server does not record: start it with --record FILE";
            return Err(Refusal::new(code::FEATURE_UNSUPPORTED, why));
        };
        if self.recordings >= MAX_RECORDINGS {
            let why = format!("{MAX_RECORDINGS} recordings were begun by request: no more");
            return Err(Refusal::new(code::OPERATION_FAILED, why));
        }
        self.recordings += 1;
        Ok(recording_beside(record, arena))
    }

    /// Takes in who has started and lets go who has ended.
    fn sweep(&mut self) {
        while let Ok(Started { name, arena, answer }) = self.started.1.try_recv() {
            match arena {
                Ok(arena) => {
                    let row = arena.latest().row();
                    tracing::info!("{} runs at {} Hz as arena {name}", row.scene, row.tick_rate_hz);
                    self.settle(name, arena);
                    answer(&Reply::of(Ok(()), row.tick, row.epoch));
                }
                Err(error) => {
                    self.places.remove(&name);
                    answer(&refusal_of(&error).into());
                }
            }
        }
        let is_over = |place: &Place| matches!(place, Place::Running(handle, _) if handle.is_finished());
        let ended: Vec<Name> =
            self.places.iter().filter(|(_, place)| is_over(place)).map(|(name, _)| name.clone()).collect();
        for name in ended {
            self.let_go(name);
        }
    }

    fn settle(&mut self, name: Name, arena: Box<ArenaHandle>) {
        self.board.lock().insert(name.clone(), arena.latest().clone());
        self.places.insert(name, Place::Running(arena, Vec::new()));
    }

    fn let_go(&mut self, name: Name) {
        let row = self.board.lock().remove(&name).map(|latest| latest.row());
        let Some(Place::Running(handle, told)) = self.places.remove(&name) else { return };
        let well = handle.join();
        if well {
            tracing::info!("arena {name} ended");
        } else {
            tracing::error!("arena {name} ended by a fault; the lines above say which");
        }
        let (tick, epoch) = row.map_or((0, 0), |row| (row.tick, row.epoch));
        for answer in told {
            answer(&Reply::of(Ok(()), tick, epoch));
        }
        if !well {
            self.faults.push(name);
        }
    }

    fn end(mut self) -> Vec<Name> {
        // All are told before any is waited for.
        for place in self.places.values() {
            if let Place::Running(handle, _) = place {
                handle.stop();
            }
        }
        for name in self.places.keys().cloned().collect::<Vec<_>>() {
            self.let_go(name);
        }
        let ending = Reply::from(Refusal::new(code::ENDING, ENDING));
        self.jobs.try_iter().for_each(|(_, answer)| answer(&ending));
        self.doors.close();
        self.link.close();
        self.faults
    }
}

/// The file of an arena beside the one that was named: `ride.mcap` becomes `ride-left.mcap`.
pub fn recording_beside(record: &RecordOptions, arena: &Name) -> RecordOptions {
    let stem = record.file.file_stem().unwrap_or_default().to_string_lossy();
    let end = record.file.extension().map_or(String::new(), |end| format!(".{}", end.to_string_lossy()));
    let file = record.file.with_file_name(Path::new(&format!("{stem}-{arena}{end}")));
    RecordOptions { file, ..record.clone() }
}

fn refusal_of(error: &ArenaError) -> Refusal {
    let code = if matches!(error, ArenaError::Scene(_)) { code::BAD_SCENE } else { code::OPERATION_FAILED };
    Refusal::new(code, error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arena_that_panics_ends_alone_and_is_named_at_the_end() {
        let network = NetworkOptions { listen: vec!["tcp/127.0.0.1:0".into()], ..NetworkOptions::default() };
        let mut arenas = Arenas::open(&network, None).unwrap();
        let scene = SceneText::open("plane").unwrap();
        let [bad, good] = ["bad", "good"].map(|name| name.parse::<Name>().unwrap());
        for arena in [&bad, &good] {
            let options = ArenaOptions { arena: arena.clone(), paused: true, ..ArenaOptions::default() };
            arenas.start(&scene, &options).unwrap();
        }
        let Some(Place::Running(handle, _)) = arenas.places.get_mut(&bad) else { panic!("it runs") };
        handle.break_down();
        while arenas.places.contains_key(&bad) {
            arenas.sweep();
            std::thread::sleep(LOOK_AROUND);
        }
        let left: Vec<String> = arenas.board.list().arenas.into_iter().map(|row| row.arena).collect();
        assert_eq!(left, ["good"]);
        let Some(Place::Running(handle, _)) = arenas.places.get(&good) else { panic!("it runs on") };
        assert!(!handle.is_finished());
        assert_eq!(arenas.run(|| true), [bad]);
    }

    #[test]
    fn a_recording_of_one_of_several_lies_beside_the_file_that_was_named() {
        let beside =
            |file: &str| recording_beside(&RecordOptions::new(file.into()), &"left".parse().unwrap()).file;
        assert_eq!(beside("a/ride.mcap"), Path::new("a/ride-left.mcap"));
        assert_eq!(beside("ride"), Path::new("ride-left"));
    }
}
