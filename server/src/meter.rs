//! How long ticks take, counted without allocating.

use std::time::{Duration, Instant};

/// Ticks a second whose times are kept; of more, the first ones speak for the rest.
const SAMPLES: usize = 8192;

/// Times of the ticks of the running second.
pub struct Meter {
    began: Instant,
    /// The rate is taken from the end of a tick to the end of a tick: a second holds no whole number of them.
    rated_from: Instant,
    last_tick: Instant,
    ticks: u64,
    ticks_per_s: f64,
    micros: Vec<f64>,
    overruns: u64,
}

/// What a second was like.
pub struct Figures {
    /// Ticks made over the time they took, pauses included.
    pub ticks_per_s: f64,
    /// Median, 99th percentile, largest.
    pub tick_micros: [f64; 3],
    /// Ticks past their deadline so far.
    pub overruns: u64,
}

impl Default for Meter {
    fn default() -> Self {
        Self::new()
    }
}

impl Meter {
    /// Begins a second.
    pub fn new() -> Self {
        let now = Instant::now();
        Self {
            began: now,
            rated_from: now,
            last_tick: now,
            ticks: 0,
            ticks_per_s: 0.0,
            micros: Vec::with_capacity(SAMPLES),
            overruns: 0,
        }
    }

    /// A tick took this long.
    pub fn record(&mut self, took: Duration) {
        self.ticks += 1;
        self.last_tick = Instant::now();
        if self.micros.len() < SAMPLES {
            self.micros.push(took.as_secs_f64() * 1e6);
        }
    }

    /// A tick ended after its deadline.
    pub const fn count_overrun(&mut self) {
        self.overruns += 1;
    }

    /// The figures of the second that is over, if one is. While the clock runs, a second without a tick keeps the rate
    /// of the one before; while it stands, it has none.
    pub fn each_second(&mut self, running: bool) -> Option<Figures> {
        let length = self.began.elapsed();
        if length < Duration::from_secs(1) {
            return None;
        }
        self.micros.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| {
            let last = self.micros.len().saturating_sub(1);
            self.micros.get((share * last as f64).round() as usize).copied().unwrap_or(0.0)
        };
        let rated_to = if running { self.last_tick } else { Instant::now() };
        if self.ticks > 0 || !running {
            self.ticks_per_s = self.ticks as f64 / (rated_to - self.rated_from).as_secs_f64();
            self.rated_from = rated_to;
        }
        let figures = Figures {
            ticks_per_s: self.ticks_per_s,
            tick_micros: [at(0.5), at(0.99), at(1.0)],
            overruns: self.overruns,
        };
        self.micros.clear();
        self.ticks = 0;
        self.began = Instant::now();
        Some(figures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_is_that_of_the_ticks_and_zero_when_the_clock_stands() {
        let mut meter = Meter::new();
        for _ in 0..21 {
            std::thread::sleep(Duration::from_millis(50));
            meter.record(Duration::from_millis(1));
        }
        let took = meter.last_tick - meter.rated_from;
        let figures = meter.each_second(true).unwrap();
        assert!((figures.ticks_per_s * took.as_secs_f64() - 21.0).abs() < 1e-9);
        assert_eq!(figures.tick_micros, [1000.0; 3]);
        assert!(meter.each_second(true).is_none());
        std::thread::sleep(Duration::from_secs(1));
        assert_eq!(meter.each_second(false).unwrap().ticks_per_s, 0.0);
    }
}
