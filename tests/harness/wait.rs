//! Waiting with a bound, and taking turns.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How long anything may take for which no claim says how long: far more than it does on a busy machine.
pub const PATIENCE: Duration = Duration::from_mins(1);

/// One test at a time: servers that share two cores disturb each other's clocks.
static TURN: Mutex<()> = Mutex::new(());

/// Waits for the tests before.
pub fn turn() -> MutexGuard<'static, ()> {
    // A test that failed says so itself; it is over for the next.
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Probes until there is something, and panics when nothing has come within `patience`.
pub fn until<T>(what: &str, patience: Duration, probe: impl FnMut() -> Option<T>) -> T {
    within(patience, probe).unwrap_or_else(|| panic!("waited {patience:?} in vain for {what}"))
}

/// Probes until there is something; none when nothing has come within `patience`.
pub fn within<T>(patience: Duration, mut probe: impl FnMut() -> Option<T>) -> Option<T> {
    let deadline = Instant::now() + patience;
    loop {
        let found = probe();
        if found.is_some() || Instant::now() > deadline {
            return found;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// For claims about time, which a machine that is busy with something else can spoil: true in one of three tries.
/// Every try prints what it measured.
pub fn in_one_of_three_tries(claim: impl Fn() -> Result<(), String>) {
    let tried = std::iter::repeat_with(claim).take(3).map(|held| held.inspect_err(|why| println!("{why}")));
    let faults: Vec<String> = tried.map_while(Result::err).collect();
    assert!(faults.len() < 3, "three times: {faults:?}");
}
