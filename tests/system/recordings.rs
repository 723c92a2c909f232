//! The main job, headless: what the recordings hold in the end.

use crate::processes::endpoint_of_demo;
use nix::sys::signal::Signal;
use protocol::command::{Command, Direction, DirectionName, SteerMode};
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};
use tests::{PATIENCE, Process, Ride, Row, Server, connect, in_one_of_three_tries, simulate, turn, until};

/// Parent of all balls.
const BALLS: &str = "/world/balls/";
/// The name over the player's ball, which shares its x and y.
const PLAYER: &str = "/world/players/name";

/// The original's walls stand at 10 m and its balls have a radius of 1 m.
const WALL_M: f32 = 9.0;
/// Positions in a recording are f32, good to a micrometre there.
const F32_M: f32 = 1e-5;

fn assert_balls_rolled_inside_the_box(ride: &Ride) {
    let balls: Vec<&Row> = ride.rows_below(BALLS).collect();
    for [x, y, z] in balls.iter().flat_map(|row| &row.positions_m) {
        assert!(x.abs() <= WALL_M + F32_M && y.abs() <= WALL_M + F32_M, "({x}, {y}, {z}) is in a wall");
        // The pit is 4.5 m deep, the hill 2.5 m high.
        assert!((-4.0..4.0).contains(z), "({x}, {y}, {z}) is not on the floor");
    }
    for entity in 0..3 {
        let rows = ride.rows(&format!("{BALLS}{entity}"));
        let [first, last] = [&rows[0].positions_m[0], &rows[rows.len() - 1].positions_m[0]];
        assert!(distance(first, last) > 0.5, "ball {entity} went from {first:?} to {last:?}");
    }
}

fn distance(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
}

fn end_cleanly(process: Process) {
    process.signal(Signal::SIGTERM);
    let output = process.end(PATIENCE);
    assert_eq!(output.code, Some(0), "{}", output.stderr);
}

fn save_into(file: &Path) -> [&str; 3] {
    ["--no-viewer", "--save", file.to_str().unwrap()]
}

#[test]
fn the_demo_records_balls_that_roll_and_answer_a_key() {
    let _turn = turn();
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("ride.rrd");
    let demo = Process::start("ballroom-demo", &save_into(&file));
    let client = connect(&endpoint_of_demo(&demo));
    let tick = || client.snapshot().unwrap().snapshot.tick;
    let passes = |target: u64| until("ticks to pass", PATIENCE, || (tick() >= target).then(tick));

    // While the player's ball has nothing beside it.
    let before = passes(20);
    let right = Direction::Named(DirectionName::Right);
    let press = Command::Steer { ball: None, direction: right, mode: SteerMode::Impulse };
    client.press(&"tester".parse().unwrap(), &press).unwrap();
    let after = passes(before + 60);
    passes(after + 60);
    drop(client);
    end_cleanly(demo);

    let ride = Ride::read(&file);
    assert_balls_rolled_inside_the_box(&ride);
    let player = ride.rows(PLAYER);
    let [first, last] = [player[0].tick, player[player.len() - 1].tick];
    assert!(player.len() as u64 > (last - first) / 2, "{} rows of {} ticks", player.len(), last - first);
    assert!(first < before && last > after, "ticks {first} to {last}");

    // Against the run in which nobody pressed: the same up to the press, and to the right of it from then on.
    let twin = simulate("original", u32::try_from(last / 60 + 1).unwrap());
    let aside = |row: &Row| -> [f32; 2] {
        let undisturbed = twin[usize::try_from(row.tick).unwrap()].center_m("player");
        [0, 1].map(|i| row.positions_m[0][i] - undisturbed[i] as f32)
    };
    for row in player.iter().filter(|row| row.tick <= before) {
        assert!(distance(&aside(row), &[0.0; 2]) < F32_M, "tick {}: {:?}", row.tick, aside(row));
    }
    let answered = player.iter().find(|row| aside(row)[0].abs() > 0.005).expect("an answer to the key");
    assert!(answered.tick > before && answered.tick <= after, "answered at tick {}", answered.tick);
    assert!(aside(answered)[0] > 0.0, "to the right: {:?}", aside(answered));
    let far = player.iter().find(|row| row.tick >= after).unwrap();
    assert!(distance(&aside(far), &[0.0; 2]) > 0.1, "{:?}", aside(far));
}

#[test]
fn a_recording_goes_on_within_two_seconds_after_the_server_was_killed_and_restarted() {
    let _turn = turn();
    in_one_of_three_tries(|| {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("ride.rrd");
        let server = Server::start(&["original"]);
        let client = server.client();
        let viewer =
            Process::start("ballroom-viewer", &[&["-e", server.endpoint()][..], &save_into(&file)].concat());
        until("a recording with balls", PATIENCE, || {
            std::fs::metadata(&file).is_ok_and(|file| file.len() > 100_000).then_some(())
        });
        let tick = || client.snapshot().map(|world| world.snapshot.tick).unwrap_or_default();
        until("a second of it", PATIENCE, || (tick() > 60).then_some(()));
        let endpoint = server.kill();
        viewer.logged(PATIENCE, |line| line.contains("the server is gone").then_some(()));

        let server = Server::start_at(&endpoint, &["original"]);
        let restarted_ns = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as u64;
        viewer.logged(PATIENCE, |line| line.contains("the server is back").then_some(()));
        until("two more seconds of it", PATIENCE, || (tick() > 120).then_some(()));
        end_cleanly(viewer);
        drop(server);

        let ride = Ride::read(&file);
        assert_balls_rolled_inside_the_box(&ride);
        let rows = ride.rows(&format!("{BALLS}0"));
        let (before, after): (Vec<&Row>, Vec<&Row>) = rows.iter().partition(|row| row.wall_ns < restarted_ns);
        if before.len() <= 30 || after.len() <= 30 {
            return Err(format!("{} rows before, {} after", before.len(), after.len()));
        }
        let late_s = (after[0].wall_ns - restarted_ns) as f64 * 1e-9;
        assert!(after[0].tick < before[before.len() - 1].tick + 60, "a new epoch counts from its own start");
        (late_s < 2.0).then_some(()).ok_or(format!("the first row came {late_s} s after the restart"))
    });
}
