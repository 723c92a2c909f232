//! `ballroom serve` as a process, for tools to talk to.

use super::{Output, PATIENCE, ballroom};
use ballroom_client::{Client, ClientOptions, Patience};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

/// A server that ends with its test.
pub struct Serving {
    process: Child,
    endpoint: String,
}

impl Serving {
    /// Serves on a free port.
    pub fn start(arguments: &[&str]) -> Self {
        Self::run(&[&["serve"], arguments].concat()).0
    }

    /// Runs a subcommand that serves on a free port; the rest of what it says comes with it.
    pub fn run(arguments: &[&str]) -> (Self, BufReader<ChildStdout>) {
        let mut process = Command::new(env!("CARGO_BIN_EXE_ballroom"))
            .args(arguments)
            .args(["-l", "tcp/127.0.0.1:0"])
            .env_remove("RUST_LOG")
            .env_remove("ZENOH_CONFIG")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut endpoint = String::new();
        let mut stdout = BufReader::new(process.stdout.take().unwrap());
        stdout.read_line(&mut endpoint).unwrap();
        assert!(endpoint.starts_with("tcp/"), "{endpoint:?}");
        (Self { process, endpoint: endpoint.trim_end().to_owned() }, stdout)
    }

    /// Ends it as a power cut would.
    pub fn kill(mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }

    /// Where it listens.
    pub fn endpoint(&self) -> &str {
        &self.endpoint
    }

    /// Runs a subcommand against it.
    pub fn tool(&self, arguments: &[&str]) -> Output {
        ballroom(&[arguments, &["-e", &self.endpoint]].concat())
    }

    /// What a subcommand with `--json` answers; its exit code must be the one given.
    pub fn json(&self, code: i32, arguments: &[&str]) -> Value {
        let output = self.tool(&[arguments, &["--json"]].concat());
        assert_eq!(output.code, code, "{arguments:?}: {}{}", output.stdout, output.stderr);
        serde_json::from_str(&output.stdout)
            .unwrap_or_else(|e| panic!("{arguments:?}: {e}: {}", output.stdout))
    }

    /// Ends it as Ctrl-C does; whether it ended well.
    pub fn end_in_order(mut self) -> bool {
        let pid = self.process.id().to_string();
        assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
        self.process.wait().unwrap().success()
    }

    /// A session with its arena `main`.
    pub fn client(&self) -> Client {
        self.client_of(protocol::keys::DEFAULT_ARENA)
    }

    /// How it ended, once it has.
    pub fn ended(&mut self) -> i32 {
        let deadline = Instant::now() + PATIENCE;
        loop {
            if let Some(status) = self.process.try_wait().unwrap() {
                return status.code().expect("ended by itself");
            }
            assert!(Instant::now() < deadline, "it did not end within {PATIENCE:?}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// A session with one of its arenas.
    pub fn client_of(&self, arena: &str) -> Client {
        Client::open(self.options_of(arena)).unwrap()
    }

    /// How to reach one of its arenas.
    pub fn options_of(&self, arena: &str) -> ClientOptions {
        ClientOptions {
            arena: arena.parse().unwrap(),
            endpoints: vec![self.endpoint.clone()],
            patience: Patience::GiveUpAfter(PATIENCE),
            timeout: PATIENCE,
            ..ClientOptions::default()
        }
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
