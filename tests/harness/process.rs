//! A program of this workspace, running; it cannot outlive its test.

use crate::wait::{PATIENCE, within};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Lines of one output kept; no test writes nearly as many.
const MAX_LINES: usize = 1_000_000;

/// Where cargo put a program: beside the directory of this test.
fn path_of(program: &str) -> PathBuf {
    let test = std::env::current_exe().expect("a test has a path");
    let beside = test.parent().and_then(|deps| deps.parent()).expect("target/<profile>/deps/test");
    let path = beside.join(program).with_extension(std::env::consts::EXE_EXTENSION);
    assert!(
        path.exists(),
        "{} is not built: `cargo test --release --workspace` builds it, `cargo build --release --workspace` does too",
        path.display()
    );
    path
}

/// Gives this thread, and those that it will begin, the processor before all others; whether that is permitted.
pub fn come_first() -> bool {
    let thread = nix::unistd::gettid().to_string();
    let mut command = Command::new("chrt");
    command.args(["--fifo", "--pid", "1", &thread]).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

/// What a program that has ended left behind.
pub struct Output {
    /// Its exit code; none when a signal ended it.
    pub code: Option<i32>,
    /// Its data.
    pub stdout: String,
    /// Its words.
    pub stderr: String,
}

/// Runs a program to its end.
pub fn run(program: &str, arguments: &[&str]) -> Output {
    Process::start(program, arguments).end(PATIENCE)
}

/// A running program; it is killed when this is dropped.
pub struct Process {
    name: String,
    child: Child,
    stdout: Lines,
    stderr: Lines,
}

impl Process {
    /// Starts a program of this workspace, without a terminal.
    pub fn start(program: &str, arguments: &[&str]) -> Self {
        let mut command = Command::new(path_of(program));
        command.args(arguments);
        Self::spawn(format!("{program} {}", arguments.join(" ")), command)
    }

    /// Starts a program that may write so many blocks of 512 bytes into a file; beyond that writing fails.
    pub fn start_limited(program: &str, arguments: &[&str], blocks: u32) -> Self {
        let mut command = Command::new("sh");
        let limited = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\"");
        command.args(["-c", &limited, "sh"]).arg(path_of(program)).args(arguments);
        Self::spawn(format!("{program} {}", arguments.join(" ")), command)
    }

    /// The same, but it gets only what processor time others leave: as good as on another machine.
    pub fn start_aside(program: &str, arguments: &[&str]) -> Self {
        Self::aside(&path_of(program), arguments)
    }

    /// The program that runs now, aside.
    pub fn start_again_aside(arguments: &[&str]) -> Self {
        Self::aside(&std::env::current_exe().expect("a program has a path"), arguments)
    }

    fn aside(program: &Path, arguments: &[&str]) -> Self {
        let mut command = Command::new("chrt");
        command.args(["--idle", "0"]).arg(program).args(arguments);
        Self::spawn(format!("{} {}", program.display(), arguments.join(" ")), command)
    }

    /// Starts any command, without a terminal or a screen.
    pub fn spawn(name: String, mut command: Command) -> Self {
        command
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("RUST_LOG")
            .env_remove("ZENOH_CONFIG")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let mut child = command.spawn().unwrap_or_else(|e| panic!("{name} cannot be started: {e}"));
        let stdout = Lines::of(child.stdout.take().expect("piped"));
        let stderr = Lines::of(child.stderr.take().expect("piped"));
        Self { name, child, stdout, stderr }
    }

    /// The first of stdout's lines in which something is found.
    pub fn said<T>(&self, patience: Duration, find: impl Fn(&str) -> Option<T>) -> T {
        self.wait_for(&self.stdout, patience, find)
    }

    /// The first of stderr's lines in which something is found.
    pub fn logged<T>(&self, patience: Duration, find: impl Fn(&str) -> Option<T>) -> T {
        self.wait_for(&self.stderr, patience, find)
    }

    /// How many lines stdout has had so far, and the last.
    pub fn last_said(&self) -> (usize, String) {
        let lines = self.stdout.lock();
        (lines.len(), lines.last().cloned().unwrap_or_default())
    }

    /// Everything it logged so far.
    pub fn words(&self) -> String {
        self.stderr.text()
    }

    /// Whether it has ended.
    pub fn has_ended(&mut self) -> bool {
        self.child.try_wait().is_ok_and(|status| status.is_some())
    }

    /// Sends a signal.
    pub fn signal(&self, signal: Signal) {
        kill(self.pid(), signal).unwrap_or_else(|e| panic!("{} {signal}: {e}", self.name));
    }

    /// Waits for the end and gives what is left of it.
    pub fn end(mut self, patience: Duration) -> Output {
        let (name, child) = (&self.name, &mut self.child);
        let ended = within(patience, || child.try_wait().unwrap_or_else(|e| panic!("{name}: {e}")));
        let status = ended.unwrap_or_else(|| self.give_up(patience, "its end"));
        Output { code: status.code(), stdout: self.stdout.all(), stderr: self.stderr.all() }
    }

    /// Ends it as a power cut would.
    pub fn kill(mut self) {
        self.stop();
    }

    fn pid(&self) -> Pid {
        Pid::from_raw(i32::try_from(self.child.id()).expect("a process id"))
    }

    fn wait_for<T>(&self, lines: &Lines, patience: Duration, find: impl Fn(&str) -> Option<T>) -> T {
        let mut seen = 0;
        let found = within(patience, || {
            let lines = lines.lock();
            let found = lines[seen..].iter().find_map(|line| find(line));
            seen = lines.len();
            found
        });
        found.unwrap_or_else(|| self.give_up(patience, "a line of it"))
    }

    fn give_up(&self, patience: Duration, what: &str) -> ! {
        panic!("{}: waited {patience:?} in vain for {what}; its log:\n{}", self.name, self.stderr.text())
    }

    fn stop(&mut self) {
        // It may have ended by itself.
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.stop();
    }
}

/// One output as it comes: read at once, because a full pipe would stop the writer.
struct Lines {
    lines: Arc<Mutex<Vec<String>>>,
    reader: Option<JoinHandle<()>>,
}

impl Lines {
    fn of(output: impl Read + Send + 'static) -> Self {
        let lines = Arc::<Mutex<Vec<String>>>::default();
        let kept = lines.clone();
        let reader = std::thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok).take(MAX_LINES) {
                kept.lock().unwrap_or_else(PoisonError::into_inner).push(line);
            }
        });
        Self { lines, reader: Some(reader) }
    }

    fn lock(&self) -> MutexGuard<'_, Vec<String>> {
        self.lines.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn text(&self) -> String {
        self.lock().iter().flat_map(|line| [line, "\n"]).collect()
    }

    /// Everything, once the writer has ended.
    fn all(&mut self) -> String {
        if let Some(reader) = self.reader.take() {
            reader.join().expect("reading does not panic");
        }
        self.text()
    }
}
