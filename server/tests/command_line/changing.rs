//! Balls that come and go, a floor that moves, numbers that change: over real sessions.

use super::serving::Serving;
use ballroom_client::{Client, Update};
use protocol::change::PointMove;
use protocol::command::{Command, Reply, code};
use protocol::scene::Floor;
use protocol::snapshot::World;
use serde_json::{Value, json};

fn command(client: &Client, text: &str) -> Reply {
    client.command(&Command::from_json(text).unwrap()).unwrap()
}

fn done(client: &Client, text: &str) -> Reply {
    let reply = command(client, text);
    assert!(reply.ok, "{text}: {reply:?}");
    reply
}

fn refused(client: &Client, text: &str, code: u16, why: &str) {
    let reply = command(client, text);
    assert!(!reply.ok && reply.code == code && reply.error.contains(why), "{text}: {reply:?}");
}

/// Energy less what was put in.
fn books(world: &World) -> f64 {
    world.snapshot.energy_j - world.snapshot.steering_work_j
}

#[test]
fn balls_come_and_go_while_the_clock_goes_on() {
    let server = Serving::start(&["original", "--paused"]);
    let client = server.client();
    let start = client.snapshot().unwrap();
    let epoch = start.snapshot.epoch;
    done(&client, r#"{"cmd":"step","ticks":30}"#);
    let spawn = &["balls", "spawn", "guest", "--center", "-8,8", "--radius", "0.5", "--mass", "2"];
    let reply = server.json(0, &[spawn, &["--tag", "guests", "--color", "#102030"][..]].concat());
    assert_eq!(reply, json!({"ok": true, "code": 1, "tick": 30, "epoch": epoch + 1}));
    let more = r#"{"cmd":"spawn","balls":[{"name":"g2","center_m":[8,-8],"radius_m":0.4,"mass_kg":1,"inertia":"hollow",
        "velocity_m_per_s":[0,1,0],"tags":["guests","late"],"player":true},
        {"name":"g1","uv":[0.9,0.5],"radius_m":0.4,"mass_kg":1}]}"#;
    assert_eq!(done(&client, more).epoch, epoch + 2);
    let world = client.snapshot().unwrap();
    assert_eq!(world.roster.names, ["blue", "g1", "g2", "guest", "player", "red"]);
    assert_eq!((world.snapshot.tick, world.snapshot.time_s), (30, 0.5));
    assert_eq!(world.roster.color_rgb[3], [16, 32, 48]);
    assert!((books(&world) - books(&start)).abs() < 1e-9 * books(&start).abs());

    // They are found by what they are.
    let named = |arguments: &[&str]| -> Vec<String> {
        let listed = server.json(0, &[&["balls"], arguments].concat());
        listed["balls"].as_array().unwrap().iter().map(|ball| ball["name"].as_str().unwrap().into()).collect()
    };
    assert_eq!(named(&["--tag", "guests"]), ["g2", "guest"]);
    assert_eq!(named(&["--spawned"]), ["g1", "g2", "guest"]);
    assert_eq!(named(&["--tag", "guests", "--player"]), ["g2"]);
    assert_eq!(named(&["--within", "-9,7,-7,9"]), ["guest"]);
    assert!(server.tool(&["balls"]).stdout.contains("player  spawned  #guests  #late"));
    // And driven, and set alike.
    assert_eq!(server.tool(&["steer", "up", "--ball", "g2"]).code, 0);
    assert_eq!(
        server.json(0, &["balls", "set", "--with-tag", "guests", "--velocity", "0,0,0"])["code"],
        code::OK
    );
    let speeds = server.json(0, &["balls", "--tag", "guests"]);
    assert!(
        speeds["balls"]
            .as_array()
            .unwrap()
            .iter()
            .all(|ball| ball["velocity_m_per_s"] == json!([0.0, 0.0, 0.0]))
    );

    done(&client, r#"{"cmd":"step","ticks":30}"#);
    let reply = done(&client, r#"{"cmd":"delete","names":["g1","blue"]}"#);
    assert_eq!((reply.tick, reply.epoch), (60, epoch + 3));
    assert_eq!(server.json(0, &["balls", "delete", "--within", "-9,7,-7,9"])["epoch"], epoch + 4);
    assert_eq!(client.snapshot().unwrap().roster.names, ["g2", "player", "red"]);
    assert_eq!(server.json(0, &["reset", "--scope", "spawned"])["tick"], 60);
    let world = client.snapshot().unwrap();
    assert_eq!((world.roster.names.len(), world.snapshot.epoch), (2, epoch + 5));
    assert!((books(&world) - books(&start)).abs() < 1e-9 * books(&start).abs());
    // Nothing more to take away: nothing happens.
    assert_eq!(server.json(0, &["reset", "--scope", "spawned"])["epoch"], epoch + 5);
    // Everything comes back.
    assert_eq!(server.json(0, &["reset"])["epoch"], epoch + 6);
    let again = client.snapshot().unwrap();
    assert_eq!((again.snapshot.state_hash, again.roster), (start.snapshot.state_hash, start.roster));
}

#[test]
fn what_cannot_come_or_go_is_refused_as_a_whole_with_its_reason() {
    let server = Serving::start(&["original", "--paused"]);
    let client = server.client();
    let before = client.snapshot().unwrap();
    let red = before.snapshot.center_m[2];
    let ball = |name: &str, x: f64, y: f64, radius: f64| json!({"name": name, "center_m": [x, y], "radius_m": radius, "mass_kg": 1.0});
    let spawn = |balls: &[Value]| json!({"cmd": "spawn", "balls": balls}).to_string();
    let fine = ball("a", -8.0, 8.0, 0.4);
    for (balls, code, why) in [
        (
            vec![fine.clone(), ball("b", red[0], red[1], 0.4)],
            code::OPERATION_FAILED,
            "\"b\" and \"red\" would overlap",
        ),
        (vec![fine.clone(), ball("b", -8.0, 8.5, 0.4)], code::OPERATION_FAILED, "overlap"),
        (vec![ball("a", 9.7, 0.0, 0.4)], code::OPERATION_FAILED, "into wall 1"),
        (vec![ball("a", 50.0, 0.0, 0.4)], code::OPERATION_FAILED, "balls[0]: \"a\" is not over the floor"),
        (
            vec![ball("red", -8.0, 8.0, 0.4)],
            code::OPERATION_FAILED,
            "balls[0].name: there is a ball \"red\" already",
        ),
        (vec![fine.clone(), fine.clone()], code::OPERATION_FAILED, "balls[1].name"),
        (vec![ball("a", -8.0, 8.0, 4.0)], code::OPERATION_FAILED, "balls[0].radius_m"),
        (vec![ball("a", -8.0, 8.0, -1.0)], code::OPERATION_FAILED, "balls[0].radius_m: is -1"),
    ] {
        refused(&client, &spawn(&balls), code, why);
    }
    refused(&client, r#"{"cmd":"delete","names":["red","green"]}"#, code::NOT_FOUND, "\"green\"");
    refused(&client, r#"{"cmd":"delete","tag":"nobody"}"#, code::NOT_FOUND, "tag=nobody");
    refused(&client, r#"{"cmd":"delete","within_m":[9.5,9.5,9.6,9.6]}"#, code::NOT_FOUND, "within");
    refused(
        &client,
        r#"{"cmd":"set_balls","select":{"tag":"x"},"spin_rad_per_s":1}"#,
        code::NOT_FOUND,
        "tag=x",
    );
    let after = client.snapshot().unwrap();
    assert_eq!(
        (after.snapshot.state_hash, after.snapshot.epoch),
        (before.snapshot.state_hash, before.snapshot.epoch)
    );
    // What was refused at the tick is forgotten: the next is made ready for the balls that are there.
    done(&client, &spawn(&[fine]));
    assert_eq!(client.snapshot().unwrap().roster.names.len(), 4);
}

#[test]
fn balls_that_many_ask_for_at_once_all_come() {
    let server = Serving::start(&["original"]);
    let threads: Vec<_> = (0..4)
        .map(|i| {
            let client = server.client();
            std::thread::spawn(move || {
                for j in 0..3 {
                    let place = format!("{{\"cmd\":\"spawn\",\"balls\":[{{\"name\":\"n{i}{j}\",\"center_m\":[{},{}],\"radius_m\":0.1,\"mass_kg\":0.001}}]}}", -9.0 + f64::from(j), 8.0 + 0.4 * f64::from(i));
                    done(&client, &place);
                }
            })
        })
        .collect();
    threads.into_iter().for_each(|thread| thread.join().unwrap());
    assert_eq!(server.client().snapshot().unwrap().roster.names.len(), 15);
}

#[test]
fn the_floor_moves_under_rolling_balls_and_back_to_the_bit() {
    let server = Serving::start(&["original", "--paused"]);
    let client = server.client();
    let mut follower = client.follow().unwrap();
    let Some(Update::World(start)) = follower.next() else { panic!("no world") };
    let epoch = start.snapshot.epoch;
    done(&client, r#"{"cmd":"step","ticks":60}"#);
    let before = client.snapshot().unwrap();
    assert_eq!(server.json(0, &["floor", "move", "5,3=-4,0,-60"])["epoch"], epoch + 1);
    let moved = follower
        .find_map(|update| if let Update::World(world) = update { Some(world) } else { None })
        .unwrap();
    let Floor::Net { control_points_m } = &moved.scene.floor else { panic!("{:?}", moved.scene.floor) };
    assert_eq!(control_points_m[5][3], [-4.0, 0.0, -60.0]);
    assert!(moved.scene.walls.bounds.is_some(), "the walls stay where they were");
    assert_eq!((moved.snapshot.epoch, moved.snapshot.tick), (epoch + 1, 60));
    for (now, then) in moved.snapshot.center_m.iter().zip(&before.snapshot.center_m) {
        assert!((now[0] - then[0]).abs() + (now[1] - then[1]).abs() < 1e-10, "{now:?} {then:?}");
    }
    assert!((books(&moved) - books(&start)).abs() < 1e-9 * books(&start).abs());

    let state = client.snapshot().unwrap().snapshot.state_hash;
    let move_to = |row, column, to_m| {
        serde_json::to_string(&Command::MoveControlPoints { points: vec![PointMove { row, column, to_m }] })
            .unwrap()
    };
    refused(&client, &move_to(11, 0, [0.0; 3]), code::OPERATION_FAILED, "rows 0 to 10 and columns 0 to 10");
    refused(&client, &move_to(5, 3, [-4.0, 0.0, -700.0]), code::OPERATION_FAILED, "curvature");
    refused(
        &client,
        &move_to(5, 0, [-9.0, 0.0, 0.0]),
        code::OPERATION_FAILED,
        "border u = 0 is not behind any wall",
    );
    assert_eq!(client.snapshot().unwrap().snapshot.state_hash, state);

    done(&client, &move_to(5, 3, [-4.0, 0.0, -70.0]));
    let back = client.snapshot().unwrap();
    assert_eq!((&back.scene, back.snapshot.epoch), (&start.scene, epoch + 2));
    assert!((books(&back) - books(&start)).abs() < 1e-9 * books(&start).abs());
    assert_eq!(server.json(0, &["reset", "--scope", "state"])["code"], code::OK);
    assert_eq!(client.snapshot().unwrap().snapshot.center_m, start.snapshot.center_m);
}

#[test]
fn numbers_are_listed_and_those_that_may_be_are_set_all_or_none() {
    let server = Serving::start(&["original", "--paused"]);
    let client = server.client();
    let start = client.snapshot().unwrap();
    let listed = server.json(0, &["parameters"]);
    let of = |listed: &Value, name: &str| {
        let all = listed["parameters"].as_array().unwrap();
        all.iter().find(|parameter| parameter["name"] == name).unwrap().clone()
    };
    assert_eq!(of(&listed, "restitution")["value"], 1.0);
    assert_eq!(of(&listed, "gravity_m_per_s2")["value"], json!([0.0, 0.0, -9.8]));
    assert_eq!(
        (of(&listed, "motion")["settable"].clone(), of(&listed, "tick_rate_hz")["value"].clone()),
        (json!(false), json!(60.0))
    );
    let plain = server.tool(&["parameters"]).stdout;
    assert!(plain.contains("steering.impulse_m_per_s") && plain.contains("may be set, 0 to 1"), "{plain}");

    done(&client, r#"{"cmd":"step","ticks":30}"#);
    let set =
        &["parameters", "set", "restitution=0.9", "gravity_m_per_s2=0,0,-1.62", "accuracy.tolerance_m=1e-9"];
    let reply = server.json(0, set);
    assert_eq!((reply["tick"].as_u64(), reply["epoch"].as_u64()), (Some(30), Some(start.snapshot.epoch + 1)));
    assert_eq!(of(&server.json(0, &["parameters"]), "restitution")["value"], 0.9);
    let world = client.snapshot().unwrap();
    assert_eq!((world.scene.restitution, world.scene.gravity_m_per_s2), (0.9, [0.0, 0.0, -1.62]));
    assert!((books(&world) - books(&start)).abs() < 1e-9 * books(&start).abs());
    assert_eq!(server.json(0, &["parameters", "set", "steering.impulse_m_per_s=0.25"])["code"], code::OK);
    let speed = |world: &World| {
        let [x, y, z] = world.snapshot.velocity_m_per_s[1];
        x.hypot(y).hypot(z)
    };
    done(&client, r#"{"cmd":"set_balls","balls":[{"name":"player","velocity_m_per_s":[0,0,0]}]}"#);
    done(&client, r#"{"cmd":"steer","direction":"up"}"#);
    let pushed = speed(&client.snapshot().unwrap());
    assert!(pushed > 0.1 && pushed <= 0.25, "{pushed}");

    let state = client.snapshot().unwrap().snapshot.state_hash;
    for (values, code, why) in [
        (r#"{"restitution":0.5,"motion":"frictionless"}"#, code::FEATURE_UNSUPPORTED, "motion: "),
        (r#"{"restitution":1.5}"#, code::OPERATION_FAILED, "restitution: use a number from 0 to 1"),
        (r#"{"restitution":0.5,"gravity_m_per_s2":[0,0,1]}"#, code::OPERATION_FAILED, "point down"),
        (r#"{"hit_budget":1.5}"#, code::OPERATION_FAILED, "whole"),
        (r#"{"accuracy.step_s":0.01}"#, code::NOT_FOUND, "accuracy.tolerance_m"),
        (r#"{"colour":"red"}"#, code::NOT_FOUND, "colour"),
    ] {
        refused(&client, &format!("{{\"cmd\":\"set_parameters\",\"values\":{values}}}"), code, why);
    }
    let after = client.snapshot().unwrap();
    assert_eq!((after.snapshot.state_hash, after.scene.restitution), (state, 0.9));
    assert_eq!(server.json(0, &["reset"])["code"], code::OK);
    assert_eq!(client.snapshot().unwrap().scene, start.scene);
}
