//! How long ticks take, and which bits come out of them.

use super::numbers::{self, plain};
use super::section::{Table, table};
use super::subject::{RATE_HZ, Subject, tick};
use super::{Options, ReportError};
use ballroom_physics::Controller;
use maud::{Markup, html};
use serde_json::{Value, json};
use std::hint::black_box;
use std::time::Instant;

/// Ticks that warm caches up and are not counted.
const WARM_UP: usize = 60;
/// Ticks whose state hash is shown.
const HASHED: [usize; 5] = [0, 60, 120, 300, 600];

/// A run tick by tick.
#[derive(Clone, Debug)]
pub struct Ticks {
    /// Wall time of each counted tick, sorted, µs.
    micros: Vec<f64>,
    /// Ticks and their hashes.
    hashes: Vec<(usize, u64)>,
}

/// Runs the scene at its own setting, as a server does.
pub fn measure(subject: &Subject, options: &Options) -> Result<Ticks, ReportError> {
    let counted = match (subject.balls(), options.quick) {
        (0..100, true) => 1200,
        (0..100, false) => 6000,
        (_, true) => 120,
        (_, false) => 600,
    };
    let mut run = subject.start(subject.own())?;
    let mut micros = Vec::with_capacity(counted);
    let mut hashes = Vec::new();
    for n in 0..=WARM_UP + counted {
        let begin = Instant::now();
        run.advance_to(tick(n));
        read(&run);
        let took = begin.elapsed();
        if n > WARM_UP {
            micros.push(took.as_secs_f64() * 1e6);
        }
        if HASHED.contains(&n) {
            hashes.push((n, run.state_hash()));
        }
    }
    micros.sort_by(f64::total_cmp);
    Ok(Ticks { micros, hashes })
}

/// Reads every ball's state, as a server does once a tick.
pub fn read(run: &Controller) {
    for ball in run.balls() {
        black_box(ball);
    }
}

impl Ticks {
    /// The time that the part `share` of all ticks do not exceed, µs.
    fn quantile(&self, share: f64) -> f64 {
        let rank = (share * self.micros.len() as f64).ceil() as usize;
        self.micros[rank.clamp(1, self.micros.len()) - 1]
    }

    fn shown(&self) -> [(&'static str, f64); 3] {
        [("p50", self.quantile(0.5)), ("p99", self.quantile(0.99)), ("max", self.quantile(1.0))]
    }

    /// The part of the page.
    pub fn show(&self) -> Markup {
        let budget = 1e6 / f64::from(RATE_HZ);
        let row = |(name, micros): (&str, f64)| {
            vec![name.to_owned(), plain(micros), format!("{} %", plain(100.0 * micros / budget))]
        };
        html! {
            h3 { "Ticks" }
            p {
                "Wall time of a tick with all states read, over " (self.micros.len()) " ticks at " (RATE_HZ)
                " Hz after " (WARM_UP) " that are not counted. Whatever else the machine does is in it, above all in the longest."
            }
            (table(&["", "µs a tick", "of the time between ticks"], &self.shown().map(row)))
        }
    }

    /// The hashes, for whoever wants to compare machines.
    pub fn show_hashes(&self) -> Markup {
        let row = |&(tick, hash): &(usize, u64)| vec![tick.to_string(), format!("{hash:016x}")];
        let rows: Vec<_> = self.hashes.iter().map(row).collect();
        html! {
            h3 { "State hashes" }
            p {
                "The same scene gives the same bits: these hashes of every word that the future follows from belong to this scene at "
                "its own setting, on any machine, with any number of threads."
            }
            (table(&["tick", "hash"], &rows))
        }
    }

    /// Both as rows.
    pub fn tables(&self, subject: &Subject) -> [Table; 2] {
        let mut ticks = Table::new("ticks", &["scene", "rate_hz", "ticks", "p50_us", "p99_us", "max_us"]);
        let [p50, p99, max] = self.shown().map(|(_, micros)| numbers::csv(micros));
        let count = self.micros.len().to_string();
        ticks.push([subject.name.clone(), RATE_HZ.to_string(), count, p50, p99, max]);
        let mut hashes = Table::new("state_hashes", &["scene", "tick", "hash"]);
        for (tick, hash) in &self.hashes {
            hashes.push([subject.name.clone(), tick.to_string(), format!("{hash:016x}")]);
        }
        [ticks, hashes]
    }

    /// Both for programs.
    pub fn json(&self) -> Value {
        let [p50, p99, max] = self.shown().map(|(_, micros)| micros);
        let hash = |&(tick, hash): &(usize, u64)| json!({ "tick": tick, "hash": format!("{hash:016x}") });
        json!({
            "ticks": self.micros.len(),
            "wall_us": { "p50": p50, "p99": p99, "max": max },
            "state_hashes": self.hashes.iter().map(hash).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_is_exceeded_by_no_more_than_the_rest() {
        let ticks = Ticks { micros: (1..=200).map(f64::from).collect(), hashes: Vec::new() };
        assert_eq!(ticks.shown().map(|(_, micros)| micros), [100.0, 198.0, 200.0]);
    }
}
