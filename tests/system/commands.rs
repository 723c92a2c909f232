//! Commands and their answers, from Rust, from the shell, from plain Zenoh and from Python.

use crate::states::{RESET, done};
use ballroom_client::Client;
use protocol::command::{Command, Direction, DirectionName, SpeedFactor, SteerMode};
use protocol::keys::Name;
use std::process::Command as Shell;
use tests::{PATIENCE, Process, Server, turn, until};
use zenoh::Wait;

/// Ticks in a fifth of a second.
const A_MOMENT: u64 = 12;

/// How fast the `plane`'s cue ball goes north; its clock stands, so only commands change it.
fn northward_m_per_s(client: &Client) -> f64 {
    let world = client.snapshot().unwrap();
    let cue = world.roster.names.iter().position(|name| name == "cue").unwrap();
    world.snapshot.velocity_m_per_s[cue][1]
}

#[test]
fn a_press_moves_the_players_ball() {
    let _turn = turn();
    let server = Server::start(&["plane", "--paused"]);
    let client = server.client();
    let before = client.snapshot().unwrap();
    let press = before.scene.steering.impulse_m_per_s;
    assert_eq!(northward_m_per_s(&client), 0.0);
    let reaches = |presses: f64| {
        until("the press to act", PATIENCE, || {
            ((northward_m_per_s(&client) - presses * press).abs() < 1e-12).then_some(())
        });
    };

    // A press of the client, as the demo sends it.
    let up = Direction::Named(DirectionName::Up);
    let steer = Command::Steer { ball: None, direction: up, mode: SteerMode::Impulse };
    client.press(&"tester".parse::<Name>().unwrap(), &steer).unwrap();
    reaches(1.0);

    // The shell.
    let output = server.tool(&["steer", "up"]);
    assert_eq!(output.code, Some(0), "{}", output.stderr);
    assert_eq!(output.stdout, format!("done at tick 0 of epoch {}\n", before.snapshot.epoch));
    reaches(2.0);

    // One line of JSON over plain Zenoh, without any of our code.
    let mut config = zenoh::Config::default();
    config.insert_json5("mode", "\"client\"").unwrap();
    config.insert_json5("scouting/multicast/enabled", "false").unwrap();
    config.insert_json5("connect/endpoints", &format!("[\"{}\"]", server.endpoint())).unwrap();
    let session = zenoh::open(config).wait().unwrap();
    session.put("ballroom/v1/main/cmd/shell", r#"{"key":"up"}"#).wait().unwrap();
    reaches(3.0);

    // And the ball goes where it was pushed, at last.
    done(&client, &Command::Step { ticks: A_MOMENT });
    let after = client.snapshot().unwrap();
    for (i, name) in before.roster.names.iter().enumerate() {
        let north = after.snapshot.center_m[i][1] - before.snapshot.center_m[i][1];
        let expected = if name == "cue" { 3.0 * press * 0.2 } else { 0.0 };
        assert!((north - expected).abs() < 1e-9, "{name} went {north} m north");
    }
    session.close().wait().unwrap();
}

#[test]
fn pause_step_resume_reset_speed_answer_with_the_tick() {
    let _turn = turn();
    let server = Server::start(&["bowl"]);
    let client = server.client();
    let paused = done(&client, &Command::Pause {});
    assert_eq!(client.snapshot().unwrap().snapshot.tick, paused.tick);
    let stepped = done(&client, &Command::Step { ticks: 5 });
    assert_eq!((stepped.tick, stepped.epoch), (paused.tick + 5, paused.epoch));
    let snapshot = client.snapshot().unwrap().snapshot;
    assert!(snapshot.paused && snapshot.tick == stepped.tick, "{snapshot:?}");

    assert_eq!(done(&client, &Command::Speed { factor: SpeedFactor::Times(0.5) }).tick, stepped.tick);
    assert_eq!(done(&client, &Command::Resume {}).tick, stepped.tick);
    until("the clock to run", PATIENCE, || {
        (client.snapshot().unwrap().snapshot.tick > stepped.tick).then_some(())
    });
    until("statistics at half speed", PATIENCE, || {
        let stats = client.stats().unwrap();
        (stats.speed_factor == 0.5 && !stats.paused).then_some(())
    });

    let reset = done(&client, &RESET);
    assert_eq!((reset.tick, reset.epoch), (0, paused.epoch + 1));
}

#[test]
fn what_is_refused_says_why_and_what_would_do() {
    let _turn = turn();
    let server = Server::start(&["original"]);
    let client = server.client();
    let step = client.command(&Command::Step { ticks: 1 }).unwrap();
    assert!(!step.ok && step.error.contains("pause before stepping"), "{step:?}");
    for (arguments, code, why) in [
        (&["step"][..], 4, "refused: the clock runs: pause before stepping"),
        (&["steer", "up", "--ball", "red"], 4, "refused: \"red\" is no player's ball"),
        (&["steer", "up", "--ball", "green"], 4, "players' balls are player"),
        (&["speed", "1000"], 2, "use 0.01 to 100"),
        (&["steer", "3,4"], 2, "vector of length at most 1"),
        (&["pause", "--arena", "other"], 3, "no server of arena other"),
    ] {
        let output = server.tool(arguments);
        assert_eq!(output.code, Some(code), "{arguments:?}: {}", output.stderr);
        assert!(output.stdout.is_empty() && output.stderr.contains(why), "{arguments:?}: {}", output.stderr);
    }
}

#[test]
fn every_subcommand_reaches_the_server() {
    let _turn = turn();
    let server = Server::start(&["bowl"]);
    let epoch = server.client().snapshot().unwrap().snapshot.epoch;
    for (arguments, epoch) in [
        (&["pause"][..], epoch),
        (&["step", "3"], epoch),
        (&["steer", "-0.6,0.8", "--force"], epoch),
        (&["speed", "2"], epoch),
        (&["reset"], epoch + 1),
        (&["resume"], epoch + 1),
    ] {
        let output = server.tool(arguments);
        assert_eq!(output.code, Some(0), "{arguments:?}: {}", output.stderr);
        assert!(
            output.stdout.starts_with("done at tick ")
                && output.stdout.ends_with(&format!(" of epoch {epoch}\n"))
        );
    }
    let watched = server.tool(&["watch", "--json", "--count", "5"]);
    assert_eq!(watched.code, Some(0), "{}", watched.stderr);
    let ticks: Vec<u64> =
        watched.stdout.lines().map(|line| serde_json::from_str::<tests::State>(line).unwrap().tick).collect();
    assert!(ticks.len() == 5 && ticks.is_sorted(), "{ticks:?}");
}

#[test]
fn python_reads_states_and_sends_keys() {
    let _turn = turn();
    let install = "pip install eclipse-zenoh==1.10.2 cbor2 numpy";
    let mut probe = Shell::new("python3");
    probe.args(["-c", "import zenoh, cbor2, numpy; zenoh.Config()"]);
    if !probe.output().is_ok_and(|output| output.status.success()) {
        assert!(std::env::var_os("BALLROOM_REQUIRE_PYTHON").is_none_or(|value| value != "1"), "{install}");
        println!("SKIPPED: {install}");
        return;
    }
    let server = Server::start(&["original"]);
    let client = server.client();
    let mut python = Shell::new("python3");
    python.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../protocol/client/python/ballroom_keys.py")).args([
        "-e",
        server.endpoint(),
        "up",
        "up",
        "left",
    ]);
    let output = Process::spawn("ballroom_keys.py".into(), python).end(PATIENCE);
    assert_eq!(output.code, Some(0), "{}{}", output.stdout, output.stderr);
    let lines: Vec<&str> = output.stdout.lines().collect();
    assert_eq!(lines[0], "3 balls in 'original', steering 'player'");
    let ticks: Vec<u64> = lines[1..4]
        .iter()
        .map(|line| {
            let (_, rest) = line.split_once(": tick ").unwrap_or_else(|| panic!("{line}"));
            assert!(rest.contains("player at (") && rest.contains("energy "), "{line}");
            rest.split_once(',').unwrap().0.parse().unwrap()
        })
        .collect();
    assert!(ticks[0] > 0 && ticks.is_sorted(), "{ticks:?}");
    assert!(lines[4].starts_with("stop: done at tick "), "{}", output.stdout);
    // Three presses and the question.
    until("the server to count four commands", PATIENCE, || {
        let stats = client.stats().unwrap();
        (stats.commands_accepted == 4 && stats.commands_refused == 0).then_some(())
    });
}
