//! What is counted in the program that callgrind runs.

use crate::callgrind::INSIDE;
use std::hint::black_box;

/// Runs `work`, which does something `times` times, and has its instructions counted.
pub fn count<T>(name: &str, times: u64, work: impl FnOnce() -> T) {
    black_box(gauge(work));
    println!("{name},{times}");
}

/// Callgrind knows it by its name: it collects while this runs and writes a sum when it returns.
#[inline(never)]
fn gauge<T>(work: impl FnOnce() -> T) -> T {
    black_box(black_box(work)())
}

/// Whether this is the copy that is counted.
pub fn is_counted() -> bool {
    std::env::var_os(INSIDE).is_some()
}
