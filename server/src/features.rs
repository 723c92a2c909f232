//! What an arena understands, with limits, and the scenes that come with it.

use crate::arena::TICK_RATES_HZ;
use crate::history::{MAX_POINTS, MAX_SLOT_BYTES};
use crate::inbox::INBOX_CAPACITY;
use crate::players::{DRIVES_PER_S, MESSAGES_PER_S};
use crate::scene_file::{SceneText, built_in_names};
use crate::workshop::MAX_JOBS;
use protocol::change::{MAX_CHANGED_BALLS, MAX_MOVED_POINTS, MAX_SET_PARAMETERS};
use protocol::codec::{MAX_BALLS, MAX_COMMAND_BYTES, MAX_REQUEST_BYTES};
use protocol::command::{MAX_RUN_TICKS, MAX_SET_BALLS, MAX_STEP_TICKS, SPEED_FACTORS};
use protocol::listing::{Features, MAX_ROWS, SceneEntry, Scenes};
use protocol::player::{
    LEASE_MILLIS, MAX_CLAIM_BYTES, MAX_DRIVE_BYTES, MAX_PLAYERS, MAX_TICKS_AHEAD, MAX_WINDOW,
};
use protocol::scene::MAX_TAGS;
use protocol::timeline::{MAX_REWIND_S, MAX_SLOTS, MAX_WORDS_BYTES};

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
        ("step", of(&[queue, short, ("max_ticks", MAX_STEP_TICKS as f64)])),
        ("run_until", of(&[queue, short, ("max_ticks", MAX_RUN_TICKS as f64)])),
        ("speed", of(&[queue, short, ("min_factor", slowest), ("max_factor", fastest), rates])),
        ("reset", of(&[jobs, short])),
        ("set_balls", of(&[jobs, long, ("max_balls", MAX_SET_BALLS as f64)])),
        ("spawn", of(&[jobs, long, ("max_balls", MAX_CHANGED_BALLS as f64), ("max_tags", MAX_TAGS as f64)])),
        ("delete", of(&[jobs, long, ("max_names", MAX_CHANGED_BALLS as f64)])),
        ("move_control_points", of(&[jobs, long, ("max_points", MAX_MOVED_POINTS as f64)])),
        ("set_parameters", of(&[jobs, short, ("max_values", MAX_SET_PARAMETERS as f64)])),
        ("rewind", of(&[jobs, short, ("max_points", MAX_POINTS as f64), ("max_seconds", MAX_REWIND_S)])),
        (
            "save_state",
            of(&[jobs, short, ("max_slots", MAX_SLOTS as f64), ("max_slot_bytes", MAX_SLOT_BYTES as f64)]),
        ),
        ("load_state", of(&[jobs, long, ("max_words_bytes", MAX_WORDS_BYTES as f64)])),
        ("load_scene", of(&[jobs, long, ("max_balls", MAX_BALLS as f64)])),
    ];
    // The rest is of the messages of whoever was given a ball.
    let claim = [
        ("max_bytes", MAX_CLAIM_BYTES as f64),
        ("max_players", MAX_PLAYERS as f64),
        ("lease_s", LEASE_MILLIS as f64 * 1e-3),
        ("max_drive_bytes", MAX_DRIVE_BYTES as f64),
        ("max_unacknowledged", MAX_WINDOW as f64),
        ("max_ticks_ahead", MAX_TICKS_AHEAD as f64),
        ("max_messages_per_s", MESSAGES_PER_S),
        ("max_commands_per_s", DRIVES_PER_S),
    ];
    let questions = [
        ("snapshot", of(&[])),
        ("scene", of(&[])),
        ("stats", of(&[])),
        ("info", of(&[])),
        ("features", of(&[])),
        ("scenes", of(&[])),
        ("parameters", of(&[])),
        ("slots", of(&[])),
        ("checkpoint", of(&[])),
        ("balls", of(&[("max_rows", MAX_ROWS as f64)])),
        ("players", of(&[])),
        ("release", of(&[("max_bytes", MAX_CLAIM_BYTES as f64)])),
        ("claim", of(&claim)),
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
