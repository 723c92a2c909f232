//! What takes longer than a tick has is made ready here, on a thread of its own: long commands are read, places solved,
//! floors proved, clouds placed. The tick loop swaps in what comes out.

use crate::change::{Change, meant};
use crate::history::Archive;
use crate::inbox::{Answer, ENDING, Inbox, Refused, Request};
use crate::ready::Ready;
use crate::scene_file::{SceneError, SceneText};
use crate::simulation::Simulation;
use crate::world::{Present, World};
use protocol::codec::{self, CodecError};
use protocol::command::{Command, Refusal, RunState, Scope, code};
use protocol::listing::Selection;
use protocol::timeline::SavedState;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::time::Duration;

/// Jobs that wait; what comes beyond is refused.
pub const MAX_JOBS: usize = 64;
/// Time between two looks at whether the tick loop is still there.
const PATIENCE: Duration = Duration::from_millis(100);

/// Makes things ready for the present world.
pub struct Bench {
    present: Arc<Present>,
    tick_rate_hz: u32,
    /// What the arena was started with.
    origin: SceneText,
}

impl Bench {
    /// For an arena that begins like this.
    pub fn new(simulation: &Simulation) -> Self {
        Self {
            present: simulation.present().clone(),
            tick_rate_hz: simulation.tick_rate_hz(),
            origin: simulation.loaded().source().clone(),
        }
    }

    /// What `command` needs.
    pub fn prepare(&self, command: &Command) -> Result<Ready, Refusal> {
        let world = self.present.world();
        let change = |change: Result<Change, Refusal>| Ok(Ready::Change(Box::new(change?)));
        match command {
            Command::SetBalls { balls, select: None, .. } => {
                let seats = world.seats(balls)?;
                Ok(Ready::Seats(world, seats))
            }
            Command::Spawn { balls } => change(Change::spawn(&world, balls)),
            // Who is in a region is known only at the tick.
            Command::Delete(selection) if selection.within_m.is_some() => Ok(Ready::Nothing),
            Command::Delete(selection) => change(deletion(&world, selection)),
            Command::MoveControlPoints { points } => change(Change::move_points(&world, points)),
            Command::SetParameters { values } => change(Change::set_parameters(&world, values)),
            Command::Reset { scope, seed: Some(_) } if *scope != Scope::All => Err(Refusal::new(
                code::FEATURE_UNSUPPORTED,
                "a seed makes other balls: leave the scope out, or the seed",
            )),
            Command::Reset { scope: Scope::Spawned, .. } if !world.roster().spawned.is_empty() => {
                change(deletion(&world, &Selection { spawned: Some(true), ..Selection::default() }))
            }
            Command::SetState { state: RunState::Stopped } => {
                self.prepare(&Command::Reset { scope: Scope::All, seed: None })
            }
            Command::ReloadScene {} => self.world(&self.origin.reopen().map_err(|error| bad_scene(&error))?),
            Command::Reset { scope: Scope::All, seed }
                if seed.is_some() || world.loaded().source().seed().is_some() =>
            {
                self.world(&world.loaded().source().clone().with_seed(*seed))
            }
            Command::LoadScene { name, toml, balls } => {
                let text = match name {
                    Some(name) => SceneText::built_in(name)
                        .map_err(|error| Refusal::new(code::NOT_FOUND, error.to_string()))?,
                    None => SceneText::new("toml", toml.clone().unwrap_or_default()),
                };
                self.world(&text.with_balls(*balls))
            }
            _ => Ok(Ready::Nothing),
        }
    }

    fn world(&self, text: &SceneText) -> Result<Ready, Refusal> {
        let loaded = Arc::new(text.load().map_err(|error| bad_scene(&error))?);
        let world = Simulation::new(loaded, self.tick_rate_hz, 0).map_err(|error| bad_scene(&error))?;
        Ok(Ready::World(Box::new(world)))
    }

    /// The command as a recording can repeat it: what was read from a file is in it.
    fn spelled_out(command: Command, ready: &Ready) -> Command {
        let (Command::ReloadScene {}, Ready::World(next)) = (&command, ready) else { return command };
        let source = next.loaded().source();
        Command::LoadScene { name: None, toml: Some(source.text().to_owned()), balls: source.balls() }
    }
}

/// For a selection that does not ask where balls are.
fn deletion(world: &Arc<World>, selection: &Selection) -> Result<Change, Refusal> {
    Change::delete(world, &meant(world, selection, |_| [0.0; 2])?)
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

/// How a saved state, or why there is none, reaches whoever asked.
pub type Told = Box<dyn FnOnce(Result<SavedState, Refusal>) + Send>;

/// What the thread is asked for.
enum Order {
    Ready(Job, Option<Answer>),
    /// What a slot holds, or the present.
    Saved(Option<String>, Told),
}

/// The way to the thread, which ends when all copies of it are gone.
#[derive(Clone)]
pub struct Workshop(SyncSender<Order>);

impl Workshop {
    /// Starts the thread; so many commands were passed on ready before.
    pub fn start(
        bench: Bench,
        inbox: Arc<Inbox>,
        archive: Arc<Archive>,
        ready_so_far: u64,
    ) -> std::io::Result<Self> {
        let (orders, waiting) = sync_channel(MAX_JOBS);
        let thread = std::thread::Builder::new().name("prepare".into());
        thread.spawn(move || work(&bench, &inbox, &archive, waiting, ready_so_far))?;
        Ok(Self(orders))
    }

    /// Has something made ready and passed on, without waiting; or gives back whom to tell why not.
    pub fn give(&self, job: Job, answer: Option<Answer>) -> Result<(), (Option<Answer>, Refusal)> {
        self.order(Order::Ready(job, answer)).map_err(|refused| match *refused {
            (Order::Ready(_, answer), why) => (answer, why),
            (Order::Saved(..), why) => (None, why),
        })
    }

    /// Has a state written down, without waiting: what a slot holds, or the present one.
    pub fn save(&self, slot: Option<String>, told: Told) {
        if let Err(refused) = self.order(Order::Saved(slot, told))
            && let (Order::Saved(_, told), why) = *refused
        {
            told(Err(why));
        }
    }

    fn order(&self, order: Order) -> Result<(), Box<(Order, Refusal)>> {
        self.0.try_send(order).map_err(|error| {
            Box::new(match error {
                TrySendError::Full(order) => {
                    let why = format!("{MAX_JOBS} commands that take long wait already: send fewer");
                    (order, Refusal::new(code::TOO_MANY, why))
                }
                TrySendError::Disconnected(order) => (order, Refusal::new(code::ENDING, ENDING)),
            })
        })
    }
}

fn work(bench: &Bench, inbox: &Inbox, archive: &Archive, orders: Receiver<Order>, mut ready_so_far: u64) {
    for order in orders {
        let (job, answer) = match order {
            Order::Ready(job, answer) => (job, answer),
            Order::Saved(slot, told) => {
                told(archive.saved(slot.as_deref()));
                continue;
            }
        };
        let command = match job {
            Job::Command(command) => Ok(command),
            Job::Text(text) => read(&text),
        };
        let made = command.and_then(|command| make_ready(bench, archive, command, ready_so_far));
        let (answer, why) = match made {
            Ok((command, ready)) => {
                let was_prepared = command.needs_preparing();
                match pass_on(inbox, command, ready, answer) {
                    Ok(()) => {
                        ready_so_far += u64::from(was_prepared);
                        continue;
                    }
                    Err(Refused { answer, why }) => (answer, why),
                }
            }
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

/// Passes on what is ready. What may change the world is waited for: the next thing is made ready for what came of it.
fn pass_on(inbox: &Inbox, command: Command, ready: Ready, answer: Option<Answer>) -> Result<(), Refused> {
    if !command.may_change_world() {
        return inbox.offer(Request { command, ready, answer });
    }
    let (done, acted) = sync_channel(1);
    let tell: Answer = Box::new(move |reply| {
        done.send(()).ok();
        if let Some(answer) = answer {
            answer(reply);
        }
    });
    let offered = inbox.offer(Request { command, ready, answer: Some(tell) });
    if offered.is_ok() {
        // A tick loop that has ended may never say.
        while acted.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) && !inbox.is_closed() {}
    }
    offered
}

/// A command as it shall be obeyed, and what was made ready for it.
fn make_ready(
    bench: &Bench,
    archive: &Archive,
    command: Command,
    ready_so_far: u64,
) -> Result<(Command, Ready), Refusal> {
    if !command.needs_the_past() {
        let ready = bench.prepare(&command)?;
        return Ok((Bench::spelled_out(command, &ready), ready));
    }
    let planned = archive.plan(command, ready_so_far);
    let (command, plan) = planned.unwrap_or_else(|| Err(Refusal::new(code::ENDING, ENDING)))?;
    let ready = plan.carry_out()?;
    Ok((command, ready))
}

/// Reads a command, or says what is wrong with it.
pub fn read(text: &[u8]) -> Result<Command, Refusal> {
    codec::decode_command(text).map_err(|error| {
        let code = if matches!(error, CodecError::TooLong { .. }) { code::TOO_LONG } else { code::MALFORMED };
        Refusal::new(code, error.to_string())
    })
}
