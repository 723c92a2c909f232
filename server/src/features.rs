//! What an arena understands, with limits, and the scenes that come with it.

use crate::arena::TICK_RATES_HZ;
use crate::arenas::MAX_RECORDINGS;
use crate::checker::MAX_CHECKS;
use crate::history::{MAX_POINTS, MAX_SLOT_BYTES};
use crate::inbox::INBOX_CAPACITY;
use crate::network::{ANSWERS_PER_S, MAX_SESSIONS, PRESSES_PER_S, REFUSED_PER_S, WHOLE_BYTES_PER_S};
use crate::players::{DRIVES_PER_S, MESSAGES_PER_S};
use crate::scene_file::{SceneText, built_in_names};
use crate::workshop::MAX_JOBS;
use protocol::arenas::MAX_ARENAS;
use protocol::change::{MAX_CHANGED_BALLS, MAX_MOVED_POINTS, MAX_SET_PARAMETERS};
use protocol::codec::{MAX_BALLS, MAX_COMMAND_BYTES, MAX_REQUEST_BYTES};
use protocol::command::{MAX_RUN_TICKS, MAX_SET_BALLS, MAX_STEP_TICKS, SPEED_FACTORS};
use protocol::listing::{Features, MAX_ROWS, SceneEntry, Scenes};
use protocol::player::{
    LEASE_MILLIS, MAX_CLAIM_BYTES, MAX_DRIVE_BYTES, MAX_PLAYERS, MAX_TICKS_AHEAD, MAX_WINDOW,
};
use protocol::report::{MAX_READERS, MAX_REPORT_BYTES};
use protocol::scene::MAX_TAGS;
use protocol::timeline::{MAX_REWIND_S, MAX_SLOTS, MAX_WORDS_BYTES};

/// Features of ROS `simulation_interfaces`: name, number, and the command or question by which a bridge offers it.
const ROS: [(&str, u8, &str); 19] = [
    ("SPAWNING", 0, "spawn"),
    ("DELETING", 1, "delete"),
    ("ENTITY_TAGS", 4, "spawn"),
    ("ENTITY_BOUNDS", 5, "balls"),
    ("ENTITY_STATE_GETTING", 10, "balls"),
    ("ENTITY_STATE_SETTING", 11, "set_balls"),
    ("SIMULATION_RESET", 20, "reset"),
    ("SIMULATION_RESET_TIME", 21, "reset"),
    ("SIMULATION_RESET_STATE", 22, "reset"),
    ("SIMULATION_RESET_SPAWNED", 23, "reset"),
    ("SIMULATION_STATE_GETTING", 24, "state"),
    ("SIMULATION_STATE_SETTING", 25, "set_state"),
    ("SIMULATION_STATE_PAUSE", 26, "set_state"),
    ("STEP_SIMULATION_SINGLE", 31, "step"),
    ("STEP_SIMULATION_MULTIPLE", 32, "step"),
    ("WORLD_LOADING", 40, "load_scene"),
    ("WORLD_RESOURCE_STRING", 41, "load_scene"),
    ("WORLD_INFO_GETTING", 44, "scene"),
    ("AVAILABLE_WORLDS", 45, "scenes"),
];

/// What is supported.
pub fn features() -> Features {
    let [slowest, fastest] = SPEED_FACTORS;
    let of =
        |limits: &[(&str, f64)]| limits.iter().map(|(name, limit)| ((*name).to_owned(), *limit)).collect();
    let queue = ("max_waiting", INBOX_CAPACITY as f64);
    let jobs = ("max_waiting", MAX_JOBS as f64);
    let (short, long) = (("max_bytes", MAX_COMMAND_BYTES as f64), ("max_bytes", MAX_REQUEST_BYTES as f64));
    let whole = ("max_bytes_per_s_of_all", WHOLE_BYTES_PER_S);
    let rates = ("max_tick_rate_hz", f64::from(*TICK_RATES_HZ.end()));
    let commands = [
        ("steer", of(&[queue, short, ("max_presses_per_s", PRESSES_PER_S)])),
        ("pause", of(&[queue, short])),
        ("resume", of(&[queue, short])),
        ("set_state", of(&[jobs, short])),
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
        ("reload_scene", of(&[jobs, short])),
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
        ("snapshot", of(&[whole])),
        ("scene", of(&[])),
        ("stats", of(&[])),
        ("info", of(&[])),
        ("state", of(&[])),
        ("features", of(&[])),
        ("scenes", of(&[])),
        ("parameters", of(&[])),
        ("slots", of(&[])),
        ("checkpoint", of(&[whole])),
        ("balls", of(&[("max_rows", MAX_ROWS as f64)])),
        ("players", of(&[])),
        ("release", of(&[("max_bytes", MAX_CLAIM_BYTES as f64)])),
        ("claim", of(&claim)),
        ("check", of(&[long, ("max_waiting", MAX_CHECKS as f64)])),
        (
            "clients",
            of(&[("max_readers", MAX_READERS as f64), ("max_report_bytes", MAX_REPORT_BYTES as f64)]),
        ),
        (
            "arenas",
            of(&[
                long,
                ("max_clients", MAX_SESSIONS as f64),
                ("max_refused_per_s_of_a_client", REFUSED_PER_S),
                ("max_commands_per_s_of_all", ANSWERS_PER_S),
                ("max_questions_per_s_of_all", ANSWERS_PER_S),
                ("max_arenas", MAX_ARENAS as f64),
                ("max_recordings", MAX_RECORDINGS as f64),
            ]),
        ),
    ];
    let is_there = |word: &str| {
        commands.iter().any(|(name, _)| *name == word) || questions.iter().any(|(name, _)| *name == word)
    };
    let ros = ROS.iter().filter(|(_, _, needs)| is_there(needs));
    let ros = ros.map(|(name, number, _)| ((*name).to_owned(), *number)).collect();
    Features {
        ros,
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
