//! How long ticks take, counted without allocating.

use std::time::{Duration, Instant};

/// Ticks a second whose times are kept; of more, the first ones speak for the rest.
const SAMPLES: usize = 8192;

/// Times of the ticks of the running second.
pub struct Meter {
    began: Instant,
    ticks: u64,
    micros: Vec<f64>,
    overruns: u64,
}

/// What a second was like.
pub struct Figures {
    /// Ticks made, over the second's true length.
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
        Self { began: Instant::now(), ticks: 0, micros: Vec::with_capacity(SAMPLES), overruns: 0 }
    }

    /// A tick took this long.
    pub fn record(&mut self, took: Duration) {
        self.ticks += 1;
        if self.micros.len() < SAMPLES {
            self.micros.push(took.as_secs_f64() * 1e6);
        }
    }

    /// A tick ended after its deadline.
    pub const fn count_overrun(&mut self) {
        self.overruns += 1;
    }

    /// The figures of the second that is over, if one is.
    pub fn each_second(&mut self) -> Option<Figures> {
        let length = self.began.elapsed();
        if length < Duration::from_secs(1) {
            return None;
        }
        self.micros.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| {
            let last = self.micros.len().saturating_sub(1);
            self.micros.get((share * last as f64).round() as usize).copied().unwrap_or(0.0)
        };
        let figures = Figures {
            ticks_per_s: self.ticks as f64 / length.as_secs_f64(),
            tick_micros: [at(0.5), at(0.99), at(1.0)],
            overruns: self.overruns,
        };
        self.micros.clear();
        self.ticks = 0;
        self.began = Instant::now();
        Some(figures)
    }
}
