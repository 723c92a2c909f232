//! What an arena understands, with limits, and the scenes that come with it.

use crate::arena::TICK_RATES_HZ;
use crate::inbox::INBOX_CAPACITY;
use crate::scene_file::{SceneText, built_in_names};
use crate::workshop::MAX_JOBS;
use protocol::codec::{MAX_BALLS, MAX_COMMAND_BYTES, MAX_REQUEST_BYTES};
use protocol::command::{MAX_RUN_TICKS, MAX_SET_BALLS, MAX_STEP_TICKS, SPEED_FACTORS};
use protocol::listing::{Features, MAX_ROWS, SceneEntry, Scenes};

/// What is supported.
pub fn features() -> Features {
    let [slowest, fastest] = SPEED_FACTORS;
    let of =
        |limits: &[(&str, f64)]| limits.iter().map(|(name, limit)| ((*name).to_owned(), *limit)).collect();
    let queue = ("max_waiting", INBOX_CAPACITY as f64);
    let jobs = ("max_waiting", MAX_JOBS as f64);
    let (short, long) = (("max_bytes", MAX_COMMAND_BYTES as f64), ("max_bytes", MAX_REQUEST_BYTES as f64));
    let rates = ("max_tick_rate_hz", f64::from(*TICK_RATES_HZ.end()));
    let commands = [
        ("steer", of(&[queue, short])),
        ("pause", of(&[queue, short])),
        ("resume", of(&[queue, short])),
        ("set_state", of(&[jobs, short])),
        ("step", of(&[queue, short, ("max_ticks", MAX_STEP_TICKS as f64)])),
        ("run_until", of(&[queue, short, ("max_ticks", MAX_RUN_TICKS as f64)])),
        ("speed", of(&[queue, short, ("min_factor", slowest), ("max_factor", fastest), rates])),
        ("reset", of(&[jobs, short])),
        ("set_balls", of(&[jobs, long, ("max_balls", MAX_SET_BALLS as f64)])),
        ("load_scene", of(&[jobs, long, ("max_balls", MAX_BALLS as f64)])),
    ];
    let questions = [
        ("snapshot", of(&[])),
        ("scene", of(&[])),
        ("stats", of(&[])),
        ("info", of(&[])),
        ("state", of(&[])),
        ("features", of(&[])),
        ("scenes", of(&[])),
        ("balls", of(&[("max_rows", MAX_ROWS as f64)])),
    ];
    Features {
        commands: commands.into_iter().map(|(name, limits)| (name.to_owned(), limits)).collect(),
        questions: questions.into_iter().map(|(name, limits)| (name.to_owned(), limits)).collect(),
    }
}

/// The scenes that come with the program.
pub fn scenes() -> Scenes {
    let scenes = built_in_names().map(|name| {
        let scene = SceneText::built_in(name).and_then(|text| text.parse());
        SceneEntry {
            name: name.to_owned(),
            description: scene.map(|scene| scene.description).unwrap_or_default(),
        }
    });
    Scenes { scenes: scenes.collect() }
}
