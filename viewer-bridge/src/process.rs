//! What both programs owe the shell that runs them: logs on stderr, and an end that comes when asked for.

use ballroom_client::Abort;
use std::io::{self, IsTerminal};
use std::sync::mpsc::channel;
use std::time::Duration;
use tracing_subscriber::EnvFilter;
use tracing_subscriber::fmt::MakeWriter;

/// How long a session may take to say goodbye.
pub const CLOSE_PATIENCE: Duration = Duration::from_secs(1);
/// Exit code after a second signal, as a shell reports an interrupted program.
const ENDED_AT_ONCE: i32 = 130;
/// What is told when `RUST_LOG` says nothing: our own words, and others' worries; Zenoh worries at every attempt to
/// reach a server that is not there yet.
const DEFAULT_FILTER: &str = "warn,zenoh=error,viewer_bridge=info,ballroom_viewer=info,ballroom_demo=info,\
                              ballroom_client=info,server=info";

/// Logs to stderr, as `RUST_LOG` says.
pub fn log_to_stderr() {
    log_to(io::stderr);
}

/// Logs to any writer, as `RUST_LOG` says.
pub fn log_to(writer: impl for<'a> MakeWriter<'a> + Send + Sync + 'static) {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(DEFAULT_FILTER));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_target(false)
        .with_ansi(io::stderr().is_terminal())
        .with_writer(writer)
        .init();
}

/// Throws the switch at SIGINT, SIGTERM or SIGHUP. If it was thrown before, calls `last` and ends at once.
pub fn on_signal(abort: Abort, last: impl Fn() + Send + 'static) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(move || {
        if abort.is_aborted() {
            last();
            std::process::exit(ENDED_AT_ONCE);
        }
        abort.abort();
    })
}

/// Runs `task` on a thread of its own and waits for it at most `patience`; then it is left behind. None if it was.
pub fn within<T: Send + 'static>(patience: Duration, task: impl FnOnce() -> T + Send + 'static) -> Option<T> {
    let (finished, done) = channel();
    let thread = std::thread::Builder::new().spawn(move || finished.send(task()).ok());
    thread.ok()?;
    done.recv_timeout(patience).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    fn a_task_that_hangs_is_left_behind() {
        let began = Instant::now();
        assert_eq!(within(Duration::from_millis(20), || std::thread::sleep(Duration::from_secs(5))), None);
        assert!(began.elapsed() < Duration::from_secs(1));
        assert_eq!(within(Duration::from_secs(5), || 7), Some(7));
    }
}
