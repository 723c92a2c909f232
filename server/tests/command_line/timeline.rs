//! Back along what happened, and on from what was kept, over real sessions.

use super::serving::Serving;
use super::{Output, ballroom, said};
use ballroom_client::Client;
use protocol::command::{Command, Direction, Reply, Scope, SteerMode, code};
use protocol::snapshot::Snapshot;
use protocol::timeline::Rewind;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::BufRead;
use std::time::Duration;

/// The present state, without what a clock or an epoch makes of it.
fn published(client: &Client) -> Snapshot {
    Snapshot { epoch: 0, wall_ns: 0, ..client.snapshot().unwrap().snapshot }
}

fn done(client: &Client, command: &Command) -> Reply {
    let reply = client.command(command).unwrap();
    assert!(reply.ok, "{command:?}: {reply:?}");
    reply
}

fn force(x: f64, y: f64) -> Command {
    Command::Steer { ball: None, direction: Direction::Vector([x, y]), mode: SteerMode::Force }
}

#[test]
fn a_paused_arena_goes_back_to_what_was_published_and_on_from_there() {
    let server = Serving::start(&["original", "--paused"]);
    let client = server.client();
    let epoch = client.snapshot().unwrap().snapshot.epoch;
    let mut shown = BTreeMap::new();
    for part in 0..8 {
        done(&client, &force(0.6 - 0.15 * f64::from(part), 0.7));
        let tick = done(&client, &Command::Step { ticks: 47 }).tick;
        shown.insert(tick, published(&client));
    }
    let reply = server.json(0, &["rewind", "--tick", "141"]);
    assert_eq!(reply, serde_json::json!({"ok": true, "code": 1, "tick": 141, "epoch": epoch + 1}));
    assert_eq!(published(&client), shown[&141]);
    // The force that was held there still is.
    assert_eq!(done(&client, &Command::Step { ticks: 5 }).tick, 146);
    assert_eq!(server.json(0, &["rewind", "--seconds", "1.6666666667"])["tick"], 46);
    assert_eq!(server.json(0, &["step"])["tick"], 47);
    assert_eq!(published(&client), shown[&47]);

    let ahead = server.json(4, &["rewind", "--tick", "188"]);
    assert!(ahead["error"].as_str().unwrap().contains("lies ahead"), "{ahead}");
    let far = server.json(4, &["rewind", "--seconds", "100"]);
    assert_eq!(far["code"], code::OPERATION_FAILED);
    let told = server.json(0, &["slots"]);
    assert_eq!(
        (&told["history"]["oldest_tick"], &told["history"]["oldest_epoch"]),
        (&0.into(), &epoch.into())
    );
    assert!(told["history"]["bytes"].as_u64() <= told["history"]["max_bytes"].as_u64(), "{told}");
}

#[test]
fn a_running_arena_goes_on_from_where_it_went_back_to() {
    let server = Serving::start(&["bowl"]);
    let client = server.client();
    let tick = || client.snapshot().unwrap().snapshot.tick;
    while tick() < 30 {
        std::thread::sleep(Duration::from_millis(5));
    }
    let reply = client.rewind(Rewind::to_tick(10)).unwrap();
    assert_eq!((reply.ok, reply.tick), (true, 10), "{reply:?}");
    let state = client.snapshot().unwrap().snapshot;
    assert!(!state.paused && state.epoch == reply.epoch && state.tick >= 10, "{state:?}");
    while tick() < 40 {
        std::thread::sleep(Duration::from_millis(5));
    }
    // And it is the same run again.
    let paused = done(&client, &Command::Pause {});
    let again = published(&client).state_hash;
    done(&client, &Command::Reset { scope: Scope::All, seed: None });
    done(&client, &Command::Step { ticks: paused.tick });
    assert_eq!(published(&client).state_hash, again);
}

#[test]
fn a_server_without_a_history_refuses_to_go_back_and_keeps_slots() {
    let server = Serving::start(&["plane", "--paused", "--history", "0"]);
    let refused = server.json(4, &["rewind", "--seconds", "1"]);
    assert_eq!(refused["code"], code::FEATURE_UNSUPPORTED);
    assert_eq!(server.json(0, &["save", "here"])["code"], code::OK);
    assert_eq!(server.json(0, &["step", "9"])["tick"], 9);
    assert_eq!(server.json(0, &["load-state", "here"])["tick"], 0);
    assert_eq!(server.json(4, &["load-state", "there"])["code"], code::NOT_FOUND);
    assert_eq!(server.json(0, &["slots"])["slots"][0]["name"], "here");
}

#[test]
fn a_state_goes_from_a_server_to_a_file_and_on_in_a_run_without_one_and_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let server = Serving::start(&["original", "--paused"]);
    let client = server.client();
    done(&client, &force(0.6, -0.8));
    done(&client, &Command::Step { ticks: 20 });
    let kept = path("kept.json");
    let told = server.json(0, &["save", &kept]);
    assert_eq!((&told["tick"], &told["scene"]), (&20.into(), &"original".into()));
    let again = server.tool(&["save", &kept]);
    assert!(again.code == 1 && again.stderr.contains("is there already"), "{}", again.stderr);

    // The force ends at its tick wherever the run goes on.
    done(&client, &Command::Step { ticks: 100 });
    let here = published(&client);
    let simulated = said(&["simulate", "original", "--load", &kept, "--until", "2", "--json"]);
    let last: Value = serde_json::from_str(simulated.lines().last().unwrap()).unwrap();
    assert_eq!(
        (&last["tick"], &last["state_hash"]),
        (&120.into(), &format!("{:016x}", here.state_hash).into())
    );

    let later = path("later.json");
    said(&["simulate", "original", "--load", &kept, "--until", "1", "--save", &later]);
    assert_eq!(server.json(0, &["load-state", &later])["tick"], 60);
    done(&client, &Command::Step { ticks: 60 });
    assert_eq!(published(&client), here);
    done(&client, &Command::LoadScene { name: Some("bowl".into()), toml: None, balls: None });
    let refused = server.json(4, &["load-state", &later]);
    assert!(refused["error"].as_str().unwrap().contains("another scene"), "{refused}");

    // A server can begin there.
    let server = Serving::start(&["--resume", &later, "--paused"]);
    assert_eq!(published(&server.client()).tick, 60);
    done(&server.client(), &Command::Step { ticks: 60 });
    assert_eq!(published(&server.client()), here);
}

/// Commands of every kind that leads elsewhere, at places that no run repeats.
fn play(client: &Client, seed: u64) {
    let mut random = seed;
    let mut draw = |below: u64| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random >> 11) % below
    };
    let slot = "fork".parse().unwrap();
    assert!(client.save_state(&slot).unwrap().ok);
    for _ in 0..60 {
        let angle = draw(6283) as f64 * 1e-3;
        let command = match draw(12) {
            0 => Command::Reset { scope: Scope::All, seed: Some(draw(5)) },
            1 => Command::Reset {
                scope: [Scope::All, Scope::Time, Scope::State][draw(3) as usize],
                seed: None,
            },
            2 | 3 => Command::Rewind(Rewind::by_seconds(draw(300) as f64 * 1e-2)),
            4 => Command::SaveState { slot: "fork".into() },
            5 => Command::LoadState { slot: Some("fork".into()), state: None },
            6 => {
                let state = client.checkpoint(None).unwrap();
                done(client, &Command::Step { ticks: 1 + draw(50) });
                // Of the same scene, but a seed may have made other balls since.
                Command::LoadState { slot: None, state: Some(Box::new(state)) }
            }
            _ => force(0.9 * angle.cos(), 0.9 * angle.sin()),
        };
        let reply = client.command(&command).unwrap();
        // A rewind may ask for more than there is.
        assert!(reply.ok || matches!(command, Command::Rewind(_)), "{command:?}: {reply:?}");
        done(client, &Command::Step { ticks: 1 + draw(100) });
    }
}

fn replay(file: &str) -> Value {
    let Output { code, stdout, stderr } = ballroom(&["replay", file, "--json"]);
    let verdict: Value = serde_json::from_str(&stdout).unwrap_or_else(|e| panic!("{e}: {stdout}{stderr}"));
    // While it is still being written there may be nothing to compare yet, which is a failure of its own.
    let is_empty = verdict["hashes"] == 0 && verdict["states"] == 0 && verdict["ending"] != "complete";
    assert_eq!(code, i32::from(is_empty), "{stdout}{stderr}");
    verdict
}

#[test]
fn a_killed_server_that_went_back_and_forth_replays_equal_and_is_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (ride, more) = (path("ride.mcap"), path("more.mcap"));
    let server = Serving::start(&["gas", "--balls", "12", "--paused", "--record", &ride]);
    let client = server.client();
    for seed in [1, 2026] {
        eprintln!("seed {seed}");
        play(&client, seed);
    }
    // What is written in time is a matter of the file's own clock: until it holds all that was done.
    let (last, there) = (done(&client, &Command::Step { ticks: 1 }), published(&client));
    let verdict = loop {
        let verdict = replay(&ride);
        let place = [&verdict["last_epoch"], &verdict["last_tick"]].map(Value::as_u64);
        if place == [Some(last.epoch), Some(last.tick)] {
            break verdict;
        }
        std::thread::sleep(Duration::from_millis(100));
    };
    server.kill();
    assert!(verdict["difference"].is_null() && verdict["ending"] == "cut", "{verdict}");
    assert!(verdict["commands"].as_u64() > Some(200), "{verdict}");

    let server = Serving::start(&["--resume", &ride, "--record", &more, "--paused"]);
    let client = server.client();
    assert_eq!(published(&client), there);
    play(&client, 7);
    let last = done(&client, &Command::Pause {});
    loop {
        let verdict = replay(&more);
        if verdict["last_tick"] == last.tick && verdict["last_epoch"] == last.epoch {
            break;
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}

#[test]
fn a_recording_is_shown_and_its_clock_obeys_whoever_watches() {
    let folder = tempfile::tempdir().unwrap();
    let ride = folder.path().join("ride.mcap").to_str().unwrap().to_owned();
    let server = Serving::start(&["original", "--paused", "--record", &ride]);
    let client = server.client();
    let first = client.snapshot().unwrap();
    done(&client, &force(0.6, -0.8));
    done(&client, &Command::Step { ticks: 90 });
    let middle = published(&client);
    done(&client, &Command::Rewind(Rewind::to_tick(30)));
    let last = done(&client, &Command::Step { ticks: 30 });
    let end = published(&client);
    loop {
        let verdict = replay(&ride);
        if verdict["last_tick"] == last.tick && verdict["last_epoch"] == last.epoch {
            break;
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    server.kill();

    let (mut shown, stdout) = Serving::run(&["replay", &ride, "--serve", "--paused", "--json"]);
    let client = shown.client();
    let world = client.snapshot().unwrap();
    assert_eq!((world.snapshot.state_hash, world.snapshot.tick), (first.snapshot.state_hash, 0));
    assert_eq!(done(&client, &Command::Step { ticks: 90 }).tick, 90);
    assert_eq!(published(&client), middle);
    let refused = client.command(&force(1.0, 0.0)).unwrap();
    assert_eq!(refused.code, code::INCORRECT_STATE);
    assert!(shown.json(4, &["rewind", "--seconds", "0"])["error"].as_str().unwrap().contains("history"));
    // The epoch that began by going back.
    assert_eq!(done(&client, &Command::Step { ticks: 1 }).epoch, last.epoch);
    assert_eq!(done(&client, &Command::Step { ticks: 28 }).tick, 59);
    assert!(done(&client, &Command::Speed { factor: protocol::command::SpeedFactor::Times(4.0) }).ok);
    assert!(client.command(&Command::Resume {}).unwrap().ok);
    let said: Vec<String> = stdout.lines().map(Result::unwrap).collect();
    let verdict: Value = serde_json::from_str(said.last().unwrap()).unwrap();
    assert!(verdict["difference"].is_null() && verdict["last_tick"] == last.tick, "{verdict}");
    assert_eq!(shown.ended(), 0);
    assert_eq!(end.tick, last.tick);
}
