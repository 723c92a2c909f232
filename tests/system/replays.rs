//! Recordings of real servers, run again.

use crate::states::done;
use ballroom_client::Client;
use nix::sys::signal::Signal;
use protocol::command::{Command, Direction, DirectionName, Scope, SpeedFactor, SteerMode};
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use tests::{Output, Server, run, turn};

/// Commands at moments of the wall clock, which no run repeats: presses, held forces, and the clock in all its ways.
fn play(client: &Client, commands: u32) {
    // The seed is no part of the claim, and is said when it fails.
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    let mut random = now.as_nanos() as u64 | 1;
    eprintln!("seed {random}");
    let mut draw = |below: u64| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        (random >> 11) % below
    };
    for _ in 0..commands {
        let angle = draw(6283) as f64 * 1e-3;
        let direction = Direction::Vector([0.9 * angle.cos(), 0.9 * angle.sin()]);
        let mode = [SteerMode::Impulse, SteerMode::Force][draw(2) as usize];
        let command = match draw(12) {
            0 => Command::Speed { factor: SpeedFactor::Times(0.5 + draw(8) as f64) },
            1 => Command::Reset { scope: Scope::All, seed: None },
            2 => {
                done(client, &Command::Pause {});
                done(client, &Command::Step { ticks: 1 + draw(100) });
                Command::Resume {}
            }
            3 => Command::Steer {
                ball: Some("player".into()),
                direction: Direction::Named(DirectionName::Stop),
                mode,
            },
            _ => Command::Steer { ball: None, direction, mode },
        };
        done(client, &command);
        std::thread::sleep(Duration::from_millis(draw(60)));
    }
}

fn replay(file: &Path) -> Output {
    run("ballroom", &["replay", file.to_str().unwrap(), "--json"])
}

fn number(verdict: &serde_json::Value, field: &str) -> u64 {
    verdict[field].as_u64().unwrap_or_else(|| panic!("{field} of {verdict}"))
}

#[test]
fn a_session_with_a_real_client_replays_equal() {
    let _turn = turn();
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("ride.mcap");
    let server = Server::start(&["original", "--record", file.to_str().unwrap()]);
    let client = server.client();
    play(&client, 80);
    drop(client);
    let ended = server.end(Signal::SIGTERM);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);

    let output = replay(&file);
    assert_eq!(output.code, Some(0), "{}{}", output.stdout, output.stderr);
    let verdict: serde_json::Value = serde_json::from_str(&output.stdout).unwrap();
    assert!(verdict["ending"] == "complete" && verdict["difference"].is_null(), "{verdict}");
    assert!(number(&verdict, "commands") >= 80, "{verdict}");
    assert!(
        number(&verdict, "hashes") > number(&verdict, "ticks"),
        "every tick, and each first state: {verdict}"
    );

    // The same file with one command turned round, and its checksum as it was.
    let mut bytes = std::fs::read(&file).unwrap();
    let field = br#""cmd":"steer""#;
    let at = bytes.windows(field.len()).position(|window| window == field).unwrap();
    bytes[at + field.len() - 2] = b'x';
    std::fs::write(&file, bytes).unwrap();
    let output = replay(&file);
    assert!(output.code == Some(1) && output.stderr.contains("is damaged"), "{}", output.stderr);
}

#[test]
fn a_killed_server_leaves_all_but_its_last_second() {
    let _turn = turn();
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("ride.mcap");
    let server = Server::start(&["original", "--record", file.to_str().unwrap()]);
    let client = server.client();
    play(&client, 40);
    done(&client, &Command::Reset { scope: Scope::All, seed: None });
    done(&client, &Command::Speed { factor: SpeedFactor::Times(1.0) });
    std::thread::sleep(Duration::from_millis(2500));
    let last = done(&client, &Command::Pause {});
    server.kill();

    let output = replay(&file);
    assert_eq!(output.code, Some(0), "{}{}", output.stdout, output.stderr);
    assert!(output.stderr.contains("cut short"), "{}", output.stderr);
    let verdict: serde_json::Value = serde_json::from_str(&output.stdout).unwrap();
    assert!(verdict["ending"] == "cut" && verdict["difference"].is_null(), "{verdict}");
    let recorded_tick = number(&verdict, "last_tick");
    assert_eq!(number(&verdict, "last_epoch"), last.epoch, "{verdict}");
    assert!(
        recorded_tick <= last.tick && recorded_tick + 60 >= last.tick,
        "{recorded_tick} of {}",
        last.tick
    );
}
