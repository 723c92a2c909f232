//! The tick loop: a fixed rate on a plain thread. It never awaits, never publishes, and never chases lost time.

use crate::handover::Handover;
use crate::inbox::{Answer, Answered, Inbox, Request};
use crate::meter::Meter;
use crate::simulation::{NumberedHit, Simulation};
use protocol::command::{Command, Reply};
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
    speed_factor: f64,
    stepping: Option<Stepping>,
    meter: Meter,
    /// Number of the epoch's next hit.
    sequence: u64,
    requests: Vec<Request>,
    answers: Vec<Answered>,
    hits: Vec<NumberedHit>,
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
        Self {
            simulation,
            inbox,
            handover,
            stop,
            paused,
            speed_factor: 1.0,
            stepping: None,
            meter: Meter::new(),
            sequence: 0,
            requests: Vec::with_capacity(crate::inbox::INBOX_CAPACITY),
            answers: Vec::with_capacity(crate::inbox::INBOX_CAPACITY),
            hits: Vec::new(),
        }
    }

    /// Runs until told to stop: drain, advance, hand over, sleep to the next deadline.
    pub fn run(mut self) {
        let handover = self.handover.clone();
        // Also when a tick panics: the publisher must not wait for ever.
        let _end = OnDrop(|| handover.end());
        self.hand_over();
        let mut due = Instant::now();
        while !self.stop.load(Ordering::Relaxed) {
            let touched = self.apply_commands();
            let now = Instant::now();
            if self.stepping.is_some() {
                self.make_steps(now + SLICE);
            } else if self.paused {
                if touched {
                    self.hand_over();
                }
                due = now;
                self.inbox.wait_until(now + SLICE);
            } else if now < due {
                std::thread::sleep((due - now).min(SLICE));
            } else {
                self.tick();
                self.hand_over();
                due = self.next_deadline(due, now);
            }
            self.report_each_second();
        }
    }

    fn next_deadline(&mut self, due: Instant, began: Instant) -> Instant {
        let period =
            Duration::from_secs_f64(1.0 / (f64::from(self.simulation.tick_rate_hz()) * self.speed_factor));
        let (due, now) = (due + period, Instant::now());
        self.meter.record(now - began);
        let behind = now.saturating_duration_since(due);
        if behind > Duration::ZERO {
            self.meter.count_overrun();
        }
        if behind > period * BACKLOG_PERIODS { now } else { due }
    }

    fn tick(&mut self) {
        self.simulation.advance();
        let epoch = self.simulation.epoch();
        for &hit in self.simulation.hits() {
            self.hits.push(NumberedHit { epoch, sequence: self.sequence, hit });
            self.sequence += 1;
        }
    }

    /// As many steps as fit before `until`, at least one.
    fn make_steps(&mut self, until: Instant) {
        let Some(last_tick) = self.stepping.as_ref().map(|stepping| stepping.last_tick) else { return };
        while self.simulation.tick() < last_tick {
            let began = Instant::now();
            self.tick();
            self.meter.record(began.elapsed());
            if Instant::now() >= until {
                break;
            }
        }
        if self.simulation.tick() >= last_tick {
            self.end_stepping("");
        }
        self.hand_over();
    }

    fn end_stepping(&mut self, error: &str) {
        if let Some(answer) = self.stepping.take().and_then(|stepping| stepping.answer) {
            let reply = self.reply(error.to_owned());
            self.answers.push(Answered { answer, reply });
        }
    }

    /// Applies what waits, at the present tick; true when there was something.
    fn apply_commands(&mut self) -> bool {
        let mut requests = std::mem::take(&mut self.requests);
        self.inbox.drain_into(&mut requests);
        let touched = !requests.is_empty();
        for request in requests.drain(..) {
            self.apply(request);
        }
        self.requests = requests;
        touched
    }

    fn apply(&mut self, Request { command, answer }: Request) {
        let done = match &command {
            Command::Steer { ball, direction, mode } => {
                self.simulation.steer(ball.as_deref(), *direction, *mode)
            }
            Command::Pause {} => {
                self.paused = true;
                Ok(())
            }
            Command::Resume {} => {
                self.end_stepping("resumed before the last step");
                self.paused = false;
                Ok(())
            }
            Command::Step { .. } if !self.paused => Err("the clock runs: pause before stepping".into()),
            Command::Step { .. } if self.stepping.is_some() => {
                Err("the last steps are still being made".into())
            }
            Command::Step { ticks } => {
                self.inbox.count_accepted();
                let last_tick = self.simulation.tick() + ticks;
                self.stepping = Some(Stepping { last_tick, answer });
                return;
            }
            Command::Reset {} => {
                self.end_stepping("reset before the last step");
                self.sequence = 0;
                self.simulation.reset().map_err(|e| e.to_string())
            }
            Command::Speed { factor } => {
                self.speed_factor = *factor;
                Ok(())
            }
        };
        if done.is_ok() {
            self.inbox.count_accepted();
        } else {
            self.inbox.count_refused();
        }
        if let Some(answer) = answer {
            let reply = self.reply(done.err().unwrap_or_default());
            self.answers.push(Answered { answer, reply });
        }
    }

    fn reply(&self, error: String) -> Reply {
        Reply { ok: error.is_empty(), tick: self.simulation.tick(), epoch: self.simulation.epoch(), error }
    }

    fn hand_over(&mut self) {
        let mut state = self.handover.buffer();
        self.simulation.write_snapshot(&mut state);
        state.paused = self.paused;
        let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        state.wall_ns = since_1970.as_nanos() as u64;
        self.handover.put(Some(state), &mut self.hits, &mut self.answers, None);
    }

    fn report_each_second(&mut self) {
        let Some(figures) = self.meter.each_second() else { return };
        let [commands_accepted, commands_refused] = self.inbox.counts();
        let mut stats = Stats {
            paused: self.paused,
            speed_factor: self.speed_factor,
            real_time_factor: figures.ticks_per_s / f64::from(self.simulation.tick_rate_hz()),
            overruns: figures.overruns,
            tick_micros: figures.tick_micros,
            commands_accepted,
            commands_refused,
            ..Stats::default()
        };
        self.simulation.write_stats(&mut stats);
        self.handover.put(None, &mut self.hits, &mut self.answers, Some(stats));
    }
}

struct OnDrop<F: FnMut()>(F);

impl<F: FnMut()> Drop for OnDrop<F> {
    fn drop(&mut self) {
        (self.0)();
    }
}
