//! What both programs promise the shell, as far as no server is needed.

use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

const VIEWER: &str = env!("CARGO_BIN_EXE_ballroom-viewer");
const DEMO: &str = env!("CARGO_BIN_EXE_ballroom-demo");

/// Runs a program that ends by itself and writes less than a pipe holds.
fn run(program: &str, arguments: &[&str]) -> Output {
    let mut child = Command::new(program)
        .args(arguments)
        .env_remove("RUST_LOG")
        .env_remove("ZENOH_CONFIG")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let deadline = Instant::now() + Duration::from_secs(30);
    while child.try_wait().unwrap().is_none() {
        if Instant::now() > deadline {
            child.kill().unwrap();
            panic!("{program} {arguments:?} does not end");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn help_shows_examples_and_exit_codes() {
    for program in [VIEWER, DEMO] {
        let output = run(program, &["--help"]);
        let help = String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(0));
        assert!(help.contains("Examples:") && help.contains("Exit codes:"), "{help}");
    }
}

#[test]
fn wrong_usage_ends_with_2() {
    for (program, arguments) in [
        (VIEWER, &["--fps", "0"][..]),
        (VIEWER, &["--arena", "a/b"]),
        // A viewer that shows nothing and keeps nothing is a mistake.
        (VIEWER, &["--no-viewer"]),
        (VIEWER, &["--no-viewer", "--listen", "0.0.0.0", "--save", "ride.rrd"]),
        // A server's endpoint is no viewer.
        (VIEWER, &["--connect", "tcp/127.0.0.1:7447"]),
        (VIEWER, &["--view", "moon"]),
        (DEMO, &["--view", "moon"]),
        (DEMO, &["--rate", "1001"]),
        (DEMO, &["--for", "-1"]),
    ] {
        assert_eq!(run(program, arguments).status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn a_recording_that_cannot_be_written_is_named_at_once() {
    let path = "/nowhere/at/all.rrd";
    for (program, arguments) in [
        (VIEWER, &["-e", "tcp/127.0.0.1:1", "--no-viewer", "--save", path][..]),
        (DEMO, &["--no-viewer", "--save", path]),
    ] {
        let output = run(program, arguments);
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        assert!(stderr(&output).contains(path), "{}", stderr(&output));
    }
}

#[test]
fn the_demo_names_a_scene_it_does_not_know() {
    let output = run(DEMO, &["moon", "--no-viewer"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("moon: no built-in scene has this name"), "{}", stderr(&output));
}
