//! The verbs that control an arena, over real sessions.

use super::serving::Serving;
use ballroom_client::{Client, Update};
use protocol::command::{BallSetting, Command, Scope, code};
use protocol::snapshot::World;
use serde_json::Value;
use std::time::Duration;
use zenoh::Wait;

/// Reply of any text put to the server as a command.
fn reply_to(client: &Client, text: String) -> Value {
    let replies = client.session().get(client.keys().srv_command()).payload(text).wait().unwrap();
    let sample = replies.recv().unwrap().into_result().unwrap();
    serde_json::from_slice(&sample.payload().to_bytes()).unwrap()
}

fn center(world: &World, name: &str) -> [f64; 3] {
    let ball = world.roster.names.iter().position(|known| known == name).unwrap();
    world.snapshot.center_m[ball]
}

#[test]
fn a_run_until_a_time_ends_there_and_a_reset_takes_back_what_was_asked() {
    let server = Serving::start(&["original", "--paused"]);
    let start = server.client().snapshot().unwrap();
    let epoch = start.snapshot.epoch;
    let reply = server.json(0, &["run-until", "2.5"]);
    assert_eq!(reply, serde_json::json!({"ok": true, "code": 1, "tick": 150, "epoch": epoch}));
    let past = server.json(4, &["run-until", "1"]);
    assert_eq!((&past["ok"], &past["code"]), (&false.into(), &code::INCORRECT_STATE.into()));
    let run = server.client().snapshot().unwrap();
    assert!(run.snapshot.paused && run.snapshot.time_s == 2.5);

    // Poses and velocities: the clock goes on, the books stay right.
    assert_eq!(server.json(0, &["reset", "--scope", "state"])["tick"], 150);
    let state = server.client().snapshot().unwrap();
    assert_eq!(state.snapshot.center_m, start.snapshot.center_m);
    assert_eq!((state.snapshot.epoch, state.snapshot.tick), (epoch, 150));
    let error = state.snapshot.energy_j - state.snapshot.steering_work_j - start.snapshot.energy_j;
    assert!(error.abs() < 1e-9 * start.snapshot.energy_j.abs(), "{error} J");

    // The clock: the balls stay.
    assert_eq!(server.json(0, &["step", "30"])["tick"], 180);
    let before = server.client().snapshot().unwrap();
    let reply = server.json(0, &["reset", "--scope", "time"]);
    assert_eq!((reply["tick"].as_u64(), reply["epoch"].as_u64()), (Some(0), Some(epoch + 1)));
    let after = server.client().snapshot().unwrap();
    for (now, then) in after.snapshot.center_m.iter().flatten().zip(before.snapshot.center_m.iter().flatten())
    {
        assert!((now - then).abs() < 1e-10, "{now} {then}");
    }
    assert_eq!((after.snapshot.time_s, after.snapshot.steering_work_j), (0.0, 0.0));

    // All of it, to the last bit.
    assert_eq!(server.json(0, &["reset"])["epoch"], epoch + 2);
    let again = server.client().snapshot().unwrap();
    assert_eq!(again.snapshot.state_hash, start.snapshot.state_hash);
    let refused = server.json(4, &["reset", "--scope", "state", "--seed", "7"]);
    assert_eq!(refused["code"], code::FEATURE_UNSUPPORTED);
}

#[test]
fn at_speed_max_simulated_time_leaves_the_clock_behind() {
    let server = Serving::start(&["original", "--rate", "1"]);
    assert_eq!(server.json(0, &["speed", "max"])["code"], code::OK);
    let client = server.client();
    // At one tick a second this would be a quarter of an hour.
    while client.snapshot().unwrap().snapshot.tick < 1000 {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(client.command(&Command::Pause {}).unwrap().ok);
}

#[test]
fn a_seed_places_the_clouds_anew_and_a_reset_without_one_brings_the_scenes_own_back() {
    let server = Serving::start(&["gas", "--balls", "40", "--paused"]);
    let client = server.client();
    let reset = |seed| {
        let reply = client.command(&Command::Reset { scope: Scope::All, seed }).unwrap();
        assert!(reply.ok, "{}", reply.error);
        let world = client.snapshot().unwrap();
        assert_eq!(world.snapshot.epoch, reply.epoch);
        world
    };
    let own = client.snapshot().unwrap();
    let seven = reset(Some(7));
    assert_ne!(seven.snapshot.center_m, own.snapshot.center_m);
    assert_eq!(seven.scene.clouds[0].seed, 7);
    let eight = reset(Some(8));
    assert_ne!(eight.snapshot.center_m, seven.snapshot.center_m);
    assert_eq!(reset(Some(7)).snapshot.state_hash, seven.snapshot.state_hash);
    let back = reset(None);
    assert_eq!((back.snapshot.state_hash, &back.scene), (own.snapshot.state_hash, &own.scene));
    assert_eq!(reset(None).snapshot.state_hash, own.snapshot.state_hash);
}

#[test]
fn balls_are_set_all_or_none_and_listed() {
    let server = Serving::start(&["original", "--paused"]);
    let listed = server.json(0, &["balls"]);
    assert_eq!(listed["balls"].as_array().unwrap().len(), 3);
    let player = server.json(0, &["balls", "--player"]);
    assert_eq!(player["balls"][0]["name"], "player");
    let set = &["balls", "set", "red", "--center", "-1.5,0.5", "--velocity", "0,0,0", "--spin", "2"];
    assert_eq!(server.json(0, set)["code"], code::OK);
    let there = server.json(0, &["balls", "--within", "-1.6,0.4,-1.4,0.6"]);
    assert_eq!(there["balls"][0]["name"], "red", "{there}");
    let plain = server.tool(&["balls", "--name", "red"]);
    assert!(
        plain.stdout.starts_with("red ") && plain.stdout.contains("at (-1.500000, 0.500000"),
        "{}",
        plain.stdout
    );

    let client = server.client();
    let before = client.snapshot().unwrap();
    let red = center(&before, "red");
    let ball = |name: &str, x, y| BallSetting {
        name: name.into(),
        center_m: Some([x, y]),
        ..BallSetting::default()
    };
    for (balls, code, why) in [
        (vec![ball("blue", 3.0, 3.0), ball("player", red[0], red[1])], code::OPERATION_FAILED, "overlap"),
        (vec![ball("blue", 9.999, 0.0)], code::OPERATION_FAILED, "wall"),
        (vec![ball("blue", 50.0, 0.0)], code::OPERATION_FAILED, "floor"),
        (vec![ball("blue", 3.0, 3.0), ball("blue", 4.0, 3.0)], code::OPERATION_FAILED, "twice"),
        (vec![ball("green", 3.0, 3.0)], code::NOT_FOUND, "\"green\""),
    ] {
        let reply = client.command(&Command::set_balls(balls)).unwrap();
        assert!(!reply.ok && reply.code == code && reply.error.contains(why), "{reply:?}");
        assert_eq!(client.snapshot().unwrap().snapshot.state_hash, before.snapshot.state_hash);
    }
    let places = [center(&before, "blue"), center(&before, "red")];
    let swap = vec![ball("red", places[0][0], places[0][1]), ball("blue", places[1][0], places[1][1])];
    assert!(client.command(&Command::set_balls(swap)).unwrap().ok);
    let after = client.snapshot().unwrap();
    for (name, place) in ["red", "blue"].iter().zip(places) {
        let now = center(&after, name);
        assert!((now[0] - place[0]).abs() + (now[1] - place[1]).abs() < 1e-11, "{name}: {now:?} {place:?}");
    }
}

#[test]
fn another_scene_is_a_new_epoch_that_followers_and_listeners_hear_of() {
    let server = Serving::start(&["original"]);
    let client = server.client();
    let mut follower = client.follow().unwrap();
    let Some(Update::World(world)) = follower.next() else { panic!("no world") };
    let scene = client.session().declare_subscriber(client.keys().meta_scene()).wait().unwrap();
    let epoch = world.snapshot.epoch;
    assert_eq!(server.json(0, &["load", "bowl"])["epoch"], epoch + 1);
    let world = follower
        .find_map(|update| if let Update::World(world) = update { Some(world) } else { None })
        .unwrap();
    assert_eq!((world.scene.name.as_str(), world.snapshot.epoch), ("bowl", epoch + 1));
    assert_eq!(world.snapshot.center_m.len(), world.roster.names.len());
    assert_eq!(client.scene().unwrap().name, "bowl");
    let told: Value = serde_json::from_slice(&scene.recv().unwrap().payload().to_bytes()).unwrap();
    assert_eq!(told["name"], "bowl");

    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/plane.toml");
    assert_eq!(server.json(0, &["load", file])["epoch"], epoch + 2);
    assert_eq!(client.scene().unwrap().name, "plane");
    // Presses and settings mean the new balls.
    assert!(server.tool(&["steer", "up", "--ball", "cue"]).code == 0);
    assert_eq!(server.json(4, &["balls", "set", "red"])["code"], code::NOT_FOUND);
    // And a reset begins the new scene again.
    assert_eq!(server.json(0, &["reset"])["epoch"], epoch + 3);
    assert_eq!(client.scene().unwrap().name, "plane");
}

#[test]
fn a_scene_that_cannot_be_run_is_refused_with_line_and_field_and_the_present_one_goes_on() {
    let server = Serving::start(&["original", "--paused"]);
    let client = server.client();
    let before = client.snapshot().unwrap();
    let original = include_str!("../../scenes/original.toml");
    let load = |toml: &str| Command::LoadScene { name: None, toml: Some(toml.into()), balls: None };
    for (command, code, why) in [
        (load("version = 1"), code::BAD_SCENE, "toml:1:1"),
        (load(&original.replacen("radius_m = ", "radius_m = -", 1)), code::BAD_SCENE, "radius_m"),
        (
            Command::LoadScene { name: Some("nowhere".into()), toml: None, balls: None },
            code::NOT_FOUND,
            "use one of original",
        ),
        // Only scenes of the program have names: a client does not read files through the server.
        (
            Command::LoadScene { name: Some("scenes/bowl.toml".into()), toml: None, balls: None },
            code::NOT_FOUND,
            "no built-in",
        ),
    ] {
        let reply = client.command(&command).unwrap();
        assert!(!reply.ok && reply.code == code && reply.error.contains(why), "{reply:?}");
    }
    let after = client.snapshot().unwrap();
    assert_eq!((after.scene, after.snapshot.state_hash), (before.scene, before.snapshot.state_hash));
}

#[test]
fn what_is_too_long_or_too_many_is_refused_by_its_number() {
    let server = Serving::start(&["original", "--paused"]);
    let client = server.client();
    let padded = format!("{{\"cmd\":\"step\"{}}}", " ".repeat(512));
    let many: Vec<String> = (0..1025).map(|i| format!("{{\"name\":\"b{i}\"}}")).collect();
    for (text, code) in [
        (padded, code::TOO_LONG),
        (format!("{{\"cmd\":\"load_scene\",\"toml\":\"{}\"}}", "#".repeat(512 << 10)), code::TOO_LONG),
        (format!("{{\"cmd\":\"set_balls\",\"balls\":[{}]}}", many.join(",")), code::MALFORMED),
        ("[".repeat(100_000), code::MALFORMED),
        ("{\"cmd\":\"fly\"}".to_owned(), code::MALFORMED),
    ] {
        let reply = reply_to(&client, text);
        assert_eq!((&reply["ok"], &reply["code"]), (&false.into(), &code.into()), "{reply}");
    }
    assert_eq!(client.snapshot().unwrap().snapshot.tick, 0);
}

#[test]
fn scenes_and_features_are_told() {
    let server = Serving::start(&["plane", "--paused"]);
    let scenes = server.json(0, &["scenes"]);
    let mut names: Vec<&str> =
        scenes["scenes"].as_array().unwrap().iter().map(|scene| scene["name"].as_str().unwrap()).collect();
    names.sort_unstable();
    let mut known = super::built_in_scenes();
    known.sort_unstable();
    assert_eq!(names, known);
    assert!(scenes["scenes"].as_array().unwrap().iter().all(|scene| scene["description"] != ""));
    let features = server.json(0, &["features"]);
    assert_eq!(features["commands"]["set_balls"]["max_balls"], 1024.0);
    // Every command that is told of is one: none is unknown, whatever else it lacks.
    let client = server.client();
    for name in features["commands"].as_object().unwrap().keys() {
        let reply = reply_to(&client, format!("{{\"cmd\":\"{name}\",\"nonsense\":0}}"));
        assert!(reply["error"].as_str().unwrap().contains("unknown field"), "{name}: {reply}");
    }
}
