//! What the program promises the shell: output, exit codes, refusals, and over a session what each verb does.

mod arenas;
mod changing;
mod check;
mod control;
mod hardcases;
mod players;
mod readers;
mod relay;
mod reload;
mod report;
mod serving;
mod simulate;
mod terminal;
mod timeline;
mod usage;

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Far more than anything here takes.
const PATIENCE: Duration = Duration::from_mins(1);

/// What a run left behind.
struct Output {
    code: i32,
    stdout: String,
    stderr: String,
}

/// Runs `ballroom` to its end. Output goes through files: a full pipe would stop it.
fn ballroom(arguments: &[&str]) -> Output {
    let directory = tempfile::tempdir().unwrap();
    let [out, err] = ["out", "err"].map(|name| directory.path().join(name));
    let mut child = Command::new(env!("CARGO_BIN_EXE_ballroom"))
        .args(arguments)
        .env_remove("RUST_LOG")
        .env_remove("ZENOH_CONFIG")
        .stdin(Stdio::null())
        .stdout(File::create(&out).unwrap())
        .stderr(File::create(&err).unwrap())
        .spawn()
        .unwrap();
    let deadline = Instant::now() + PATIENCE;
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if Instant::now() > deadline {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("ballroom {} did not end within {PATIENCE:?}", arguments.join(" "));
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let read = |path: &Path| std::fs::read_to_string(path).unwrap();
    let code = status.code().expect("ended by itself");
    Output { code, stdout: read(&out), stderr: read(&err) }
}

/// The standard output of a run that must succeed without a word on stderr.
fn said(arguments: &[&str]) -> String {
    let Output { code, stdout, stderr } = ballroom(arguments);
    assert!(code == 0 && stderr.is_empty(), "ballroom {}: {code}, {stderr}", arguments.join(" "));
    stdout
}

/// The scenes that come with the program, by name.
fn built_in_scenes() -> Vec<String> {
    let scenes = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes")).unwrap();
    let stem = |entry: std::io::Result<std::fs::DirEntry>| {
        entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned()
    };
    scenes.map(stem).collect()
}
