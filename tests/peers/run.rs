//! A case, run by all contestants.

use super::contestant::{self, Entry};
use super::knobs::Knobs;
use super::measure::judge;
use super::others::Others;
use super::problem::{Ground, Problem};
use super::rapier::{double, single};
use super::rows::Row;
use super::{ours, problem::Sample};

/// A case and what was measured in it.
pub struct Measured {
    /// The case.
    pub problem: Problem,
    /// All contestants at all their settings.
    pub rows: Vec<Row>,
}

/// Times every contestant is timed, in a quick report once; what takes longer than [`LONG_S`] CPU seconds a run is timed
/// once.
const ROUNDS: usize = 2;
const LONG_S: f64 = 1.0;

/// Runs a case with every contestant of this process, and takes the runs of others. Contestants are timed in turn, so that
/// what else the machine does falls on all of them.
pub fn measure(problem: Problem, others: &Others, quick: bool, progress: &mut dyn FnMut(&str)) -> Measured {
    let entries = entries(&problem, quick);
    let mut rows = vec![];
    for entry in &entries {
        progress(&format!("{}: {}, {}", problem.id, entry.engine, entry.setting));
        let (samples, hits) = contestant::ride(&problem, entry);
        rows.push(row(&problem, (entry.engine, &entry.setting), &samples, hits));
    }
    for round in 0..if quick { 1 } else { ROUNDS } {
        for (entry, row) in entries.iter().zip(&mut rows) {
            if round > 0 && row.cost * problem.seconds > LONG_S {
                continue;
            }
            progress(&format!("{}: time of {}, {}", problem.id, entry.engine, entry.setting));
            row.cost = row.cost.min(contestant::cost(&problem, entry));
        }
    }
    for run in others.of(&problem.id) {
        let row = row(&problem, (&run.engine, &run.setting), &run.samples, None);
        rows.push(Row { cost: run.cpu_s_per_s, ..row });
    }
    Measured { problem, rows }
}

/// A row without its cost.
fn row(problem: &Problem, (engine, setting): (&str, &str), samples: &[Sample], hits: Option<u64>) -> Row {
    let worth = judge(problem, samples);
    Row {
        engine: engine.into(),
        setting: setting.into(),
        cost: f64::INFINITY,
        error: worth.error,
        energy_change: worth.energy_change,
        overlap: worth.overlap,
        hits,
        hits_per_second: hits.map(|hits| hits as f64 / problem.seconds),
    }
}

/// All contestants of this process. On the plane, motion is exact at any tolerance.
fn entries(problem: &Problem, quick: bool) -> Vec<Entry> {
    let tolerances: &[f64] = match problem.ground {
        Ground::Plane => &[1e-8],
        Ground::Bowl(_) if quick || problem.gas => &[1e-4, 1e-8, 1e-12],
        Ground::Bowl(_) => &[1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12],
    };
    let mut entries: Vec<Entry> = tolerances.iter().map(|tolerance| ours::entry(*tolerance)).collect();
    for knobs in Knobs::tried(problem) {
        entries.extend([double::entry(knobs), single::entry(knobs)]);
    }
    entries
}
