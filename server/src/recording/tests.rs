//! Recordings of runs driven by hand, read back whole, cut and damaged.

use super::replay::obey;
use super::*;
use crate::scene_file::SceneText;
use crate::simulation::Simulation;
use crate::workshop::Bench;
use protocol::command::{Command, Direction, DirectionName, SteerMode};
use std::io::Cursor;
use std::sync::Arc;
use tempfile::TempDir;

fn simulation(scene: &str) -> Simulation {
    let loaded = SceneText::open(scene).unwrap().with_balls((scene == "gas").then_some(40)).load().unwrap();
    Simulation::new(Arc::new(loaded), 60, 7).unwrap()
}

fn steer(direction: Direction, mode: SteerMode) -> Command {
    Command::Steer { ball: None, direction, mode }
}

fn up() -> Command {
    steer(Direction::Named(DirectionName::Up), SteerMode::Impulse)
}

fn json(text: &str) -> Command {
    Command::from_json(text).unwrap()
}

/// What is done after which tick: presses, a force that runs out, a reset amid it, and the clock.
fn script(tick: u64) -> Vec<Command> {
    match tick {
        0 | 40 => vec![up()],
        41 => vec![
            steer(Direction::Vector([0.6, -0.8]), SteerMode::Force),
            Command::Pause {},
            Command::Step { ticks: 3 },
            Command::Resume {},
        ],
        100 => vec![steer(Direction::Vector([-0.9, 0.1 / 3.0]), SteerMode::Force), up(), up()],
        110 => vec![json(r#"{"cmd":"reset"}"#), up(), json(r#"{"cmd":"speed","factor":2}"#)],
        120 => vec![json(r#"{"cmd":"set_balls","balls":[{"name":"player","velocity_m_per_s":[1,0,0]}]}"#)],
        130 => vec![json(r#"{"cmd":"reset","scope":"time"}"#), up()],
        140 => vec![json(r#"{"cmd":"reset","scope":"state"}"#)],
        150 => vec![json(r#"{"cmd":"load_scene","name":"bowl"}"#)],
        152 => vec![
            json(
                r#"{"cmd":"spawn","balls":[{"name":"guest","uv":[0.1,0.1],"radius_m":0.05,"mass_kg":1,"tags":["x"]}]}"#,
            ),
            json(r#"{"cmd":"set_parameters","values":{"restitution":0.9,"gravity_m_per_s2":[0,0,-5]}}"#),
        ],
        154 => {
            vec![json(r#"{"cmd":"move_control_points","points":[{"row":1,"column":1,"to_m":[0,0,-0.9]}]}"#)]
        }
        156 => vec![json(r#"{"cmd":"set_balls","select":{"tag":"x"},"velocity_m_per_s":[1,1,0]}"#)],
        157 => vec![json(r#"{"cmd":"delete","names":["hollow"]}"#)],
        158 => vec![json(r#"{"cmd":"delete","within_m":[-9,-9,9,9],"tag":"x"}"#)],
        160 => vec![json(r#"{"cmd":"reset","seed":9}"#)],
        170 => vec![json(r#"{"cmd":"reset"}"#)],
        _ => Vec::new(),
    }
}

/// The bytes of a recording of 200 ticks. `written` says what the file tells of a command.
fn record(scene: &str, options: &RecordOptions, written: impl Fn(Command) -> Command) -> Vec<u8> {
    let mut simulation = simulation(scene);
    let bench = Bench::new(&simulation);
    let (recorder, mut tape) = Recorder::create(options, &simulation).unwrap();
    let recorder = std::thread::spawn(move || recorder.run());
    for tick in 0..200 {
        for command in script(tick) {
            let at = (simulation.epoch(), simulation.tick());
            obey(&mut simulation, &bench, &command).unwrap();
            tape.obeyed(at, written(command), &simulation);
        }
        simulation.advance();
        tape.ticked(&simulation, false);
    }
    tape.end(&simulation);
    recorder.join().unwrap();
    std::fs::read(&options.file).unwrap()
}

fn options(directory: &TempDir) -> RecordOptions {
    RecordOptions::new(directory.path().join("ride.mcap"))
}

fn judge(bytes: &[u8]) -> Result<Verdict, ReplayError> {
    replay(&mut Reader::new(Cursor::new(bytes))?, || false)
}

#[test]
fn a_replay_equals_its_recording() {
    for (scene, states_hz, hash_every_ticks, hashes) in [("original", 10, 1, 211), ("original", 0, 7, 36)] {
        let directory = tempfile::tempdir().unwrap();
        let options = RecordOptions { hash_every_ticks, states_hz, ..options(&directory) };
        let verdict = judge(&record(scene, &options, |command| command)).unwrap();
        assert_eq!((verdict.ticks, verdict.commands), (200, 26));
        assert_eq!((verdict.difference, verdict.ending), (None, Some(Ending::Complete)));
        assert_eq!(verdict.hashes, hashes, "hashes every {hash_every_ticks} ticks");
        assert!(verdict.states <= 33 && (states_hz == 0) == (verdict.states == 0), "{}", verdict.states);
    }
}

#[test]
fn a_scene_with_another_number_of_balls_is_recorded_as_it_ran() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("gas.mcap");
    let mut simulation = simulation("gas");
    let (recorder, mut tape) = Recorder::create(&RecordOptions::new(file.clone()), &simulation).unwrap();
    let recorder = std::thread::spawn(move || recorder.run());
    for _ in 0..30 {
        simulation.advance();
        tape.ticked(&simulation, false);
    }
    tape.end(&simulation);
    recorder.join().unwrap();
    let verdict = judge(&std::fs::read(file).unwrap()).unwrap();
    assert_eq!((verdict.ticks, verdict.difference), (30, None));
    assert_eq!(simulation.roster().names.len(), 40);
}

#[test]
fn a_command_that_was_tampered_with_is_found_at_the_next_hash() {
    let directory = tempfile::tempdir().unwrap();
    let tampered = |command: Command| match command {
        Command::Steer { direction: Direction::Vector([x, y]), mode, .. } if x > 0.0 => {
            steer(Direction::Vector([x, y.next_up()]), mode)
        }
        other => other,
    };
    let bytes = record("original", &options(&directory), tampered);
    let first = judge(&bytes).unwrap().difference.unwrap();
    assert_eq!((first.epoch, first.tick, first.what), (7, 42, "hash"));
}

#[test]
fn a_file_cut_anywhere_is_read_as_far_as_it_goes() {
    let directory = tempfile::tempdir().unwrap();
    let bytes = record("original", &options(&directory), |command| command);
    let mut longest = 0;
    for length in (0..bytes.len()).step_by(97) {
        match judge(&bytes[..length]) {
            Ok(verdict) => {
                let end = verdict.ending.unwrap();
                assert!(verdict.difference.is_none() && end == Ending::Cut, "{length} bytes: {end:?}");
                assert!(verdict.ticks >= longest, "{length} bytes hold less than fewer did");
                longest = verdict.ticks;
            }
            Err(ReplayError::File(RecordingFault::Cut)) => assert_eq!(longest, 0, "{length} bytes"),
            Err(error) => panic!("{length} bytes: {error}"),
        }
    }
    assert_eq!(longest, 200, "everything was there before the index");
}

#[test]
fn a_bit_that_fell_over_anywhere_is_noticed() {
    let directory = tempfile::tempdir().unwrap();
    let mut bytes = record("original", &options(&directory), |command| command);
    for place in (0..bytes.len()).step_by(211) {
        let bit = 1 << (place % 8);
        bytes[place] ^= bit;
        let noticed = judge(&bytes)
            .map_or(true, |verdict| verdict.difference.is_some() || verdict.ending != Some(Ending::Complete));
        assert!(noticed, "byte {place} of {}", bytes.len());
        bytes[place] ^= bit;
    }
}

#[test]
fn another_version_and_another_file_are_named() {
    let directory = tempfile::tempdir().unwrap();
    let mut bytes = record("original", &options(&directory), |command| command);
    let field = b"version\x01\0\0\0";
    let at = bytes.windows(field.len()).position(|window| window == field).unwrap() + field.len();
    bytes[at] = b'9';
    let says = |bytes: &[u8]| judge(bytes).unwrap_err().to_string();
    assert!(says(&bytes).contains("format 9"), "{}", says(&bytes));
    assert!(says(b"tick,time_s\n0,0.0\n").contains("no MCAP file"));
    assert!(says(b"").contains("cut short"));
    let exists = Recorder::create(&options(&directory), &simulation("plane")).err().unwrap().to_string();
    assert!(exists.contains("does not exist yet"), "{exists}");
}

#[test]
fn a_recording_that_falls_behind_ends_and_says_so() {
    let directory = tempfile::tempdir().unwrap();
    let options = options(&directory);
    let mut simulation = simulation("plane");
    let (recorder, mut tape) = Recorder::create(&options, &simulation).unwrap();
    // The first hash is there already.
    for _ in 0..TAPE_CAPACITY {
        simulation.advance();
        tape.ticked(&simulation, false);
    }
    recorder.run();
    let verdict = judge(&std::fs::read(&options.file).unwrap()).unwrap();
    assert_eq!(verdict.ending, Some(Ending::Incomplete("the recorder fell behind".to_owned())));
    assert!(verdict.difference.is_none() && verdict.hashes + verdict.states == TAPE_CAPACITY as u64);
}

#[test]
fn a_tick_thread_that_dies_leaves_an_incomplete_recording() {
    let directory = tempfile::tempdir().unwrap();
    let options = options(&directory);
    let (recorder, tape) = Recorder::create(&options, &simulation("plane")).unwrap();
    drop(tape);
    recorder.run();
    let verdict = judge(&std::fs::read(&options.file).unwrap()).unwrap();
    assert_eq!(verdict.ending, Some(Ending::Incomplete("the tick loop ended by a fault".to_owned())));
}

#[test]
fn recording_a_tick_allocates_nothing() {
    let directory = tempfile::tempdir().unwrap();
    let mut simulation = simulation("original");
    let (recorder, mut tape) = Recorder::create(&options(&directory), &simulation).unwrap();
    (0..60).for_each(|_| simulation.advance());
    let recorded = allocation_counter::measure(|| {
        for _ in 0..600 {
            simulation.advance();
            tape.ticked(&simulation, false);
        }
    });
    assert_eq!(recorded.count_total, 0);
    tape.end(&simulation);
    recorder.run();
}
