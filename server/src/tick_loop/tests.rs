use super::*;
use crate::handover::Batch;
use crate::scene_file::SceneText;
use protocol::command::SpeedName;
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
        assert!(self.inbox.offer(Request { command, ready: Ready::Nothing, answer: Some(answer) }).is_ok());
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
    let long = long.recv_timeout(Duration::from_mins(1)).unwrap();
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
    let long = long.recv_timeout(Duration::from_mins(1)).unwrap();
    assert!(!long.ok && long.error.contains("resumed"), "{long:?}");
}

#[test]
fn speed_scales_the_ticks_a_second() {
    let running = Running::start(false, 100);
    assert!(running.ask(speed(4.0)).ok);
    // A loaded machine may lose ticks, for a while all of them; none makes more.
    let is_near = |_| {
        let from = running.ask(speed(4.0)).tick;
        let began = Instant::now();
        std::thread::sleep(Duration::from_millis(200));
        let ticks = (running.ask(speed(4.0)).tick - from) as f64;
        let wanted = 400.0 * began.elapsed().as_secs_f64();
        assert!(ticks <= wanted + 4.0, "{ticks} of {wanted}");
        ticks >= 0.5 * wanted
    };
    assert!((0..100).any(is_near));
}

#[test]
fn a_clock_made_faster_does_not_wait_for_the_slow_tick() {
    let running = Running::start(false, 1);
    let slow = running.ask(speed(0.01));
    std::thread::sleep(Duration::from_millis(1500));
    assert!(slow.ok && running.ask(speed(100.0)).ok);
    // At a hundredth of a tick a second these would take a quarter of an hour.
    while running.ask(speed(100.0)).tick < slow.tick + 10 {
        std::thread::sleep(Duration::from_millis(20));
    }
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
    assert!(late.offer(Request { command: Command::Pause {}, ready: Ready::Nothing, answer: None }).is_err());
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
