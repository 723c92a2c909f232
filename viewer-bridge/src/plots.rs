//! Numbers over time: energy, hits, tick time, speed, and what the bridge itself received, showed and dropped.

use crate::recording::Recording;
use crate::slot::Counts;
use protocol::snapshot::{Collisions, Snapshot};
use protocol::stats::{ErrorEstimate, Stats};
use rerun::{RecordingStreamResult, Scalars, SeriesLines};
use std::collections::VecDeque;

/// Energy against the epoch's first state, as a part of it.
pub const ENERGY: &str = "plots/energy";
/// Hits per simulated second.
pub const HITS: &str = "plots/hits";
/// Wall time of a tick, ms.
pub const TICK_TIME: &str = "plots/tick_time";
/// Simulated seconds per wall second.
pub const SPEED: &str = "plots/speed";
/// Decimal logarithm of the estimated error in metres, and of what is asked for over 10 s.
pub const ERROR: &str = "plots/error";
/// States per second at the bridge.
pub const BRIDGE: &str = "plots/bridge";

/// Wall time between two points of a plot that changes with every state, ns.
const LOG_EVERY_NS: u64 = 100_000_000;
/// Hits are counted over this much simulated time, s.
const HIT_WINDOW_S: f64 = 1.0;
/// Errors below this are drawn here: less is rounding, m.
const LEAST_ERROR_M: f64 = 1e-17;
/// Samples kept for the window; at ten logs a second and a hundredfold slow motion the window is cut short.
const MAX_SAMPLES: usize = 1024;

/// State behind the plots.
#[derive(Default)]
pub struct Plots {
    first_energy_j: Option<f64>,
    logged_ns: Option<u64>,
    hits: VecDeque<(f64, Collisions)>,
    counts: Option<(u64, Counts)>,
}

impl Plots {
    /// Names and colours of all lines, for all time.
    pub fn log_names(rec: &Recording) -> RecordingStreamResult<()> {
        let lines: [(&str, &[(&str, u32)]); 6] = [
            (ENERGY, &[("(E - E0 - work of players) / |E0|", 0xF4A6_3AFF)]),
            (HITS, &[("ball-ball / s", 0xE45C_5CFF), ("ball-wall / s", 0x5C9E_E4FF)]),
            (TICK_TIME, &[("median ms", 0x6FCF_7FFF), ("99 % ms", 0xF2C1_4EFF), ("max ms", 0xE45C_5CFF)]),
            (SPEED, &[("reached", 0x5CD6_C0FF), ("wanted", 0x9090_90FF)]),
            (ERROR, &[("estimated", 0xF4A6_3AFF), ("asked for", 0x9090_90FF)]),
            (
                BRIDGE,
                &[
                    ("received / s", 0x5C9E_E4FF),
                    ("shown / s", 0x6FCF_7FFF),
                    ("dropped / s", 0xE45C_5CFF),
                    ("hits dropped / s", 0xF2C1_4EFF),
                    ("missed by slow viewers / s", 0xB07C_E4FF),
                ],
            ),
        ];
        for (path, series) in lines {
            let looks = SeriesLines::new()
                .with_names(series.iter().map(|(name, _)| *name))
                .with_colors(series.iter().map(|(_, color)| *color))
                .with_widths(series.iter().map(|_| 1.5));
            rec.log_static(path, &looks)?;
        }
        Ok(())
    }

    /// Starts over with an epoch; the bridge's own counts go on.
    pub fn clear(&mut self) {
        *self = Self { counts: self.counts.take(), ..Self::default() };
    }

    /// Logs what a state tells, ten times a second.
    pub fn log_state(
        &mut self,
        rec: &Recording,
        state: &Snapshot,
        counts: Counts,
    ) -> RecordingStreamResult<()> {
        // What players put in is no drift.
        let energy_j = state.energy_j - state.steering_work_j;
        let first = *self.first_energy_j.get_or_insert(energy_j);
        if self.logged_ns.is_some_and(|last| state.wall_ns.abs_diff(last) < LOG_EVERY_NS) {
            return Ok(());
        }
        self.logged_ns = Some(state.wall_ns);
        // A scene may start with no energy at all: then the change itself is shown, in joules.
        let scale = if first == 0.0 { 1.0 } else { first.abs() };
        rec.log(ENERGY, &Scalars::single((energy_j - first) / scale))?;
        if let Some(rates) = self.hit_rates(state) {
            rec.log(HITS, &Scalars::new(rates))?;
        }
        self.log_counts(rec, state.wall_ns, counts)
    }

    /// Logs what the server says of itself.
    pub fn log_stats(rec: &Recording, stats: &Stats) -> RecordingStreamResult<()> {
        rec.log(TICK_TIME, &Scalars::new(stats.tick_micros.map(|micros| micros * 1e-3)))?;
        let wanted = if stats.paused { 0.0 } else { stats.speed_factor };
        rec.log(SPEED, &Scalars::new([stats.real_time_factor, wanted]))?;
        match stats.error_estimate {
            Some(estimate) => rec.log(ERROR, &Scalars::new(error_lines(&estimate))),
            None => Ok(()),
        }
    }

    /// Hits per simulated second over the last [`HIT_WINDOW_S`]; None before time has gone on.
    fn hit_rates(&mut self, state: &Snapshot) -> Option<[f64; 2]> {
        // A clock that stands adds no samples, so that the window outlives a pause.
        if self.hits.back().is_none_or(|(time, _)| *time < state.time_s) {
            self.hits.push_back((state.time_s, state.collisions));
        }
        let outside = |sample: Option<&(f64, Collisions)>| {
            sample.is_some_and(|(t, _)| state.time_s - t >= HIT_WINDOW_S)
        };
        while self.hits.len() > MAX_SAMPLES || outside(self.hits.get(1)) {
            self.hits.pop_front();
        }
        let (since, then) = *self.hits.front()?;
        let span = state.time_s - since;
        let rate = |now: u64, then: u64| now.saturating_sub(then) as f64 / span;
        let now = state.collisions;
        (span > 0.0).then(|| [rate(now.ball_ball, then.ball_ball), rate(now.ball_wall, then.ball_wall)])
    }

    fn log_counts(&mut self, rec: &Recording, wall_ns: u64, now: Counts) -> RecordingStreamResult<()> {
        let Some((since, then)) = self.counts else {
            self.counts = Some((wall_ns, now));
            return Ok(());
        };
        let span = wall_ns.saturating_sub(since) as f64 * 1e-9;
        if span < 1.0 {
            return Ok(());
        }
        self.counts = Some((wall_ns, now));
        let rate = |now: u64, then: u64| now.saturating_sub(then) as f64 / span;
        let received = rate(now.received, then.received);
        rec.log(
            BRIDGE,
            &Scalars::new([
                received,
                rate(now.shown, then.shown),
                rate(now.dropped + now.missed, then.dropped + then.missed),
                rate(now.hits_dropped, then.hits_dropped),
                rate(now.rows_missed, then.rows_missed),
            ]),
        )
    }
}

/// The estimate and, where a tolerance is asked for, that: as decimal logarithms of metres.
fn error_lines(estimate: &ErrorEstimate) -> Vec<f64> {
    // No error at all has no logarithm.
    [Some(estimate.error_m.max(LEAST_ERROR_M)), estimate.asked_m]
        .into_iter()
        .flatten()
        .map(f64::log10)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(time_s: f64, ball_ball: u64) -> Snapshot {
        Snapshot {
            time_s,
            collisions: Collisions { ball_ball, ball_wall: 2 * ball_ball },
            ..Snapshot::default()
        }
    }

    #[test]
    fn an_error_is_drawn_beside_what_was_asked_for() {
        let estimate = ErrorEstimate { error_m: 1e-11, asked_m: Some(1e-9), ..ErrorEstimate::default() };
        assert_eq!(error_lines(&estimate), [-11.0, -9.0]);
        assert_eq!(error_lines(&ErrorEstimate::default()), [-17.0]);
    }

    #[test]
    fn hit_rates_are_per_simulated_second_over_the_window() {
        let mut plots = Plots::default();
        assert_eq!(plots.hit_rates(&state(0.0, 0)), None);
        for tenth in 1..=40_u32 {
            let rates = plots.hit_rates(&state(f64::from(tenth) / 10.0, u64::from(tenth) * 3)).unwrap();
            assert!((rates[0] - 30.0).abs() < 1e-9 && (rates[1] - 60.0).abs() < 1e-9, "{rates:?}");
        }
        assert!(plots.hits.len() <= 12);
        // The clock stands, and so do the rates.
        (0..5000).for_each(|_| assert!(plots.hit_rates(&state(4.0, 120)).is_some()));
        assert!(plots.hits.len() <= MAX_SAMPLES);
    }
}
