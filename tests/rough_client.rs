//! A client that nobody would want: `rough-client ENDPOINT presses|nonsense|questions|bytes`, until it is killed.
//!
//! | kind | what it does, as fast as it can with a breath of a millisecond |
//! |---|---|
//! | `presses` | twenty presses at once, for a ball there is not |
//! | `nonsense` | random bytes as commands, put and asked |
//! | `questions` | asks for the whole world and never reads an answer |
//! | `bytes` | connects without Zenoh and sends random bytes |

use ballroom_client::Client;
use std::io::Write;
use std::net::TcpStream;
use std::time::Duration;
use tests::{Noise, connect};
use zenoh::Wait;
use zenoh::qos::CongestionControl;

const BREATH: Duration = Duration::from_millis(1);

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [endpoint, kind] = &arguments[..] else { panic!("usage: rough-client ENDPOINT KIND") };
    let mut noise = Noise::new(u64::from(std::process::id()));
    if kind == "bytes" {
        return send_bytes(endpoint.trim_start_matches("tcp/"), &mut noise);
    }
    let client = connect(endpoint);
    println!("here");
    loop {
        match kind.as_str() {
            "presses" => (0..20).for_each(|_| put(&client, br#"{"key":"up","ball":"nobody"}"#)),
            "nonsense" => {
                let bytes = noise.bytes(200);
                put(&client, &bytes);
                drop(client.session().get(client.keys().srv_command()).payload(bytes).wait());
            }
            "questions" => drop(client.session().get(client.keys().srv_snapshot()).callback(|_| ()).wait()),
            other => panic!("no kind of rough client is named {other:?}"),
        }
        std::thread::sleep(BREATH);
    }
}

fn put(client: &Client, payload: &[u8]) {
    let key = client.keys().cmd(&"rough".parse().expect("a name"));
    // A link that is full or gone is what this is about.
    drop(client.session().put(key, payload).congestion_control(CongestionControl::Drop).wait());
}

fn send_bytes(address: &str, noise: &mut Noise) {
    println!("here");
    loop {
        if let Ok(mut stream) = TcpStream::connect(address) {
            while stream.write_all(&noise.bytes(1000)).is_ok() {
                std::thread::sleep(BREATH);
            }
        }
        std::thread::sleep(BREATH);
    }
}
