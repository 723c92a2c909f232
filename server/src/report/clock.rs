//! CPU time of a piece of work.

use cpu_time::ProcessTime;

/// How CPU time is measured, in words for the page.
pub const HOW: &str = "CPU time is the process's own (all its threads, user and system), of stepping only. A run is \
     repeated until its repetitions take 20 ms or more; of several such batches the least counts, because other work \
     on the machine only ever adds.";

/// CPU seconds that the repetitions of one batch take at least.
const BATCH_S: f64 = 0.02;
/// Batches, of which the least counts.
const BATCHES: usize = 3;
/// CPU seconds after which no further batch is begun.
const PATIENCE_S: f64 = 3.0;
/// Repetitions made ready at once: each is a world of its own.
const READY_MAX: usize = 64;

/// What a piece of work costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// CPU seconds of one repetition: the least of several batches.
    pub seconds: f64,
    /// Repetitions in all.
    pub repetitions: u64,
}

/// CPU seconds of one `run` of what `prepare` makes ready; preparing is not counted.
pub fn cost<T>(mut prepare: impl FnMut() -> T, mut run: impl FnMut(&mut T)) -> Cost {
    let (mut least, mut repetitions, mut spent) = (f64::INFINITY, 0, 0.0);
    for _ in 0..BATCHES {
        let (mut batch, mut count) = (0.0, 0_u64);
        let mut ready_next = 1;
        while batch < BATCH_S {
            let mut ready: Vec<T> = (0..ready_next).map(|_| prepare()).collect();
            let start = ProcessTime::now();
            ready.iter_mut().for_each(&mut run);
            batch += start.elapsed().as_secs_f64();
            count += ready.len() as u64;
            ready_next = (2 * ready_next).min(READY_MAX);
        }
        least = least.min(batch / count as f64);
        repetitions += count;
        spent += batch;
        if spent > PATIENCE_S {
            break;
        }
    }
    Cost { seconds: least, repetitions }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::hint::black_box;

    #[test]
    fn preparing_is_not_counted_and_runs_are_fresh() {
        let mut made = 0_u64;
        let cost = cost(
            || {
                made += 1;
                vec![0_u64; 10_000]
            },
            |numbers| {
                assert!(numbers.iter().all(|&n| n == 0), "each run has its own");
                numbers.fill(black_box(1));
            },
        );
        assert_eq!(made, cost.repetitions);
        assert!(cost.seconds > 0.0 && cost.seconds.is_finite());
    }
}
