//! The tick loop: a fixed rate on a plain thread. It never awaits, never publishes, and never chases lost time.

use crate::handover::{HITS_CAPACITY, Handover};
use crate::history::{Archive, Diary, Settings};
use crate::inbox::{Answer, Answered, ENDING, INBOX_CAPACITY, Inbox, Request};
use crate::meter::Meter;
use crate::ready::Ready;
use crate::recording::Tape;
use crate::shadows::Sampler;
use crate::simulation::{NumberedHit, Simulation};
use crate::wanted::{Moment, WANTED_CAPACITY};
use ballroom_physics::Observer;
use protocol::command::{Command, MAX_RUN_TICKS, Refusal, Reply, RunState, Scope, SpeedFactor, code};
use protocol::stats::Stats;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};

/// Longest sleep: within it the loop sees a stop, and a command when the clock stands or runs slowly.
const SLICE: Duration = Duration::from_millis(20);
/// How far behind its deadlines a loop may be and still catch up, in periods; what is more is lost, so that a stall
/// lowers the real-time factor and is over when it is over.
const BACKLOG_PERIODS: u32 = 1;

/// A simulation, and how its ticks meet the wall clock.
pub struct TickLoop {
    simulation: Simulation,
    inbox: Arc<Inbox>,
    handover: Arc<Handover>,
    stop: Arc<AtomicBool>,
    paused: bool,
    state: RunState,
    speed_factor: f64,
    as_fast_as_possible: bool,
    /// When the next tick is due, while the clock runs.
    due: Instant,
    stepping: Option<Stepping>,
    meter: Meter,
    /// Number of the epoch's next hit.
    sequence: u64,
    requests: Vec<Request>,
    answers: Vec<Answered>,
    hits: Vec<NumberedHit>,
    tape: Tape,
    diary: Diary,
    shadows: Option<Sampler>,
    observer: Observer,
}

/// Steps still to be made while the clock stands.
struct Stepping {
    last_tick: u64,
    answer: Option<Answer>,
}

impl TickLoop {
    /// A loop that has not begun.
    pub fn new(
        simulation: Simulation,
        inbox: Arc<Inbox>,
        handover: Arc<Handover>,
        stop: Arc<AtomicBool>,
        paused: bool,
    ) -> Self {
        let (_, diary) = Archive::new(&simulation, Settings::live(0));
        Self {
            simulation,
            inbox,
            handover,
            stop,
            paused,
            state: if paused { RunState::Paused } else { RunState::Playing },
            speed_factor: 1.0,
            as_fast_as_possible: false,
            due: Instant::now(),
            stepping: None,
            meter: Meter::new(),
            sequence: 0,
            requests: Vec::with_capacity(INBOX_CAPACITY + WANTED_CAPACITY),
            answers: Vec::with_capacity(INBOX_CAPACITY + WANTED_CAPACITY),
            hits: Vec::with_capacity(HITS_CAPACITY),
            tape: Tape::default(),
            diary,
            shadows: None,
            observer: Observer::default(),
        }
    }

    /// The same, with what is done kept, to be gone back to.
    #[must_use]
    pub fn remembered_in(mut self, diary: Diary) -> Self {
        self.diary = diary;
        self
    }

    /// The same, with a few balls followed by shadows.
    #[must_use]
    pub fn followed_by(mut self, shadows: Option<Sampler>) -> Self {
        self.shadows = shadows;
        self
    }

    /// The same, with what is done written down.
    #[must_use]
    pub fn recorded_on(mut self, tape: Tape) -> Self {
        self.tape = tape;
        self
    }

    /// Runs until told to stop: drain, advance, hand over, sleep to the next deadline.
    pub fn run(mut self) {
        let (handover, inbox) = (self.handover.clone(), self.inbox.clone());
        // Also when a tick panics: neither the publisher nor the workshop may wait for ever.
        let _end = OnDrop(|| {
            inbox.close();
            handover.end();
        });
        self.hand_over();
        if let Some(shadows) = &mut self.shadows {
            shadows.give(&self.simulation);
        }
        self.due = Instant::now();
        while !self.stop.load(Ordering::Relaxed) {
            let touched = self.apply_commands();
            if let Some(shadows) = self.shadows.as_mut().filter(|_| touched) {
                shadows.commanded();
            }
            self.diary.show(&self.simulation);
            if self.state == RunState::Quitting {
                break;
            }
            let now = Instant::now();
            if self.stepping.is_some() {
                self.make_steps(now + SLICE);
            } else if self.paused {
                if touched {
                    self.hand_over();
                }
                self.due = now;
                self.inbox.wait_until(now + SLICE);
            } else if self.as_fast_as_possible {
                self.make_ticks(now + SLICE, u64::MAX);
                self.hand_over();
                self.due = Instant::now();
            } else if now < self.due {
                std::thread::sleep((self.due - now).min(SLICE));
            } else {
                self.tick();
                self.hand_over();
                self.due = self.next_deadline(self.due, now);
            }
            self.report_each_second();
        }
        self.tape.end(&self.simulation);
        self.refuse_what_waits();
    }

    /// Nobody who asked is left without an answer when the server ends.
    fn refuse_what_waits(&mut self) {
        self.end_stepping(Err(Refusal::new(code::ENDING, ENDING)));
        self.inbox.close();
        let mut requests = std::mem::take(&mut self.requests);
        self.inbox.drain_all_into(&mut requests);
        for answer in requests.drain(..).filter_map(|request| request.answer) {
            self.inbox.count_refused();
            let reply = self.reply(Err(Refusal::new(code::ENDING, ENDING)));
            self.answers.push(Answered { answer, reply });
        }
        self.handover.put(None, &mut self.hits, &mut self.answers, None);
    }

    const fn now(&self) -> Moment {
        Moment { epoch: self.simulation.epoch(), tick: self.simulation.tick() }
    }

    fn period(&self) -> Duration {
        Duration::from_secs_f64(1.0 / (f64::from(self.simulation.tick_rate_hz()) * self.speed_factor))
    }

    fn next_deadline(&mut self, due: Instant, began: Instant) -> Instant {
        let period = self.period();
        let (due, now) = (due + period, Instant::now());
        self.meter.record(now - began);
        let behind = now.saturating_duration_since(due);
        if behind > Duration::ZERO {
            self.meter.count_overrun();
        }
        if behind > period * BACKLOG_PERIODS { now } else { due }
    }

    fn tick(&mut self) {
        if self.state == RunState::Stopped {
            self.enter(RunState::Paused);
        }
        self.simulation.advance();
        self.tape.ticked(&self.simulation, self.paused);
        self.diary.ticked(&self.simulation);
        if let Some(shadows) = &mut self.shadows {
            shadows.ticked(&self.simulation);
        }
        let epoch = self.simulation.epoch();
        let hits = self.simulation.hits();
        // The handover has no room for more, and a tick takes no memory; the numbers tell what is missing.
        let room = HITS_CAPACITY.saturating_sub(self.hits.len()).min(hits.len());
        let numbered = (self.sequence..).zip(&hits[..room]);
        self.hits.extend(numbered.map(|(sequence, &hit)| NumberedHit { epoch, sequence, hit }));
        self.sequence += hits.len() as u64;
        if room < hits.len() {
            self.handover.count_dropped((hits.len() - room) as u64);
        }
    }

    /// As many ticks as fit before `until` and up to `last_tick` or to one that a command waits for, at least one.
    fn make_ticks(&mut self, until: Instant, last_tick: u64) {
        while self.simulation.tick() < last_tick {
            self.tape.give_way();
            let began = Instant::now();
            self.tick();
            self.meter.record(began.elapsed());
            if Instant::now() >= until || self.inbox.next_wanted_tick() <= self.simulation.tick() {
                break;
            }
        }
    }

    fn make_steps(&mut self, until: Instant) {
        let Some(last_tick) = self.stepping.as_ref().map(|stepping| stepping.last_tick) else { return };
        self.make_ticks(until, last_tick);
        if self.simulation.tick() >= last_tick {
            self.end_stepping(Ok(()));
        }
        self.hand_over();
    }

    fn end_stepping(&mut self, done: Result<(), Refusal>) {
        if let Some(answer) = self.stepping.take().and_then(|stepping| stepping.answer) {
            let reply = self.reply(done);
            self.answers.push(Answered { answer, reply });
        }
    }

    fn interrupt_stepping(&mut self, by: &str) {
        self.end_stepping(Err(Refusal::new(code::INTERRUPTED, format!("{by} before the last step"))));
    }

    /// Applies what waits, at the present tick; true when there was something.
    fn apply_commands(&mut self) -> bool {
        let mut requests = std::mem::take(&mut self.requests);
        self.inbox.drain_into(&mut requests, self.now());
        let touched = !requests.is_empty();
        for request in requests.drain(..) {
            self.apply(request);
        }
        self.requests = requests;
        touched
    }

    fn apply(&mut self, Request { command, ready, answer }: Request) {
        let at = (self.simulation.epoch(), self.simulation.tick());
        let done = match &command {
            Command::Pause {} => self.set_state(RunState::Paused, ready),
            Command::Resume {} => self.set_state(RunState::Playing, ready),
            Command::SetState { state } => self.set_state(*state, ready),
            Command::Step { .. } | Command::RunUntil { .. } => match self.last_tick(&command) {
                Ok(last_tick) => {
                    self.inbox.count_accepted();
                    self.stepping = Some(Stepping { last_tick, answer });
                    self.tape.obeyed(at, command, &self.simulation);
                    return;
                }
                Err(refusal) => Err(refusal),
            },
            Command::SaveState { slot } => self.save(slot, ready),
            Command::Speed { factor } => {
                self.set_speed(*factor);
                Ok(())
            }
            command => self.act(command, ready),
        };
        if command.needs_preparing() {
            self.diary.used();
        }
        if done.is_ok() {
            self.inbox.count_accepted();
            self.diary.obeyed(at, &command, &self.simulation);
            self.tape.obeyed(at, command, &self.simulation);
        } else {
            self.inbox.count_refused();
        }
        if let Some(answer) = answer {
            let reply = self.reply(done);
            self.answers.push(Answered { answer, reply });
        }
    }

    fn set_state(&mut self, state: RunState, ready: Ready) -> Result<(), Refusal> {
        self.interrupt_stepping(match state {
            RunState::Stopped => "stopped",
            RunState::Playing => "resumed",
            RunState::Paused => "paused",
            RunState::Quitting => "told to quit",
        });
        self.paused = state != RunState::Playing;
        if state == RunState::Stopped {
            self.act(&Command::SetState { state }, ready)?;
        }
        self.enter(state);
        Ok(())
    }

    fn enter(&mut self, state: RunState) {
        self.state = state;
        self.handover.set_run_state(state);
    }

    /// Where steps that were asked for shall end.
    fn last_tick(&self, command: &Command) -> Result<u64, Refusal> {
        let refuse = |why: String| Err(Refusal::new(code::INCORRECT_STATE, why));
        if !self.paused {
            return refuse("the clock runs: pause before stepping".into());
        }
        if self.stepping.is_some() {
            return refuse("the last steps are still being made".into());
        }
        let tick = self.simulation.tick();
        let Command::RunUntil { time_s } = command else {
            return Ok(if let Command::Step { ticks } = command { tick + ticks } else { tick });
        };
        let last = self.simulation.tick_at(*time_s);
        if last < tick {
            return refuse(format!("{time_s} s is over: it is tick {tick}; reset first"));
        }
        if last - tick > MAX_RUN_TICKS {
            return refuse(format!("{} ticks are too many: at most {MAX_RUN_TICKS} at once", last - tick));
        }
        Ok(last)
    }

    /// What a command does to the world, and what follows when it is another one.
    fn act(&mut self, command: &Command, mut ready: Ready) -> Result<(), Refusal> {
        match command {
            Command::Reset { scope: Scope::All | Scope::Time, .. } => self.interrupt_stepping("reset"),
            Command::Rewind(_) => self.interrupt_stepping("gone back"),
            Command::LoadScene { .. } | Command::ReloadScene {} | Command::LoadState { .. } => {
                self.interrupt_stepping("another world came");
            }
            _ => {}
        }
        let (epoch, world) = (self.simulation.epoch(), self.simulation.world().clone());
        let done = ready.act(command, &mut self.simulation);
        if !matches!(ready, Ready::Nothing) {
            self.handover.forget(Box::new(ready));
        }
        if !Arc::ptr_eq(&world, self.simulation.world()) {
            self.handover.put_stage(self.simulation.stage());
            self.handover.forget(Box::new(world));
        }
        if self.simulation.epoch() != epoch {
            self.sequence = 0;
            // Its first state goes out before anything else of the epoch.
            self.hand_over();
        }
        done
    }

    fn save(&mut self, slot: &str, ready: Ready) -> Result<(), Refusal> {
        let Ready::Page(page) = ready else {
            return Err(Refusal::new(code::OPERATION_FAILED, "no page was made ready for this"));
        };
        self.diary.save(slot, page, &self.simulation);
        Ok(())
    }

    fn set_speed(&mut self, factor: SpeedFactor) {
        self.as_fast_as_possible = matches!(factor, SpeedFactor::Named(_));
        if let SpeedFactor::Times(factor) = factor {
            self.speed_factor = factor;
        }
        // A slow clock's next tick may have been far off.
        self.due = self.due.min(Instant::now() + self.period());
    }

    fn reply(&self, done: Result<(), Refusal>) -> Reply {
        Reply::of(done, self.simulation.tick(), self.simulation.epoch())
    }

    fn hand_over(&mut self) {
        let mut state = self.handover.buffer();
        self.simulation.write_snapshot_for(&mut self.observer, &mut state);
        state.paused = self.paused;
        let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        state.wall_ns = since_1970.as_nanos() as u64;
        self.handover.put(Some(state), &mut self.hits, &mut self.answers, None);
    }

    fn report_each_second(&mut self) {
        let Some(figures) = self.meter.each_second(!self.paused) else { return };
        let [commands_accepted, commands_refused] = self.inbox.counts();
        let mut stats = Stats {
            paused: self.paused,
            speed_factor: self.speed_factor,
            as_fast_as_possible: self.as_fast_as_possible,
            real_time_factor: figures.ticks_per_s / f64::from(self.simulation.tick_rate_hz()),
            overruns: figures.overruns,
            tick_micros: figures.tick_micros,
            commands_accepted,
            commands_refused,
            ..Stats::default()
        };
        self.simulation.write_stats(&mut stats);
        if let Some(shadows) = &mut self.shadows {
            shadows.give(&self.simulation);
            stats.error_estimate = shadows.latest();
        }
        self.handover.put(None, &mut self.hits, &mut self.answers, Some(stats));
    }
}

struct OnDrop<F: FnMut()>(F);

impl<F: FnMut()> Drop for OnDrop<F> {
    fn drop(&mut self) {
        (self.0)();
    }
}

#[cfg(test)]
mod tests;
