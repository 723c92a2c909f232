//! Several arenas in one process, and what their clocks do.

use super::serving::Serving;
use super::{PATIENCE, ballroom};
use ballroom_client::{Client, Presence};
use protocol::arenas::{ArenaCommand, COMMAND_KEY, MAX_ARENAS};
use protocol::command::{Command, Reply, code};
use protocol::keys::Role;
use serde_json::Value;
use std::time::{Duration, Instant};
use zenoh::Wait;

/// The hash of an undisturbed run at a tick.
fn simulated(scene: &str, ticks: u32) -> String {
    let until = (f64::from(ticks) / 60.0).to_string();
    let run = ballroom(&["simulate", scene, "--until", &until, "--every", &until, "--json"]);
    let last: Value = serde_json::from_str(run.stdout.lines().last().unwrap()).unwrap();
    assert_eq!(last["tick"], ticks);
    last["state_hash"].as_str().unwrap().to_owned()
}

fn stepped(client: &Client, ticks: u64) -> String {
    let reply = client.command(&Command::Step { ticks }).unwrap();
    assert!(reply.ok, "{}", reply.error);
    format!("{:016x}", client.snapshot().unwrap().snapshot.state_hash)
}

fn start(arena: &str, scene: &str) -> ArenaCommand {
    ArenaCommand::Start {
        arena: arena.parse().unwrap(),
        scene: Some(scene.into()),
        toml: None,
        balls: None,
        tick_rate_hz: 60,
        paused: true,
        record: false,
    }
}

fn stop(arena: &str) -> ArenaCommand {
    ArenaCommand::Stop { arena: arena.parse().unwrap() }
}

fn refused(reply: &Reply, code: u16, why: &str) {
    assert!(!reply.ok && reply.code == code && reply.error.contains(why), "{reply:?}");
}

fn names(server: &Serving) -> Vec<String> {
    let list = server.json(0, &["arenas"]);
    let rows = list["arenas"].as_array().unwrap();
    rows.iter().map(|row| row["arena"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn arenas_of_one_process_run_their_own_scenes_and_end_one_by_one() {
    let mut server = Serving::start(&["plane", "left=bowl", "right=original", "--paused"]);
    assert_eq!(names(&server), ["left", "main", "right"]);
    for (arena, scene) in [("main", "plane"), ("left", "bowl"), ("right", "original")] {
        assert_eq!(stepped(&server.client_of(arena), 90), simulated(scene, 90), "{arena}");
    }
    let list = server.json(0, &["arenas"]);
    assert_eq!((&list["arenas"][0]["scene"], &list["arenas"][0]["tick"]), (&"bowl".into(), &90.into()));
    assert_eq!(list["max_arenas"], MAX_ARENAS);

    assert_eq!(server.json(0, &["arenas", "stop", "left"])["tick"], 90);
    assert_eq!(names(&server), ["main", "right"]);
    assert_eq!(server.json(4, &["arenas", "stop", "left"])["code"], code::NOT_FOUND);
    let started =
        server.json(0, &["arenas", "start", "third", "gas", "--balls", "50", "--rate", "240", "--paused"]);
    assert_eq!((&started["ok"], &started["tick"]), (&true.into(), &0.into()));
    let world = server.client_of("third").snapshot().unwrap();
    assert_eq!((world.tick_rate_hz, world.roster.names.len()), (240, 50));

    // The process ends with its last arena, and in order.
    for arena in ["main", "right", "third"] {
        server.json(0, &["arenas", "stop", arena]);
    }
    assert_eq!(server.ended(), 0);
}

#[test]
fn an_arena_that_cannot_be_started_is_refused_and_leaves_no_trace() {
    let server = Serving::start(&["plane", "--paused"]);
    let client = server.client();
    let bad = |toml: &str| ArenaCommand::Start {
        arena: "new".parse().unwrap(),
        scene: None,
        toml: Some(toml.into()),
        balls: None,
        tick_rate_hz: 60,
        paused: false,
        record: false,
    };
    refused(&client.arena_command(&start("main", "bowl")).unwrap(), code::OPERATION_FAILED, "runs already");
    refused(&client.arena_command(&start("new", "nowhere")).unwrap(), code::NOT_FOUND, "use one of original");
    refused(&client.arena_command(&bad("version = 1")).unwrap(), code::BAD_SCENE, "toml:1:1");
    let recorded = server.json(4, &["arenas", "start", "new", "bowl", "--record"]);
    assert_eq!(recorded["code"], code::FEATURE_UNSUPPORTED);
    assert_eq!(names(&server), ["main"]);
    assert!(client.arena_command(&start("new", "bowl")).unwrap().ok);
}

#[test]
fn what_is_no_command_to_the_process_is_refused_by_its_number() {
    let server = Serving::start(&["plane", "--paused"]);
    let client = server.client();
    let ask = |payload: Vec<u8>| {
        let replies = client.session().get(COMMAND_KEY).payload(payload).timeout(PATIENCE).wait().unwrap();
        let reply = replies.recv().unwrap().into_result().unwrap();
        serde_json::from_slice::<Reply>(&reply.payload().to_bytes()).unwrap()
    };
    for (payload, code) in [
        (Vec::new(), code::MALFORMED),
        (vec![0xff; 100], code::MALFORMED),
        (b"[".repeat(100_000), code::MALFORMED),
        (br#"{"cmd":"stop","arena":"../main"}"#.to_vec(), code::MALFORMED),
        (br#"{"cmd":"pause"}"#.to_vec(), code::MALFORMED),
        (vec![b' '; (512 << 10) + 1], code::TOO_LONG),
    ] {
        refused(&ask(payload), code, "");
    }
    // Nor is what is no report believed.
    for key in ["report/viewer/v1", "report/server/v1", "report/viewer/NOBODY"] {
        client.session().put(format!("ballroom/v1/main/{key}"), vec![0xff; 600]).wait().unwrap();
    }
    assert!(client.clients().unwrap().clients.is_empty());
    assert_eq!(names(&server), ["main"]);
}

#[test]
fn more_arenas_than_there_may_be_are_refused_until_one_ends() {
    let server = Serving::start(&["plane", "--paused"]);
    let client = server.client();
    for i in 1..MAX_ARENAS {
        assert!(client.arena_command(&start(&format!("a{i}"), "plane")).unwrap().ok);
    }
    refused(&client.arena_command(&start("more", "plane")).unwrap(), code::OPERATION_FAILED, "stop one");
    assert!(client.arena_command(&stop("a1")).unwrap().ok);
    assert!(client.arena_command(&start("more", "plane")).unwrap().ok);
}

#[test]
fn an_arena_that_stalls_changes_no_bit_of_another_and_keeps_nobody_waiting() {
    let server = Serving::start(&["plane", "--paused"]);
    let client = server.client();
    // A tick of it is a simulated second of 20 000 balls: it is late before it has begun.
    let heavy = ArenaCommand::Start {
        arena: "heavy".parse().unwrap(),
        scene: Some("gas".into()),
        toml: None,
        balls: Some(20_000),
        tick_rate_hz: 1,
        paused: false,
        record: false,
    };
    assert!(client.arena_command(&heavy).unwrap().ok);
    let stalled = server.client_of("heavy");
    let here = client.watch(Role::Server).unwrap();
    for ticks in [60_u32, 120, 180] {
        assert_eq!(stepped(&client, 60), simulated("plane", ticks));
        assert!(stalled.stats().is_ok(), "what it published last is still told");
    }
    let alive = here.recv_timeout(PATIENCE).unwrap();
    assert!(matches!(alive, Some(Presence::Here(_))), "{alive:?}");
    assert!(here.recv_timeout(Duration::ZERO).unwrap().is_none(), "nobody left");
    assert_eq!(names(&server), ["heavy", "main"]);
}

#[test]
fn the_states_are_those_of_ros_and_stopping_resets() {
    let mut server = Serving::start(&["original", "other=plane", "--paused"]);
    let client = server.client();
    let is = |state: &str, number: u8| {
        let told = server.json(0, &["state"]);
        assert_eq!((&told["state"], &told["number"]), (&state.into(), &number.into()), "{told}");
        told
    };
    let first = client.snapshot().unwrap().snapshot;
    is("paused", 2);
    assert_eq!(server.json(0, &["state", "playing"])["code"], code::OK);
    is("playing", 1);
    let running = Instant::now();
    while client.snapshot().unwrap().snapshot.tick < 10 {
        assert!(running.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(server.json(0, &["state", "stopped"])["tick"], 0);
    let stopped = is("stopped", 0);
    assert_eq!((&stopped["tick"], &stopped["epoch"]), (&0.into(), &(first.epoch + 1).into()));
    let again = client.snapshot().unwrap().snapshot;
    assert!(again.paused && again.state_hash == first.state_hash);
    // What has been stepped stands no longer where it was stopped.
    server.json(0, &["step", "3"]);
    is("paused", 2);
    server.json(0, &["state", "stopped"]);
    server.json(0, &["pause"]);
    is("paused", 2);
    // This arena ends, the other goes on; with the last the process ends.
    assert_eq!(server.json(0, &["state", "quitting"])["code"], code::OK);
    let gone = Instant::now();
    while names(&server) != ["other"] {
        assert!(gone.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(server.json(0, &["state", "quitting", "--arena", "other"])["code"], code::OK);
    assert_eq!(server.ended(), 0);
}

#[test]
fn each_arena_is_recorded_in_a_file_of_its_own_and_states_are_replayed() {
    let directory = tempfile::tempdir().unwrap();
    let file = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let ride = file("ride.mcap");
    let mut server = Serving::start(&["left=bowl", "right=original", "--paused", "--record", &ride]);
    for arena in ["left", "right"] {
        for words in [&["step", "30"] as &[&str], &["state", "stopped"], &["step", "20"]] {
            server.json(0, &[words, &["--arena", arena]].concat());
        }
    }
    server.json(0, &["arenas", "start", "third", "plane", "--paused", "--record"]);
    let list = server.json(0, &["arenas"]);
    assert!(list["arenas"].as_array().unwrap().iter().all(|row| row["recorded"] == true), "{list}");
    server.json(0, &["step", "10", "--arena", "third"]);
    for arena in ["left", "right", "third"] {
        server.json(0, &["state", "quitting", "--arena", arena]);
    }
    assert_eq!(server.ended(), 0);
    for (name, ticks) in [("ride-left.mcap", 50), ("ride-right.mcap", 50), ("ride-third.mcap", 10)] {
        let verdict = ballroom(&["replay", &file(name), "--json"]);
        assert_eq!(verdict.code, 0, "{name}: {}{}", verdict.stdout, verdict.stderr);
        let verdict: Value = serde_json::from_str(&verdict.stdout).unwrap();
        assert_eq!((&verdict["ticks"], &verdict["ending"]), (&ticks.into(), &"complete".into()), "{verdict}");
    }
}
