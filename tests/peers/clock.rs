//! CPU time of stepping, measured alike for every contestant.

use cpu_time::ProcessTime;

/// The least CPU time of several runs, s. Each run is a fresh world, made outside the clock; runs are repeated until
/// `at_least` seconds are measured, `RUNS` at the least unless one alone takes that long.
pub fn least<W>(at_least: f64, mut make: impl FnMut() -> W, mut ride: impl FnMut(&mut W)) -> f64 {
    const RUNS: u32 = 3;
    const MOST: u32 = 10_000;
    let (mut best, mut sum) = (f64::INFINITY, 0.0);
    for run in 0..MOST {
        let mut world = make();
        let start = ProcessTime::now();
        ride(&mut world);
        let spent = start.elapsed().as_secs_f64();
        best = best.min(spent);
        sum += spent;
        if sum >= at_least && (run + 1 >= RUNS || spent >= at_least) {
            break;
        }
    }
    best
}
