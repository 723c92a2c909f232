//! A program in a terminal of its own: `script` of util-linux keeps the other side of a real pseudo-terminal.

use super::PATIENCE;
use std::io::{Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// What a pad writes before each picture: everything below is cleared.
const CLEARED: &str = "\u{1b}[J";

/// A terminal of 100 columns and 30 rows with `ballroom` in it.
pub struct Terminal {
    script: Child,
    keys: ChildStdin,
    written: Arc<Mutex<Vec<u8>>>,
}

impl Terminal {
    /// Starts `ballroom` in a terminal; what is said of the terminal once it has ended follows.
    pub fn start(arguments: &[&str]) -> Self {
        let program = env!("CARGO_BIN_EXE_ballroom");
        let line = format!(
            "stty rows 30 cols 100; sh -c 'echo \"pid $$.\"; exec {program} {}'; echo \"code $?.\"; stty -a; echo over",
            arguments.join(" ")
        );
        let mut script = Command::new("script")
            .args(["-q", "-e", "-c", &line, "/dev/null"])
            .env_remove("RUST_LOG")
            .env_remove("ZENOH_CONFIG")
            .env("SHELL", "/bin/sh")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("script of util-linux");
        let keys = script.stdin.take().unwrap();
        let mut output = script.stdout.take().unwrap();
        let written = Arc::<Mutex<Vec<u8>>>::default();
        let kept = written.clone();
        std::thread::spawn(move || {
            let mut buffer = [0; 4096];
            while let Ok(count @ 1..) = output.read(&mut buffer) {
                kept.lock().unwrap().extend_from_slice(&buffer[..count]);
            }
        });
        Self { script, keys, written }
    }

    /// Types.
    pub fn press(&mut self, keys: &str) {
        self.keys.write_all(keys.as_bytes()).unwrap();
        self.keys.flush().unwrap();
    }

    /// Everything that was written so far.
    pub fn written(&self) -> String {
        String::from_utf8_lossy(&self.written.lock().unwrap()).into_owned()
    }

    /// Waits until something is found in all that was written.
    pub fn finds<T>(&self, what: &str, find: impl Fn(&str) -> Option<T>) -> T {
        let deadline = Instant::now() + PATIENCE;
        loop {
            if let Some(found) = find(&self.written()) {
                return found;
            }
            assert!(Instant::now() < deadline, "waited in vain for {what}:\n{}", self.written());
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Waits until the last whole picture shows something.
    pub fn shows(&self, what: &str) {
        self.finds(what, |written| {
            let (_, picture) = written.rsplit_once(CLEARED)?;
            picture.contains(what).then_some(())
        });
    }

    /// Sends a signal to the program.
    pub fn signal(&self, signal: &str) {
        let pid = self.finds("its process id", |written| {
            let (_, rest) = written.split_once("pid ")?;
            Some(rest.split_once('.')?.0.to_owned())
        });
        assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
    }

    /// The program's exit code, and how the terminal was left.
    pub fn end(self) -> (i32, String) {
        self.finds("its end", |written| {
            let (_, rest) = written.rsplit_once("code ")?;
            let (code, terminal) = rest.split_once('.')?;
            terminal.contains("over").then(|| (code.parse().unwrap(), terminal.to_owned()))
        })
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.script.kill();
        let _ = self.script.wait();
    }
}
