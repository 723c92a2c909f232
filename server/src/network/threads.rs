//! Threads that read for Zenoh, as many as a server needs.
//!
//! Zenoh closes a TCP link on the thread that reads it, with ten seconds of linger: a client that stopped reading, and is
//! given up, holds that thread for as long. Of the usual two, two such clients take both, and nobody is heard. Only an
//! environment variable tells Zenoh to have more, and a running program cannot safely set its own.

use super::session::MAX_SESSIONS;

/// What Zenoh reads when its first session opens.
const VARIABLE: &str = "ZENOH_RUNTIME";
/// One for each client that may be given up at once, and the usual two.
const READING_THREADS: usize = MAX_SESSIONS + 2;

/// To be called first in a program that serves others: begins it again as the same process with enough reading threads.
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
        std::process::Command::new(program)
            .arg0(name)
            .args(arguments)
            .env(VARIABLE, format!("(rx: (worker_threads: {READING_THREADS}))"))
            .exec()
    });
    let (Ok(why) | Err(why)) = why;
    tracing::warn!("clients that stop reading may hold up others: set {VARIABLE} by hand ({why})");
}

/// Elsewhere a program cannot begin again as the same process.
#[cfg(not(unix))]
pub fn begin_with_enough_threads() {
    if std::env::var_os(VARIABLE).is_none() {
        tracing::warn!(
            "clients that stop reading may hold up others: set {VARIABLE} to (rx: (worker_threads: {READING_THREADS}))"
        );
    }
}
