//! Scenes read again, and scenes asked about.

use super::ballroom;
use super::serving::Serving;
use protocol::command::{Command, code};
use serde_json::Value;

#[test]
fn a_reload_reads_the_file_anew_or_leaves_everything_as_it_was() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let (file, ride) = (path("table.toml"), path("ride.mcap"));
    let plane = include_str!("../../scenes/plane.toml");
    let write = |text: &str| std::fs::write(&file, text).unwrap();
    write(plane);
    let mut server = Serving::start(&[&file, "--paused", "--record", &ride]);
    let client = server.client();
    let first = client.snapshot().unwrap();
    server.json(0, &["step", "10"]);

    write(&plane.replacen("motion = ", "restitution = 0.5\nmotion = ", 1));
    let reloaded = server.json(0, &["reload"]);
    assert_eq!(
        (reloaded["tick"].as_u64(), reloaded["epoch"].as_u64()),
        (Some(0), Some(first.snapshot.epoch + 1))
    );
    assert_eq!(client.scene().unwrap().restitution, 0.5);
    server.json(0, &["step", "10"]);

    write("version = 1\n");
    let before = client.snapshot().unwrap();
    let refused = server.json(4, &["reload"]);
    assert_eq!(refused["code"], code::BAD_SCENE);
    assert!(refused["error"].as_str().unwrap().contains("table.toml:1:1"), "{refused}");
    assert_eq!(client.snapshot().unwrap(), before);
    std::fs::remove_file(&file).unwrap();
    let gone = server.json(4, &["reload"]);
    assert!(gone["error"].as_str().unwrap().contains("cannot be opened"), "{gone}");

    // The recording holds what was read: it needs no file.
    server.json(0, &["state", "quitting"]);
    assert_eq!(server.ended(), 0);
    let verdict = ballroom(&["replay", &ride, "--json"]);
    assert_eq!(verdict.code, 0, "{}{}", verdict.stdout, verdict.stderr);
    let verdict: Value = serde_json::from_str(&verdict.stdout).unwrap();
    assert_eq!((&verdict["ticks"], &verdict["ending"]), (&20.into(), &"complete".into()));
}

#[test]
fn a_built_in_scene_is_reloaded_after_another_was_loaded_and_keeps_its_number_of_balls() {
    let server = Serving::start(&["gas", "--balls", "30", "--paused"]);
    let client = server.client();
    let first = client.snapshot().unwrap();
    server.json(0, &["load", "gas", "--balls", "20"]);
    assert_eq!(client.snapshot().unwrap().roster.names.len(), 20);
    server.json(0, &["reload"]);
    let again = client.snapshot().unwrap();
    assert_eq!((again.snapshot.state_hash, &again.scene), (first.snapshot.state_hash, &first.scene));
}

#[test]
fn a_check_tells_fault_or_certificate_and_touches_nothing() {
    let server = Serving::start(&["plane", "--paused"]);
    let client = server.client();
    let before = client.snapshot().unwrap();
    let original = include_str!("../../scenes/original.toml");
    let good = client.check(original).unwrap();
    assert!(good.ok && good.fault.is_none());
    let scene = good.scene.unwrap();
    assert_eq!((scene.name.as_str(), scene.balls), ("original", 3));
    assert!(scene.certificate.reach_m.unwrap()[0] > 0.0);
    let bad = client.check(&original.replacen("radius_m = ", "radius_m = -", 1)).unwrap();
    let fault = bad.fault.unwrap();
    assert!(!bad.ok && bad.scene.is_none() && fault.field.ends_with("radius_m"), "{fault:?}");
    let line = original.lines().position(|line| line.contains("radius_m = ")).unwrap() + 1;
    assert_eq!(fault.line, Some(line));
    let refused = client.check(&"#".repeat((512 << 10) + 1)).unwrap_err();
    assert!(refused.to_string().contains("too many"), "{refused}");
    assert!(client.command(&Command::Step { ticks: 1 }).unwrap().ok);
    assert_eq!(client.snapshot().unwrap().snapshot.epoch, before.snapshot.epoch);
}

#[test]
fn features_name_what_a_bridge_to_ros_can_offer() {
    let server = Serving::start(&["plane", "--paused"]);
    let features = server.json(0, &["features"]);
    let ros = &features["ros"];
    for (name, number) in [("SIMULATION_RESET", 20), ("SIMULATION_STATE_SETTING", 25), ("WORLD_LOADING", 40)]
    {
        assert_eq!(ros[name], number);
    }
    // What needs a command that is not there is not offered.
    assert_eq!(ros.get("SPAWNING").is_some(), features["commands"].get("spawn").is_some());
    assert_eq!(features["questions"]["arenas"]["max_arenas"], 32.0);
}
