//! What takes longer than a tick has is made ready here, on a thread of its own: long commands are read, places solved,
//! floors proved, clouds placed. The tick loop swaps in what comes out.

use crate::inbox::{Answer, ENDING, Inbox, Refused, Request};
use crate::places::Places;
use crate::scene_file::{LoadedScene, SceneError, SceneText};
use crate::simulation::Simulation;
use ballroom_physics::Seat;
use protocol::codec::{self, CodecError};
use protocol::command::{Command, Refusal, RunState, Scope, code};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};

/// Jobs that wait; what comes beyond is refused.
pub const MAX_JOBS: usize = 64;

/// What was made ready for a command.
#[derive(Default)]
pub enum Ready {
    /// Nothing was needed.
    #[default]
    Nothing,
    /// Places on the floor.
    Seats(Vec<Seat>),
    /// A world, to take the place of the present one.
    World(Box<Simulation>),
}

/// Makes things ready for the world that will be there when they are used: what is made ready acts in its own order.
pub struct Bench {
    /// The scene as it was loaded, with its own seeds.
    loaded: Arc<LoadedScene>,
    /// Of the present world.
    places: Places,
    tick_rate_hz: u32,
    is_seeded: bool,
    /// What the arena was started with.
    origin: Arc<LoadedScene>,
}

impl Bench {
    /// For an arena that begins like this.
    pub fn new(simulation: &Simulation) -> Self {
        Self {
            loaded: simulation.loaded().clone(),
            places: simulation.places().clone(),
            tick_rate_hz: simulation.tick_rate_hz(),
            is_seeded: false,
            origin: simulation.loaded().clone(),
        }
    }

    /// What `command` needs, and the bench as it is once that is used.
    pub fn prepare(&self, command: &Command) -> Result<(Ready, Option<Self>), Refusal> {
        match command {
            Command::SetBalls { balls } => Ok((Ready::Seats(self.places.seats(balls)?), None)),
            Command::Reset { scope: Scope::Spawned, .. } => Err(Refusal::new(
                code::FEATURE_UNSUPPORTED,
                "nothing can be spawned here: reset all, time or state",
            )),
            Command::Reset { scope, seed: Some(_) } if *scope != Scope::All => Err(Refusal::new(
                code::FEATURE_UNSUPPORTED,
                "a seed makes other balls: leave the scope out, or the seed",
            )),
            Command::SetState { state: RunState::Stopped } => {
                self.prepare(&Command::Reset { scope: Scope::All, seed: None })
            }
            Command::Reset { scope: Scope::All, seed } if seed.is_some() || self.is_seeded => {
                let scene = self
                    .loaded
                    .source()
                    .clone()
                    .with_seed(*seed)
                    .load()
                    .map_err(|error| bad_scene(&error))?;
                self.world(self.loaded.clone(), Arc::new(scene), seed.is_some())
            }
            Command::ReloadScene {} => {
                let text = self.origin.source().reopen().map_err(|error| bad_scene(&error))?;
                let loaded = Arc::new(text.load().map_err(|error| bad_scene(&error))?);
                self.world(loaded.clone(), loaded, false)
            }
            Command::LoadScene { name, toml, balls } => {
                let text = match (name, toml) {
                    (Some(name), _) => {
                        SceneText::built_in(name).map_err(|e| Refusal::new(code::NOT_FOUND, e.to_string()))?
                    }
                    (None, toml) => SceneText::new("toml", toml.clone().unwrap_or_default()),
                };
                let loaded = Arc::new(text.with_balls(*balls).load().map_err(|error| bad_scene(&error))?);
                self.world(loaded.clone(), loaded, false)
            }
            _ => Ok((Ready::Nothing, None)),
        }
    }

    /// The command as a recording can repeat it: what was read from a file is in it.
    fn spelled_out(&self, command: Command) -> Command {
        let Command::ReloadScene {} = command else { return command };
        let source = self.loaded.source();
        Command::LoadScene { name: None, toml: Some(source.text().to_owned()), balls: source.balls() }
    }

    fn world(
        &self,
        loaded: Arc<LoadedScene>,
        scene: Arc<LoadedScene>,
        is_seeded: bool,
    ) -> Result<(Ready, Option<Self>), Refusal> {
        let tick_rate_hz = self.tick_rate_hz;
        let world = Simulation::new(scene, tick_rate_hz, 0).map_err(|error| bad_scene(&error))?;
        let places = world.places().clone();
        let origin = self.origin.clone();
        Ok((Ready::World(Box::new(world)), Some(Self { loaded, places, tick_rate_hz, is_seeded, origin })))
    }
}

fn bad_scene(error: &SceneError) -> Refusal {
    Refusal::new(code::BAD_SCENE, error.to_string())
}

/// What is to be made ready.
pub enum Job {
    /// A command that was read.
    Command(Command),
    /// One too long to be read where it arrives.
    Text(Vec<u8>),
}

/// The way to the thread, which ends when all copies of it are gone.
#[derive(Clone)]
pub struct Workshop(SyncSender<(Job, Option<Answer>)>);

impl Workshop {
    /// Starts the thread.
    pub fn start(bench: Bench, inbox: Arc<Inbox>) -> std::io::Result<Self> {
        let (jobs, waiting) = sync_channel(MAX_JOBS);
        std::thread::Builder::new().name("prepare".into()).spawn(move || work(bench, &inbox, waiting))?;
        Ok(Self(jobs))
    }

    /// Has something made ready and passed on, without waiting; or gives back whom to tell why not.
    pub fn give(&self, job: Job, answer: Option<Answer>) -> Result<(), (Option<Answer>, Refusal)> {
        self.0.try_send((job, answer)).map_err(|error| match error {
            TrySendError::Full((_, answer)) => {
                let why = format!("{MAX_JOBS} commands that take long wait already: send fewer");
                (answer, Refusal::new(code::TOO_MANY, why))
            }
            TrySendError::Disconnected((_, answer)) => (answer, Refusal::new(code::ENDING, ENDING)),
        })
    }
}

fn work(mut bench: Bench, inbox: &Inbox, jobs: Receiver<(Job, Option<Answer>)>) {
    for (job, answer) in jobs {
        let command = match job {
            Job::Command(command) => Ok(command),
            Job::Text(text) => read(&text),
        };
        let made = command.and_then(|command| {
            let (ready, next) = bench.prepare(&command)?;
            let command = next.as_ref().unwrap_or(&bench).spelled_out(command);
            Ok(((ready, next), command))
        });
        let (answer, why) = match made {
            Ok(((ready, next), command)) => match inbox.offer(Request { command, ready, answer }) {
                Ok(()) => {
                    bench = next.unwrap_or(bench);
                    continue;
                }
                Err(Refused { answer, why }) => (answer, why),
            },
            Err(why) => (answer, why),
        };
        inbox.count_refused();
        if let Some(answer) = answer {
            answer(&why.into());
        } else {
            tracing::debug!("refused: {why}");
        }
    }
}

/// Reads a command, or says what is wrong with it.
pub fn read(text: &[u8]) -> Result<Command, Refusal> {
    codec::decode_command(text).map_err(|error| {
        let code = if matches!(error, CodecError::TooLong { .. }) { code::TOO_LONG } else { code::MALFORMED };
        Refusal::new(code, error.to_string())
    })
}
