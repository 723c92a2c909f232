//! States and events: what flows, to whom, and through what.

use ballroom_client::{Client, Follower, Update};
use nix::sys::signal::Signal;
use protocol::codec::encode_json;
use protocol::command::{Command, Reply, Scope};
use protocol::event::{Event, Other};
use protocol::scene::Scene;
use protocol::snapshot::{Snapshot, World};
use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};
use tests::{PATIENCE, Process, Server, in_one_of_three_tries, turn, until};
use zenoh::Wait;

fn next_world(follower: &mut Follower, patience: Duration) -> World {
    until("a world", patience, || match follower.next_within(Duration::from_millis(20)).unwrap() {
        Some(Update::World(world)) => Some(*world),
        _ => None,
    })
}

fn next_state(follower: &mut Follower, patience: Duration) -> Snapshot {
    until("a state", patience, || match follower.next_within(Duration::from_millis(20)).unwrap() {
        Some(Update::State(state)) => Some(*state),
        _ => None,
    })
}

/// All states that come within a time.
fn states_for(follower: &mut Follower, duration: Duration) -> Vec<Snapshot> {
    let deadline = Instant::now() + duration;
    let mut states = Vec::new();
    while Instant::now() < deadline {
        if let Some(Update::State(state)) = follower.next_within(Duration::from_millis(20)).unwrap() {
            states.push(*state);
        }
    }
    states
}

/// Back to the start.
pub const RESET: Command = Command::Reset { scope: Scope::All, seed: None };

pub fn done(client: &Client, command: &Command) -> Reply {
    let reply = client.command(command).unwrap();
    assert!(reply.ok, "{command:?}: {}", reply.error);
    reply
}

#[test]
fn states_flow_at_the_tick_rate_and_a_late_joiner_gets_the_world() {
    let _turn = turn();
    let server = Server::start(&["original", "--rate", "60"]);
    let early = server.client();
    let mut follower = early.follow().unwrap();
    next_state(&mut follower, PATIENCE);
    let (follower, heard) = (RefCell::new(follower), RefCell::default());
    in_one_of_three_tries(|| {
        let states = states_for(&mut follower.borrow_mut(), Duration::from_secs(2));
        let [first, last] = [&states[0], &states[states.len() - 1]];
        let ticks = last.tick - first.tick;
        let rate_hz = ticks as f64 / ((last.wall_ns - first.wall_ns) as f64 * 1e-9);
        let count = states.len() as u64;
        heard.replace(states);
        // Never faster; slower only where the machine is busy with something else.
        assert!(rate_hz < 61.0, "{rate_hz} ticks a second");
        let flows = rate_hz >= 30.0 && count >= ticks / 2;
        flows.then_some(()).ok_or(format!("{count} states of {ticks} ticks, {rate_hz} a second"))
    });
    let states: Vec<Snapshot> = heard.into_inner();
    let last = &states[states.len() - 1];
    for pair in states.windows(2) {
        assert!(pair[1].tick > pair[0].tick && pair[1].epoch == pair[0].epoch);
        assert!((pair[1].time_s - pair[1].tick as f64 / 60.0).abs() < 1e-9);
    }

    let late = server.client();
    let mut follower = late.follow().unwrap();
    let world = next_world(&mut follower, PATIENCE);
    assert!(world.snapshot.tick >= last.tick && world.snapshot.epoch == last.epoch);
    assert_eq!(world.scene, late.scene().unwrap());
    assert_eq!((world.scene.name.as_str(), world.tick_rate_hz), ("original", 60));
    assert_eq!(world.roster.names, ["blue", "player", "red"]);
    assert_eq!(world.roster.player, [false, true, false]);
    assert_eq!(world.snapshot.orientation_xyzw.len(), 3);
    let next = next_state(&mut follower, PATIENCE);
    assert!(next.tick > world.snapshot.tick && next.epoch == world.snapshot.epoch);
}

#[test]
fn a_late_joiner_to_a_paused_arena_gets_the_world_too() {
    let _turn = turn();
    let server = Server::start(&["cradle", "--paused"]);
    let client = server.client();
    let world = next_world(&mut client.follow().unwrap(), PATIENCE);
    assert!(world.snapshot.paused && world.snapshot.tick == 0);
    assert_eq!(world.roster.names.len(), 6);
}

#[test]
fn the_world_in_json_is_the_world_in_binary() {
    let _turn = turn();
    let server = Server::start(&["thousand", "--paused"]);
    let client = server.client();
    let question = client.session().get(format!("{}?format=json", client.keys().srv_snapshot()));
    let reply = question.wait().unwrap().recv_timeout(PATIENCE).unwrap().expect("an answer");
    let json = reply.into_result().unwrap().payload().to_bytes().into_owned();
    // As text: not every reader of JSON gives back the last bit, but the writer must.
    let binary = encode_json(&client.snapshot().unwrap());
    assert!(
        json == binary,
        "{}\nis not\n{}",
        String::from_utf8_lossy(&json),
        String::from_utf8_lossy(&binary)
    );
}

#[test]
fn a_reset_begins_a_new_epoch_for_whoever_follows() {
    let _turn = turn();
    let server = Server::start(&["bowl"]);
    let client = server.client();
    let scenes = client.session().declare_subscriber(client.keys().meta_scene()).wait().unwrap();
    let mut follower = client.follow().unwrap();
    let before = next_state(&mut follower, PATIENCE);
    assert_eq!(done(&client, &RESET).epoch, before.epoch + 1);
    let world = next_world(&mut follower, PATIENCE);
    assert_eq!(world.snapshot.epoch, before.epoch + 1);
    let scene = scenes.recv_timeout(PATIENCE).unwrap().expect("the scene again");
    let scene: Scene = serde_json::from_slice(&scene.payload().to_bytes()).unwrap();
    assert_eq!(scene, world.scene);
}

#[test]
fn a_stalled_subscriber_does_not_disturb_a_healthy_one() {
    let _turn = turn();
    // A thousand balls fill a stalled subscriber's buffers within a second.
    let server = Server::start(&["thousand"]);
    let client = server.client();
    let follower = RefCell::new(client.follow().unwrap());
    let watch = Process::start("ballroom", &["watch", "-e", server.endpoint()]);
    watch.said(PATIENCE, |line| line.starts_with("tick").then_some(()));
    next_state(&mut follower.borrow_mut(), PATIENCE);

    watch.signal(Signal::SIGSTOP);
    let newest = Cell::new(0);
    in_one_of_three_tries(|| {
        let states = states_for(&mut follower.borrow_mut(), Duration::from_secs(4));
        newest.set(states[states.len() - 1].tick);
        let ticks = newest.get() - states[0].tick;
        let gap_ns = states.windows(2).map(|pair| pair[1].wall_ns - pair[0].wall_ns).max().unwrap();
        let heard = states.len() as u64 >= ticks / 2 && gap_ns < 1_000_000_000;
        heard.then_some(()).ok_or(format!("{} of {ticks} states, none for {gap_ns} ns", states.len()))
    });
    let (lines_before, _) = watch.last_said();

    // The stalled one misses what it missed and goes on with what is new.
    watch.signal(Signal::SIGCONT);
    until("a new state at the stalled one", PATIENCE, || {
        let (lines, last) = watch.last_said();
        let tick: u64 = last.split_whitespace().nth(1)?.parse().ok()?;
        (lines > lines_before && tick > newest.get()).then_some(())
    });
}

#[test]
fn after_kill_and_restart_states_flow_again_within_two_seconds() {
    let _turn = turn();
    in_one_of_three_tries(|| {
        let server = Server::start(&["original"]);
        let client = server.client();
        let mut follower = client.follow().unwrap();
        let before = next_world(&mut follower, PATIENCE).snapshot;
        next_state(&mut follower, PATIENCE);
        let endpoint = server.kill();
        until("the news that the server is gone", PATIENCE, || {
            matches!(follower.next_within(Duration::from_millis(20)).unwrap(), Some(Update::Gone))
                .then_some(())
        });

        let server = Server::start_at(&endpoint, &["original"]);
        let after = next_world(&mut follower, PATIENCE).snapshot;
        let state = next_state(&mut follower, PATIENCE);
        let taken = server.age();
        assert!(after.epoch > before.epoch && state.epoch == after.epoch && state.tick > after.tick);
        // The same session also asks and is answered again.
        done(&client, &Command::Pause {});
        (taken < Duration::from_secs(2)).then_some(()).ok_or(format!("{taken:?} after the restart"))
    });
}

#[test]
fn events_carry_time_place_and_impulse() {
    let _turn = turn();
    let server = Server::start(&["galperin", "--paused"]);
    let client = server.client();
    let mut feed = client.subscribe_events().unwrap();
    let start = client.snapshot().unwrap();
    let ticks = 900;
    assert_eq!(done(&client, &Command::Step { ticks }).tick, ticks);
    let world = client.snapshot().unwrap();
    let counts = world.snapshot.collisions;
    // Galperin: a mass ratio of 100^2 gives the first digits of pi.
    assert_eq!(counts.ball_ball + counts.ball_wall, 314);

    let mut events: Vec<Event> = Vec::new();
    until("all events", PATIENCE, || {
        if let Some(batch) = feed.recv_timeout(Duration::from_millis(20)).unwrap() {
            assert_eq!(batch.dropped, 0);
            events.extend(batch.events);
        }
        (events.len() >= 314).then_some(())
    });
    assert!(events.iter().map(|event| event.sequence).eq(0..314), "numbered without a gap");
    let between = events.iter().filter(|event| matches!(event.other, Other::Ball(_))).count();
    assert_eq!(between as u64, counts.ball_ball);
    for pair in events.windows(2) {
        assert!(pair[0].time_s <= pair[1].time_s);
    }
    let mut momentum_n_s = 0.0;
    for event in &events {
        assert_eq!(event.epoch, start.snapshot.epoch);
        assert!(event.time_s > 0.0 && event.time_s <= world.snapshot.time_s);
        assert!(event.impulse_n_s > 0.0);
        let [x, y, _] = event.point_m;
        assert!(y.abs() < 1e-9, "{event:?}");
        match &event.other {
            // The west wall stands at x = 0.
            Other::Wall(_) => {
                assert!(event.ball == "light" && x.abs() < 1e-9, "{event:?}");
                momentum_n_s += event.impulse_n_s;
            }
            Other::Ball(_) => assert!(x > 0.5 && x < 4.0, "{event:?}"),
        }
    }
    // What the wall gave is the momentum that the balls have gained.
    let momentum = |world: &World| -> f64 {
        let speeds = world.snapshot.velocity_m_per_s.iter();
        speeds.zip(&world.roster.mass_kg).map(|(v, m)| m * v[0]).sum()
    };
    let gained = momentum(&world) - momentum(&start);
    assert!((gained - momentum_n_s).abs() < 1e-6 * gained, "{gained} is not {momentum_n_s}");
}
