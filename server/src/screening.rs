//! A recording shown again: published like a live run, at any speed, while every hash is compared. The clock obeys whoever
//! watches; the world obeys the recording.

use crate::arena::{ArenaError, ArenaOptions};
use crate::handover::{HITS_CAPACITY, Handover};
use crate::history::{Archive, Diary, Settings};
use crate::inbox::{Answer, Answered, ENDING, Inbox, Request};
use crate::meter::Meter;
use crate::network;
use crate::recording::{Audience, Reader, ReplayError, Verdict, begin, replay_before};
use crate::simulation::{NumberedHit, Simulation};
use crate::wanted::Moment;
use protocol::command::{Command, Refusal, Reply, RunState, SpeedFactor, code};
use protocol::stats::Stats;
use std::io::Read;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

/// Longest sleep: within it a stop is seen, and a command.
const SLICE: Duration = Duration::from_millis(20);

/// Why a recording was not shown to its end.
#[derive(Debug, thiserror::Error)]
pub enum ScreeningError {
    /// It cannot be published.
    #[error(transparent)]
    Arena(#[from] ArenaError),
    /// It cannot be replayed.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

/// A recording that is ready to be shown.
pub struct Screening<R> {
    reader: Reader<R>,
    simulation: Simulation,
    inbox: Arc<Inbox>,
    handover: Arc<Handover>,
    diary: Diary,
    publisher: JoinHandle<()>,
    link: network::Link,
    paused: bool,
}

const fn run_state(paused: bool) -> RunState {
    if paused { RunState::Paused } else { RunState::Playing }
}

impl<R: Read> Screening<R> {
    /// Publishes the first state. Of the options the arena's name, the network's and `paused` count.
    pub fn open(mut reader: Reader<R>, options: &ArenaOptions) -> Result<Self, ScreeningError> {
        let simulation = begin(&mut reader)?;
        let options = ArenaOptions { tick_rate_hz: simulation.tick_rate_hz(), ..options.clone() };
        let (inbox, handover) = (Arc::new(Inbox::default()), Arc::new(Handover::new()));
        let (archive, diary) = Archive::new(&simulation, Settings::live(0));
        handover.set_run_state(run_state(options.paused));
        let link = network::Link::open(&options.network).map_err(ArenaError::from)?;
        let network = network::Network::open(&link, &options, &simulation, &inbox, handover.clone(), archive)
            .map_err(ArenaError::from)?;
        let thread = std::thread::Builder::new().name("publish".into());
        let publisher = thread.spawn(move || network.run()).map_err(ArenaError::from)?;
        let paused = options.paused;
        Ok(Self { reader, simulation, inbox, handover, diary, publisher, link, paused })
    }

    /// Where clients connect to.
    pub fn endpoint(&self) -> &str {
        self.link.endpoints().first().map_or("", String::as_str)
    }

    /// Shows it to its end, to the first difference, or until `stop` says so.
    pub fn run(self, speed: SpeedFactor, stop: impl Fn() -> bool) -> Result<Verdict, ScreeningError> {
        let Self { mut reader, simulation, inbox, handover, diary, publisher, link, paused } = self;
        let mut projector = Projector {
            stop,
            inbox: inbox.clone(),
            handover: handover.clone(),
            diary,
            clock: Clock { paused, speed_factor: 1.0, as_fast_as_possible: false, due: Instant::now() },
            steps: None,
            now: (simulation.epoch(), simulation.tick()),
            rate_hz: simulation.tick_rate_hz(),
            sequence: 0,
            hits: Vec::with_capacity(HITS_CAPACITY),
            answers: Vec::new(),
            meter: Meter::new(),
            began: Instant::now(),
        };
        projector.clock.set_speed(speed);
        projector.hand_over(&simulation);
        let shown = if projector.wait(&simulation) {
            replay_before(&mut reader, simulation, &mut projector)
        } else {
            Err(ReplayError::Stopped)
        };
        projector.end();
        // Whoever panicked has said so.
        drop(publisher.join());
        link.close();
        Ok(shown?.0)
    }
}

/// How ticks meet the wall clock.
struct Clock {
    paused: bool,
    speed_factor: f64,
    as_fast_as_possible: bool,
    due: Instant,
}

impl Clock {
    fn set_speed(&mut self, factor: SpeedFactor) {
        self.as_fast_as_possible = matches!(factor, SpeedFactor::Named(_));
        if let SpeedFactor::Times(factor) = factor {
            self.speed_factor = factor;
        }
        self.due = Instant::now();
    }
}

/// Shows ticks as they are made, when they are due.
struct Projector<S> {
    stop: S,
    inbox: Arc<Inbox>,
    handover: Arc<Handover>,
    diary: Diary,
    clock: Clock,
    /// How many ticks a clock that stands is still to be stepped, and whom to tell.
    steps: Option<(u64, Option<Answer>)>,
    now: (u64, u64),
    rate_hz: u32,
    sequence: u64,
    hits: Vec<NumberedHit>,
    answers: Vec<Answered>,
    meter: Meter,
    /// When the present tick did.
    began: Instant,
}

impl<S: Fn() -> bool> Audience for &mut Projector<S> {
    fn ticked(&mut self, simulation: &Simulation) -> bool {
        self.meter.record(self.began.elapsed());
        self.now = (simulation.epoch(), simulation.tick());
        let (epoch, hits) = (simulation.epoch(), simulation.hits());
        let room = HITS_CAPACITY.saturating_sub(self.hits.len()).min(hits.len());
        let numbered = (self.sequence..).zip(&hits[..room]);
        self.hits.extend(numbered.map(|(sequence, &hit)| NumberedHit { epoch, sequence, hit }));
        self.sequence += hits.len() as u64;
        self.handover.count_dropped((hits.len() - room) as u64);
        if let Some((left, _)) = &mut self.steps {
            *left -= 1;
            if *left == 0 {
                self.end_steps(Ok(()));
            }
        }
        self.hand_over(simulation);
        self.report(simulation);
        let goes_on = self.wait(simulation);
        self.began = Instant::now();
        goes_on
    }

    fn obeyed(&mut self, simulation: &Simulation) {
        let before = std::mem::replace(&mut self.now, (simulation.epoch(), simulation.tick()));
        if before.0 != simulation.epoch() {
            self.sequence = 0;
            self.handover.put_stage(simulation.stage());
        }
        self.hand_over(simulation);
    }

    fn goes_on(&mut self) -> bool {
        !(self.stop)()
    }
}

impl<S: Fn() -> bool> Projector<S> {
    /// Until the next tick is due; false when there shall be none.
    fn wait(&mut self, simulation: &Simulation) -> bool {
        loop {
            if (self.stop)() {
                return false;
            }
            if self.obey_commands() {
                self.hand_over(simulation);
            }
            let now = Instant::now();
            if self.steps.is_some() || (self.clock.as_fast_as_possible && !self.clock.paused) {
                self.clock.due = now;
                return true;
            }
            if self.clock.paused {
                self.clock.due = now;
                self.inbox.wait_until(now + SLICE);
                self.report(simulation);
            } else if now < self.clock.due {
                self.inbox.wait_until(self.clock.due.min(now + SLICE));
            } else {
                let period =
                    Duration::from_secs_f64(1.0 / (f64::from(self.rate_hz) * self.clock.speed_factor));
                self.clock.due = (self.clock.due + period).max(now);
                return true;
            }
        }
    }

    /// True when there were any.
    fn obey_commands(&mut self) -> bool {
        let mut requests = Vec::new();
        self.inbox.drain_into(&mut requests, Moment { epoch: self.now.0, tick: self.now.1 });
        let any = !requests.is_empty();
        for Request { command, answer, .. } in requests {
            if command.needs_preparing() {
                self.diary.used();
            }
            let done = match self.obey(&command) {
                Ok(Some(ticks)) => {
                    self.inbox.count_accepted();
                    self.steps = Some((ticks, answer));
                    continue;
                }
                Ok(None) => Ok(()),
                Err(refusal) => Err(refusal),
            };
            if done.is_ok() {
                self.inbox.count_accepted();
            } else {
                self.inbox.count_refused();
            }
            if let Some(answer) = answer {
                let reply = Reply::of(done, self.now.1, self.now.0);
                self.answers.push(Answered { answer, reply });
            }
        }
        any
    }

    /// How many ticks to step, if that is what was asked for.
    fn obey(&mut self, command: &Command) -> Result<Option<u64>, Refusal> {
        let refuse = |why: &str| Err(Refusal::new(code::INCORRECT_STATE, why));
        let interrupted = || Err(Refusal::new(code::INTERRUPTED, "paused or resumed before the last step"));
        match command {
            Command::Pause {} | Command::Resume {} => {
                self.end_steps(interrupted());
                self.clock.paused = matches!(command, Command::Pause {});
                self.handover.set_run_state(run_state(self.clock.paused));
            }
            Command::Speed { factor } => self.clock.set_speed(*factor),
            Command::Step { .. } if !self.clock.paused => {
                return refuse("the clock runs: pause before stepping");
            }
            Command::Step { .. } if self.steps.is_some() => {
                return refuse("the last steps are still being made");
            }
            Command::Step { ticks } => return Ok(Some(*ticks)),
            _ => return refuse("this is a recording: pause, resume, step and speed are all that it obeys"),
        }
        Ok(None)
    }

    fn end_steps(&mut self, done: Result<(), Refusal>) {
        if let Some((_, Some(answer))) = self.steps.take() {
            let reply = Reply::of(done, self.now.1, self.now.0);
            self.answers.push(Answered { answer, reply });
        }
    }

    fn hand_over(&mut self, simulation: &Simulation) {
        let mut state = self.handover.buffer();
        simulation.write_snapshot(&mut state);
        state.paused = self.clock.paused;
        let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        state.wall_ns = since_1970.as_nanos() as u64;
        self.handover.put(Some(state), &mut self.hits, &mut self.answers, None);
    }

    fn report(&mut self, simulation: &Simulation) {
        let Some(figures) = self.meter.each_second(!self.clock.paused) else { return };
        let [commands_accepted, commands_refused] = self.inbox.counts();
        let mut stats = Stats {
            paused: self.clock.paused,
            speed_factor: self.clock.speed_factor,
            as_fast_as_possible: self.clock.as_fast_as_possible,
            real_time_factor: figures.ticks_per_s / f64::from(self.rate_hz),
            tick_micros: figures.tick_micros,
            commands_accepted,
            commands_refused,
            ..Stats::default()
        };
        simulation.write_stats(&mut stats);
        self.handover.put(None, &mut self.hits, &mut self.answers, Some(stats));
    }

    /// Nobody who asked is left without an answer.
    fn end(mut self) {
        self.end_steps(Err(Refusal::new(code::ENDING, ENDING)));
        self.inbox.close();
        let mut requests = Vec::new();
        self.inbox.drain_all_into(&mut requests);
        for answer in requests.into_iter().filter_map(|request| request.answer) {
            let reply = Reply::of(Err(Refusal::new(code::ENDING, ENDING)), self.now.1, self.now.0);
            self.answers.push(Answered { answer, reply });
        }
        self.handover.put(None, &mut self.hits, &mut self.answers, None);
        self.handover.end();
    }
}
