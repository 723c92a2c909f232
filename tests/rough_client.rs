//! A client that nobody would want: `rough-client ENDPOINT presses|nonsense|questions|bytes|slow|reads`, until it is killed.
//!
//! | kind | what it does, the first four as fast as they can with a breath of a millisecond |
//! |---|---|
//! | `presses` | twenty presses at once, for a ball there is not |
//! | `nonsense` | random bytes as commands, put and asked |
//! | `questions` | asks for the whole world and never reads an answer |
//! | `bytes` | connects without Zenoh and sends random bytes |
//! | `slow` | takes a tenth of a second for a state, and what comes meanwhile stays in the link |
//! | `reads` | asks for the world and reads its states, as viewers do: what is rough is what is done to it |
//!
//! It says `here` once it does so.

use ballroom_client::Client;
use std::io::Write;
use std::net::TcpStream;
use std::time::Duration;
use tests::{Noise, connect};
use zenoh::Wait;
use zenoh::qos::CongestionControl;

const BREATH: Duration = Duration::from_millis(1);
/// What a slow one takes for a state.
const SLOWNESS: Duration = Duration::from_millis(100);

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [endpoint, kind] = &arguments[..] else { panic!("usage: rough-client ENDPOINT KIND") };
    let mut noise = Noise::new(u64::from(std::process::id()));
    if kind == "bytes" {
        return send_bytes(endpoint.trim_start_matches("tcp/"), &mut noise);
    }
    let client = connect(endpoint);
    match kind.as_str() {
        "reads" => return read(&client),
        "slow" => return read_slowly(&client),
        _ => println!("here"),
    }
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

fn read(client: &Client) {
    for (number, _) in client.follow().expect("a server").enumerate() {
        if number == 0 {
            println!("here");
        }
    }
}

fn read_slowly(client: &Client) {
    let states = client.session().declare_subscriber(client.keys().state());
    // On the thread that reads the link.
    let _states = states.callback(|_| std::thread::sleep(SLOWNESS)).wait().expect("a session");
    println!("here");
    loop {
        std::thread::park();
    }
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
