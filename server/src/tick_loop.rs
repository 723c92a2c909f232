//! The tick loop: a fixed rate on a plain thread. It never awaits, never publishes, and never chases lost time.

use crate::handover::{HITS_CAPACITY, Handover};
use crate::inbox::{Answer, Answered, ENDING, Inbox, Request};
use crate::meter::Meter;
use crate::recording::Tape;
use crate::simulation::{NumberedHit, Simulation};
use crate::workshop::Ready;
use protocol::command::{Command, MAX_RUN_TICKS, Refusal, Reply, SpeedFactor, code};
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
            as_fast_as_possible: false,
            due: Instant::now(),
            stepping: None,
            meter: Meter::new(),
            sequence: 0,
            requests: Vec::with_capacity(crate::inbox::INBOX_CAPACITY),
            answers: Vec::with_capacity(crate::inbox::INBOX_CAPACITY),
            hits: Vec::with_capacity(HITS_CAPACITY),
            tape: Tape::default(),
        }
    }

    /// The same, with what is done written down.
    #[must_use]
    pub fn recorded_on(mut self, tape: Tape) -> Self {
        self.tape = tape;
        self
    }

    /// Runs until told to stop: drain, advance, hand over, sleep to the next deadline.
    pub fn run(mut self) {
        let handover = self.handover.clone();
        // Also when a tick panics: the publisher must not wait for ever.
        let _end = OnDrop(|| handover.end());
        self.hand_over();
        self.due = Instant::now();
        while !self.stop.load(Ordering::Relaxed) {
            let touched = self.apply_commands();
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
        self.inbox.drain_into(&mut requests);
        for answer in requests.drain(..).filter_map(|request| request.answer) {
            self.inbox.count_refused();
            let reply = self.reply(Err(Refusal::new(code::ENDING, ENDING)));
            self.answers.push(Answered { answer, reply });
        }
        self.handover.put(None, &mut self.hits, &mut self.answers, None);
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
        self.simulation.advance();
        self.tape.ticked(&self.simulation, self.paused);
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

    /// As many ticks as fit before `until` and up to `last_tick`, at least one.
    fn make_ticks(&mut self, until: Instant, last_tick: u64) {
        while self.simulation.tick() < last_tick {
            self.tape.give_way();
            let began = Instant::now();
            self.tick();
            self.meter.record(began.elapsed());
            if Instant::now() >= until {
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
        self.inbox.drain_into(&mut requests);
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
            Command::Steer { ball, direction, mode } => {
                let steered = self.simulation.steer(ball.as_deref(), *direction, *mode);
                steered.map_err(|why| Refusal::new(code::NOT_FOUND, why))
            }
            Command::Pause {} => {
                self.interrupt_stepping("paused");
                self.paused = true;
                Ok(())
            }
            Command::Resume {} => {
                self.interrupt_stepping("resumed");
                self.paused = false;
                Ok(())
            }
            Command::Step { .. } | Command::RunUntil { .. } => match self.last_tick(&command) {
                Ok(last_tick) => {
                    self.inbox.count_accepted();
                    self.stepping = Some(Stepping { last_tick, answer });
                    self.tape.obeyed(at, command, &self.simulation);
                    return;
                }
                Err(refusal) => Err(refusal),
            },
            Command::Reset { .. } | Command::LoadScene { .. } | Command::SetBalls { .. } => {
                self.change_world(&command, ready)
            }
            Command::Speed { factor } => {
                self.set_speed(*factor);
                Ok(())
            }
        };
        if done.is_ok() {
            self.inbox.count_accepted();
            self.tape.obeyed(at, command, &self.simulation);
        } else {
            self.inbox.count_refused();
        }
        if let Some(answer) = answer {
            let reply = self.reply(done);
            self.answers.push(Answered { answer, reply });
        }
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

    /// Puts what was made ready in its place.
    fn change_world(&mut self, command: &Command, ready: Ready) -> Result<(), Refusal> {
        if let Ready::Seats(seats) = ready {
            return self.simulation.set_balls(&seats);
        }
        self.interrupt_stepping("reset");
        let epoch = self.simulation.epoch();
        if let Ready::World(mut world) = ready {
            self.simulation.give_way_to(&mut world);
            self.handover.put_stage(self.simulation.stage(), world);
        } else if let Command::Reset { scope, .. } = command {
            self.simulation.reset(*scope);
        } else {
            return Err(Refusal::new(code::OPERATION_FAILED, "nothing was made ready for this"));
        }
        if self.simulation.epoch() != epoch {
            self.sequence = 0;
            // Its first state goes out before anything else of the epoch.
            self.hand_over();
        }
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
        self.simulation.write_snapshot(&mut state);
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
mod tests {
    use super::*;
    use crate::handover::Batch;
    use crate::scene_file::SceneText;
    use protocol::command::{Scope, SpeedName};
    use std::sync::mpsc::{Receiver, channel};

    const RESET: Command = Command::Reset { scope: Scope::All, seed: None };

    const fn speed(factor: f64) -> Command {
        Command::Speed { factor: SpeedFactor::Times(factor) }
    }

    /// A loop on its own thread, with everything around it but the network.
    struct Running {
        inbox: Arc<Inbox>,
        handover: Arc<Handover>,
        stop: Arc<AtomicBool>,
        thread: Option<std::thread::JoinHandle<()>>,
    }

    impl Running {
        fn start(paused: bool, tick_rate_hz: u32) -> Self {
            let loaded = Arc::new(SceneText::open("plane").unwrap().load().unwrap());
            let simulation = Simulation::new(loaded, tick_rate_hz, 1).unwrap();
            let (inbox, handover, stop) = (Arc::default(), Arc::new(Handover::new()), Arc::default());
            let ticks =
                TickLoop::new(simulation, Arc::clone(&inbox), handover.clone(), Arc::clone(&stop), paused);
            Self { inbox, handover, stop, thread: Some(std::thread::spawn(move || ticks.run())) }
        }

        fn send(&self, command: Command) -> Receiver<Reply> {
            let (sender, receiver) = channel();
            let answer: Answer = Box::new(move |reply: &Reply| sender.send(reply.clone()).unwrap());
            assert!(
                self.inbox.offer(Request { command, ready: Ready::Nothing, answer: Some(answer) }).is_ok()
            );
            receiver
        }

        /// What the publisher does, until the reply is there.
        fn ask(&self, command: Command) -> Reply {
            let reply = self.send(command);
            let mut batch = Batch::default();
            for _ in 0..1000 {
                self.handover.take(&mut batch, Duration::from_millis(10));
                batch.hits.clear();
                batch.answers.drain(..).for_each(|answered| (answered.answer)(&answered.reply));
                if let Ok(reply) = reply.try_recv() {
                    return reply;
                }
            }
            panic!("no reply in ten seconds");
        }
    }

    impl Drop for Running {
        fn drop(&mut self) {
            self.stop.store(true, Ordering::Relaxed);
            self.thread.take().into_iter().for_each(|thread| thread.join().unwrap());
        }
    }

    #[test]
    fn a_paused_loop_steps_exactly_and_says_when_it_is_done() {
        let running = Running::start(true, 60);
        assert_eq!(running.ask(Command::Step { ticks: 1 }).tick, 1);
        assert_eq!(running.ask(Command::Step { ticks: 2000 }).tick, 2001);
        let reset = running.ask(RESET);
        assert_eq!((reset.ok, reset.tick, reset.epoch), (true, 0, 2));
        assert_eq!(running.ask(Command::Step { ticks: 5 }).tick, 5);
        assert_eq!(running.inbox.counts(), [4, 0]);
    }

    #[test]
    fn a_run_ends_at_the_tick_of_its_time_and_stays_paused() {
        let running = Running::start(true, 60);
        for (time_s, tick) in [(0.0, 0), (2.5, 150), (2.5 + 1e-12, 150), (2.501, 151), (1000.0, 60_000)] {
            let reply = running.ask(Command::RunUntil { time_s });
            assert_eq!((reply.ok, reply.code, reply.tick), (true, code::OK, tick), "{time_s}: {reply:?}");
        }
        let past = running.ask(Command::RunUntil { time_s: 999.0 });
        assert!(past.code == code::INCORRECT_STATE && past.error.contains("is over"), "{past:?}");
        assert_eq!(running.ask(Command::RunUntil { time_s: 1e9 }).code, code::INCORRECT_STATE);
        assert_eq!(running.ask(Command::Step { ticks: 1 }).tick, 60_001);
    }

    #[test]
    fn a_pause_ends_a_run_and_whoever_asked_is_told() {
        let running = Running::start(true, 60);
        let long = running.send(Command::RunUntil { time_s: 1e6 });
        while running.inbox.counts() == [0, 0] {
            std::thread::yield_now();
        }
        let paused = running.ask(Command::Pause {});
        let long = long.recv_timeout(Duration::from_secs(10)).unwrap();
        assert_eq!((long.ok, long.code, long.tick), (false, code::INTERRUPTED, paused.tick));
        assert_eq!(running.ask(Command::Step { ticks: 1 }).tick, paused.tick + 1);
    }

    #[test]
    fn at_the_highest_speed_no_tick_waits_for_the_clock() {
        let running = Running::start(false, 1);
        assert!(running.ask(Command::Speed { factor: SpeedFactor::Named(SpeedName::Max) }).ok);
        // At one tick a second that would take a quarter of an hour.
        let mut tick = 0;
        while tick < 1000 {
            std::thread::sleep(Duration::from_millis(1));
            tick = running.ask(speed(1.0)).tick;
            assert!(running.ask(Command::Speed { factor: SpeedFactor::Named(SpeedName::Max) }).ok);
        }
    }

    #[test]
    fn commands_out_of_place_are_refused_with_a_reason() {
        let running = Running::start(false, 60);
        let step = running.ask(Command::Step { ticks: 1 });
        assert!(!step.ok && step.error.contains("pause"), "{step:?}");
        assert!(running.ask(Command::Pause {}).ok);
        let long = running.send(Command::Step { ticks: 1_000_000 });
        let more = running.ask(Command::Step { ticks: 1 });
        assert!(!more.ok && more.error.contains("still being made"), "{more:?}");
        assert!(running.ask(Command::Resume {}).ok);
        let long = long.recv_timeout(Duration::from_secs(10)).unwrap();
        assert!(!long.ok && long.error.contains("resumed"), "{long:?}");
    }

    #[test]
    fn speed_scales_the_ticks_a_second() {
        let running = Running::start(false, 100);
        assert!(running.ask(speed(4.0)).ok);
        let from = running.ask(speed(4.0)).tick;
        let began = Instant::now();
        std::thread::sleep(Duration::from_millis(500));
        let ticks = running.ask(Command::Pause {}).tick - from;
        let wanted = 400.0 * began.elapsed().as_secs_f64();
        // A loaded machine may lose ticks, none makes more.
        assert!(ticks as f64 <= wanted + 4.0 && ticks as f64 >= 0.5 * wanted, "{ticks} of {wanted}");
    }

    #[test]
    fn a_clock_made_faster_does_not_wait_for_the_slow_tick() {
        let running = Running::start(false, 1);
        let slow = running.ask(speed(0.01));
        std::thread::sleep(Duration::from_millis(1500));
        assert!(slow.ok && running.ask(speed(100.0)).ok);
        std::thread::sleep(Duration::from_millis(500));
        assert!(running.ask(Command::Pause {}).tick > slow.tick + 10);
    }

    #[test]
    fn whoever_still_waits_is_told_that_the_server_ends() {
        let mut running = Running::start(true, 60);
        let long = running.send(Command::Step { ticks: 1_000_000 });
        while running.inbox.counts() == [0, 0] {
            std::thread::yield_now();
        }
        running.stop.store(true, Ordering::Relaxed);
        let late = running.inbox.clone();
        running.thread.take().unwrap().join().unwrap();
        assert!(
            late.offer(Request { command: Command::Pause {}, ready: Ready::Nothing, answer: None }).is_err()
        );
        let mut batch = Batch::default();
        running.handover.take(&mut batch, Duration::ZERO);
        assert!(batch.ended);
        batch.answers.drain(..).for_each(|answered| (answered.answer)(&answered.reply));
        let long = long.try_recv().unwrap();
        assert!(!long.ok && long.error == ENDING && long.tick > 0, "{long:?}");
    }

    #[test]
    fn a_stall_costs_ticks_and_is_over_when_it_is_over() {
        let loaded = Arc::new(SceneText::open("plane").unwrap().load().unwrap());
        let simulation = Simulation::new(loaded, 1000, 1).unwrap();
        let handover = Arc::new(Handover::new());
        let mut ticks = TickLoop::new(simulation, Arc::default(), handover, Arc::default(), false);
        let began = Instant::now();
        std::thread::sleep(Duration::from_millis(50));
        let due = ticks.next_deadline(began, began);
        // Fifty periods late: the next tick is due now, not fifty of them.
        assert!(due >= began + Duration::from_millis(50));
        assert_eq!(ticks.next_deadline(due + Duration::from_secs(1), due), due + Duration::from_millis(1001));
    }

    #[test]
    fn a_tick_with_its_handover_allocates_nothing_after_the_first_second() {
        assert_eq!(allocations("original", 20), 0);
        assert_eq!(allocations("thousand", 2), 0);
    }

    fn allocations(scene: &str, seconds: u32) -> u64 {
        let loaded = Arc::new(SceneText::open(scene).unwrap().load().unwrap());
        let simulation = Simulation::new(loaded, 60, 1).unwrap();
        let handover = Arc::new(Handover::new());
        let mut ticks = TickLoop::new(simulation, Arc::default(), handover.clone(), Arc::default(), false);
        let mut batch = Batch::default();
        let mut second = || {
            for _ in 0..60 {
                ticks.apply_commands();
                ticks.tick();
                ticks.hand_over();
                handover.take(&mut batch, Duration::ZERO);
                batch.hits.clear();
                if let Some(state) = batch.state.take() {
                    handover.recycle(state);
                }
            }
        };
        second();
        allocation_counter::measure(|| (0..seconds).for_each(|_| second())).count_total
    }
}
