//! Input that no honest client sends.

use crate::states::done;
use ballroom_client::Client;
use protocol::command::{Command, Reply};
use std::time::Duration;
use tests::{Noise, PATIENCE, Server, simulate, turn, until};
use zenoh::Wait;
use zenoh::qos::CongestionControl;

/// Texts that look like commands and are none.
const NONSENSE: [&str; 26] = [
    "",
    "up",
    "null",
    "[]",
    "{}",
    "NaN",
    "{\"cmd\":",
    r#"{"cmd":"fly"}"#,
    r#"{"cmd":"PAUSE"}"#,
    r#"{"cmd":"pause","now":true}"#,
    r#"{"cmd":"pause","cmd":"resume"}"#,
    r#"{"cmd":"pause"}{"cmd":"pause"}"#,
    r#"{"key":"sideways"}"#,
    r#"{"key":"up","down":"yes"}"#,
    r#"{"cmd":"step","ticks":-1}"#,
    r#"{"cmd":"step","ticks":1e300}"#,
    r#"{"cmd":"step","ticks":18446744073709551616}"#,
    r#"{"cmd":"speed","factor":NaN}"#,
    r#"{"cmd":"speed","factor":Infinity}"#,
    r#"{"cmd":"speed","factor":1e999}"#,
    r#"{"cmd":"speed","factor":-1}"#,
    r#"{"cmd":"steer","direction":[NaN,0]}"#,
    r#"{"cmd":"steer","direction":[1e308,1e308]}"#,
    r#"{"cmd":"steer","direction":[0,0,1]}"#,
    r#"{"cmd":"steer","direction":"up","ball":"nobody"}"#,
    r#"{"cmd":"steer","direction":"up","ball":"red"}"#,
];

/// Everything that is thrown at the server, none of it a command.
fn junk() -> Vec<Vec<u8>> {
    let mut noise = Noise::new(0x2016);
    let mut junk: Vec<Vec<u8>> = NONSENSE.iter().map(|text| text.as_bytes().to_vec()).collect();
    junk.extend((0..40).map(|i| noise.bytes(i * 13)));
    // Deep, long, and far too long; the first would be a command if it were shorter.
    junk.push("[".repeat(512).into_bytes());
    junk.push(format!("{{\"cmd\":\"pause\"{}}}", " ".repeat(512)).into_bytes());
    junk.extend([513, 65_536, 900_000].map(|length| noise.bytes(length)));
    junk
}

fn put(client: &Client, key: &str, payload: &[u8]) {
    // Blocking, so that all of it arrives and can be counted.
    client.session().put(key, payload).congestion_control(CongestionControl::Block).wait().unwrap();
}

/// A question as raw bytes, and its raw answer.
fn ask(client: &Client, key: &str, payload: Option<&[u8]>) -> Result<Vec<u8>, String> {
    let mut question = client.session().get(key).timeout(PATIENCE);
    if let Some(payload) = payload {
        question = question.payload(payload);
    }
    let reply = question.wait().unwrap().recv_timeout(PATIENCE).unwrap().expect("an answer");
    match reply.into_result() {
        Ok(sample) => Ok(sample.payload().to_bytes().into_owned()),
        Err(error) => Err(error.payload().try_to_string().unwrap().into_owned()),
    }
}

fn hash_at(client: &Client, tick: u64) -> String {
    let reply = done(client, &Command::Step { ticks: tick - client.snapshot().unwrap().snapshot.tick });
    let snapshot = client.snapshot().unwrap().snapshot;
    assert_eq!((snapshot.tick, reply.tick), (tick, tick));
    format!("{:016x}", snapshot.state_hash)
}

#[test]
fn malformed_oversized_and_unknown_input_leaves_the_state_equal_to_an_undisturbed_twin() {
    let _turn = turn();
    let twin = simulate("original", 3);
    let server = Server::start(&["original", "--paused"]);
    let client = server.client();
    let keys = client.keys().clone();
    assert_eq!(hash_at(&client, 30), twin[30].state_hash);

    let mut refused = 0;
    for bytes in junk() {
        put(&client, &keys.cmd(&"junk".parse().unwrap()), &bytes);
        refused += 1;
        let reply: Reply =
            serde_json::from_slice(&ask(&client, &keys.srv_command(), Some(&bytes)).unwrap()).unwrap();
        assert!(!reply.ok && !reply.error.is_empty(), "{reply:?} to {}", String::from_utf8_lossy(&bytes));
        refused += 1;
    }
    // A command without content, a player without a name, a deleted key.
    assert!(
        String::from_utf8(ask(&client, &keys.srv_command(), None).unwrap()).unwrap().contains("\"ok\":false")
    );
    put(&client, "ballroom/v1/main/cmd/NOBODY", br#"{"key":"up"}"#);
    client.session().delete(keys.cmd(&"junk".parse().unwrap())).wait().unwrap();
    refused += 3;
    // Questions with nonsense beside them are answered or refused with a reason.
    let why = ask(&client, &format!("{}?format=xml", keys.srv_snapshot()), None).unwrap_err();
    assert!(why.contains("use cbor or json"), "{why}");
    refused += 1;
    ask(&client, &keys.srv_scene(), Some(&[0xff; 100])).unwrap();
    // Keys that only the server speaks under.
    for key in [keys.state(), keys.event(), keys.stats(), keys.meta_scene()] {
        put(&client, &key, &[0xa1; 1000]);
    }

    until("all of it to be counted", PATIENCE, || {
        (client.stats().unwrap().commands_refused == refused).then_some(())
    });
    // The one step above.
    assert_eq!(client.stats().unwrap().commands_accepted, 1);
    assert_eq!(hash_at(&client, 120), twin[120].state_hash);
    assert_eq!(client.snapshot().unwrap().snapshot.collisions, twin[120].collisions);
}

#[test]
fn a_message_too_long_for_the_server_costs_only_its_sender() {
    let _turn = turn();
    let twin = simulate("original", 1);
    let server = Server::start(&["original", "--paused"]);
    let client = server.client();
    assert_eq!(hash_at(&client, 30), twin[30].state_hash);
    let hostile = server.client();
    put(&hostile, &hostile.keys().cmd(&"junk".parse().unwrap()), &vec![b' '; 8 << 20]);
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!(hash_at(&client, 60), twin[60].state_hash);
}

#[test]
fn too_many_commands_from_one_player_are_refused_and_another_is_heard() {
    let _turn = turn();
    let server = Server::start(&["plane", "--paused"]);
    let client = server.client();
    for _ in 0..400 {
        put(&client, &client.keys().cmd(&"greedy".parse().unwrap()), br#"{"key":"stop"}"#);
    }
    let counts = until("all of them to be counted", PATIENCE, || {
        let stats = client.stats().unwrap();
        (stats.commands_accepted + stats.commands_refused == 400).then_some(stats)
    });
    assert!(counts.commands_refused >= 100, "{counts:?}");
    done(&client, &Command::Step { ticks: 1 });
}
