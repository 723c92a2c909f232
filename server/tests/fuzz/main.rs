//! A fuzz target for every decoder of the server: scene files up to the world they make, checkpoints, recordings.
//! `cargo test` runs each for a bounded number of inputs and prints the seed of one that fails;
//! `cargo bolero test -p server --test fuzz TARGET` runs one for as long as wanted, led by coverage.

#[path = "../../../protocol/tests/fuzz/damage.rs"]
mod damage;

use ballroom_physics::CheckpointFault;
use damage::damaged;
use protocol::snapshot::Snapshot;
use protocol::timeline::SavedState;
use server::history::Past;
use server::recording::{Reader, RecordOptions, Recorder, replay};
use server::scene_file::SceneText;
use server::simulation::{Ground, Moment, Simulation};
use std::cell::Cell;
use std::io::Cursor;
use std::sync::{Arc, LazyLock};

/// Longest input, bytes.
const MAX_LEN: usize = 128;
/// Ticks that are run of what was taken.
const TICKS: usize = 3;

const SCENE: &str = r#"version = 1
name = "fuzz"
motion = "rolling"
restitution = 0.9
gravity_m_per_s2 = [0.0, 0.0, -9.81]
[accuracy]
tolerance_m = 1e-6
[floor.polynomial]
x_m = [-1.0, 1.0]
y_m = [-1.0, 1.0]
terms = [{ px = 2, c = 0.1 }, { px = 1, py = 2, c = 0.2 }]
[walls]
box = { x_m = [-0.95, 0.95], y_m = [-0.95, 0.95] }
[[walls.plane]]
point_m = [0.9, 0.0]
normal = [-1.0, 0.5]
[steering]
impulse_m_per_s = 1.0
[[ball]]
name = "a"
radius_m = 0.1
mass_kg = 1.0
center_m = [0.0, 0.5]
velocity_m_per_s = [1.0, 0.5, 0.0]
player = true
[[ball]]
name = "b"
radius_m = 0.2
mass_kg = 3.0
uv = [0.3, 0.3]
[[cloud]]
name = "c"
count = 3
radius_m = [0.02, 0.03]
density_kg_per_m3 = 955.0
within_m = 0.3
speed_rms_m_per_s = 1.0
"#;

/// A world, and a state of it.
static VALID: LazyLock<(Arc<Ground>, SavedState)> = LazyLock::new(|| {
    let loaded = SceneText::new("fuzz.toml", SCENE).load().unwrap();
    let mut simulation = Simulation::new(Arc::new(loaded), 60, 1).unwrap();
    for _ in 0..20 {
        simulation.advance();
    }
    let ground = Arc::new(simulation.ground());
    let saved = Past::new(&ground, &moment(&simulation)).to_saved().unwrap();
    (ground, saved)
});

fn assert_finite(simulation: &Simulation) {
    let mut state = Snapshot::default();
    simulation.write_snapshot(&mut state);
    let numbers = state.center_m.iter().chain(&state.velocity_m_per_s).flatten();
    assert!(numbers.chain([&state.energy_j, &state.time_s]).all(|x| x.is_finite()), "{state:?}");
}

fn run(simulation: &mut Simulation) {
    for _ in 0..TICKS {
        simulation.advance();
    }
}

#[test]
fn a_scene_and_its_first_ticks() {
    let valid = [SCENE.as_bytes().to_vec()];
    bolero::check!().with_iterations(1000).with_max_len(MAX_LEN).for_each(move |input: &[u8]| {
        let Ok(text) = String::from_utf8(damaged(input, &valid)) else { return };
        let Ok(loaded) = SceneText::new("fuzz.toml", text).load() else { return };
        if let Ok(mut simulation) = Simulation::new(Arc::new(loaded), 60, 1) {
            run(&mut simulation);
            assert_finite(&simulation);
        }
    });
}

/// What goes on after words were taken is nobody's run any more, but it may not end the program.
fn go_on(taken: Result<Simulation, CheckpointFault>) {
    if let Ok(mut simulation) = taken {
        assert_finite(&simulation);
        run(&mut simulation);
    }
}

fn moment(simulation: &Simulation) -> Moment {
    let mut moment = Moment::with_room(&simulation.ground());
    simulation.write_moment(&mut moment);
    moment
}

#[test]
fn a_saved_state_and_what_goes_on_from_it() {
    let (ground, saved) = &*VALID;
    let valid = [serde_json::to_vec(saved).unwrap()];
    bolero::check!().with_iterations(2000).with_max_len(MAX_LEN).for_each(move |input: &[u8]| {
        let Ok(saved) = serde_json::from_slice::<SavedState>(&damaged(input, &valid)) else { return };
        go_on(Past::of_saved(ground, &saved).and_then(|past| past.simulation()));
    });
}

#[test]
fn a_recording_and_its_replay() {
    let directory = tempfile::tempdir().unwrap();
    let options = RecordOptions::new(directory.path().join("ride.mcap"));
    let loaded = SceneText::new("fuzz.toml", SCENE).load().unwrap();
    let mut simulation = Simulation::new(Arc::new(loaded), 60, 1).unwrap();
    let (recorder, mut tape) = Recorder::create(&options, &simulation).unwrap();
    let recorder = std::thread::spawn(move || recorder.run());
    for _ in 0..30 {
        simulation.advance();
        tape.ticked(&simulation, false);
    }
    tape.end(&simulation);
    recorder.join().unwrap();
    let valid = [std::fs::read(&options.file).unwrap()];
    bolero::check!().with_iterations(1000).with_max_len(MAX_LEN).for_each(move |input: &[u8]| {
        let Ok(mut reader) = Reader::new(Cursor::new(damaged(input, &valid))) else { return };
        let messages = Cell::new(0);
        drop(replay(&mut reader, || messages.replace(messages.get() + 1) > 100));
    });
}
