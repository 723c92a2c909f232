//! Zenoh's threads, as many as a server needs.
//!
//! | threads | of the usual | who holds one |
//! |---|---|---|
//! | reading | 2 | a link that is closed: its reader lingers for ten seconds if the client stopped reading |
//! | sending | 1 | a link that is closed: its sender waits for the state that waits for room in it |
//! | resting | 50 | a link that has sent what was refused: another thread reads the rest |
//! | waiting | 50 | a link that is full: a state waits for room in it |
//!
//! Of the usual, one or two clients that stop reading take all, and nobody is heard or served. Only an environment variable
//! tells Zenoh to have more, and a running program cannot safely set its own.

use super::session::MAX_SESSIONS;

/// What Zenoh reads when its first session opens.
const VARIABLE: &str = "ZENOH_RUNTIME";
/// One for each client that may be given up at once, and the usual ones.
const READING_THREADS: usize = MAX_SESSIONS + 2;
const SENDING_THREADS: usize = MAX_SESSIONS + 1;
/// Links that rest, or states that wait. These begin only when there is need.
const BLOCKED_THREADS: usize = MAX_SESSIONS + 50;

/// The value of the variable.
fn enough() -> String {
    format!(
        "(rx: (worker_threads: {READING_THREADS}, max_blocking_threads: {BLOCKED_THREADS}), \
         tx: (worker_threads: {SENDING_THREADS}), \
         net: (max_blocking_threads: {BLOCKED_THREADS}))"
    )
}

/// To be called first in a program that serves others: begins it again as the same process with enough threads.
/// Returns at once when the variable is set already, and when there is nothing that can be begun again.
#[cfg(unix)]
pub fn begin_with_enough_threads() {
    use std::os::unix::process::CommandExt;
    if std::env::var_os(VARIABLE).is_some() {
        return;
    }
    let mut arguments = std::env::args_os();
    let name = arguments.next().unwrap_or_default();
    let why = std::env::current_exe().map(|program| {
        std::process::Command::new(program).arg0(name).args(arguments).env(VARIABLE, enough()).exec()
    });
    let (Ok(why) | Err(why)) = why;
    tracing::warn!("clients that stop reading may hold up others: set {VARIABLE} by hand ({why})");
}

/// Elsewhere a program cannot begin again as the same process.
#[cfg(not(unix))]
pub fn begin_with_enough_threads() {
    if std::env::var_os(VARIABLE).is_none() {
        tracing::warn!("clients that stop reading may hold up others: set {VARIABLE} to {}", enough());
    }
}
