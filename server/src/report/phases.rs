//! Where the time goes.
//!
//! The engine has no clock, and a sampling profile sees little of loops that are inlined. It counts, though: steps,
//! pairs looked at, pairs whose distance polynomial was formed, hits. Variants of the scene (smaller balls, other
//! tolerances, balls alone) mix these in other proportions, so that costs of one each can be fitted to CPU times.

use super::clock::cost;
use super::numbers::{self, plain};
use super::section::{Table, table};
use super::subject::Subject;
use super::{Options, ReportError};
use ballroom_physics::{Accuracy, Report, Scene, Time};
use maud::{Markup, html};
use nalgebra::{DMatrix, DVector};
use serde_json::{Value, json};

/// What is counted.
const KINDS: [&str; 4] = ["arcs", "broad phase", "roots", "impacts"];
/// The same, in words for the page.
const COUNTS: [&str; 4] = ["steps", "pairs looked at", "pairs whose distance polynomial was formed", "hits"];
/// Factors of all radii in the variants.
const RADII: [f64; 5] = [1.0, 0.7, 0.5, 0.3, 0.15];
/// Balls that are run alone.
const ALONE: usize = 6;

/// One variant of the scene, run.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sample {
    counts: [f64; 4],
    cpu_s: f64,
}

/// What one of each costs, and how much of the scene's time that is.
#[derive(Clone, Debug, PartialEq)]
pub struct Phases {
    /// The scene itself.
    whole: Sample,
    /// Simulated seconds of it.
    span_s: f64,
    balls: usize,
    /// CPU time of one of each kind, s.
    each_s: [f64; 4],
    /// Root mean square of the relative distance between fitted and measured times.
    residual: f64,
    variants: usize,
}

/// Runs the variants and fits.
pub fn measure(subject: &Subject, options: &Options) -> Result<Phases, ReportError> {
    let span_s = match (subject.balls(), options.quick) {
        (0..100, true) => 5.0,
        (0..100, false) => 20.0,
        (_, true) => 0.5,
        (_, false) => 1.0,
    };
    let whole = sample(subject, subject.scene(), span_s)?;
    let mut samples = vec![whole];
    for scene in variants(subject, options) {
        samples.push(sample(subject, &scene, span_s)?);
    }
    let (each_s, residual) = fit(&samples);
    Ok(Phases { whole, span_s, balls: subject.balls(), each_s, residual, variants: samples.len() })
}

fn variants(subject: &Subject, options: &Options) -> Vec<Scene> {
    let scene = subject.scene();
    let shrunk = |factor: f64, accuracy: Accuracy| {
        let mut scene = Scene { accuracy, ..scene.clone() };
        scene.balls.iter_mut().for_each(|ball| ball.radius *= factor);
        scene
    };
    let mut accuracies = vec![scene.accuracy];
    if !subject.is_flat() {
        accuracies.push(Accuracy::Tolerance(1e-4));
        accuracies.extend((!options.quick).then_some(Accuracy::Tolerance(1e-12)));
    }
    let mut variants: Vec<Scene> = accuracies
        .iter()
        .flat_map(|&accuracy| RADII.map(|factor| shrunk(factor, accuracy)))
        .skip(1)
        .collect();
    let stride = scene.balls.len().div_ceil(ALONE);
    let alone =
        scene.balls.iter().step_by(stride).map(|ball| Scene { balls: vec![ball.clone()], ..scene.clone() });
    variants.extend(alone);
    variants
}

fn sample(subject: &Subject, scene: &Scene, span_s: f64) -> Result<Sample, ReportError> {
    let start = subject.start_of(scene)?;
    let mut report = Report::default();
    let cost = cost(|| start.clone(), |run| report = run.advance_to(Time::of_seconds(span_s)));
    let hits = report.collisions.ball_ball + report.collisions.ball_wall;
    let counts = [report.steps, report.pairs[0], report.pairs[1], hits].map(|count| count as f64);
    Ok(Sample { counts, cpu_s: cost.seconds })
}

/// The costs, none below zero, whose sums come nearest to the measured times by the squares of the relative distances:
/// the best of all choices of kinds that may cost something.
fn fit(samples: &[Sample]) -> ([f64; 4], f64) {
    let mut best = ([0.0; 4], f64::INFINITY);
    for chosen in 1_usize..1 << KINDS.len() {
        let kinds: Vec<usize> = (0..KINDS.len()).filter(|kind| chosen >> kind & 1 == 1).collect();
        let matrix = DMatrix::from_fn(samples.len(), kinds.len(), |row, column| {
            samples[row].counts[kinds[column]] / samples[row].cpu_s
        });
        let ones = DVector::from_element(samples.len(), 1.0);
        let Ok(solved) = matrix.clone().svd(true, true).solve(&ones, 1e-12) else { continue };
        let residual = ((&matrix * &solved - &ones).norm_squared() / samples.len() as f64).sqrt();
        if solved.iter().all(|&cost| cost >= 0.0) && residual < best.1 {
            best = ([0.0; 4], residual);
            kinds.iter().zip(solved.iter()).for_each(|(&kind, &cost)| best.0[kind] = cost);
        }
    }
    best
}

impl Phases {
    /// CPU time a ball and simulated second that a kind takes by the fit, µs.
    fn micros(&self, kind: usize) -> f64 {
        1e6 * self.whole.counts[kind] * self.each_s[kind] / (self.balls as f64 * self.span_s)
    }

    /// The same of all, measured, µs.
    fn measured(&self) -> f64 {
        1e6 * self.whole.cpu_s / (self.balls as f64 * self.span_s)
    }

    /// The part of the page.
    pub fn show(&self) -> Markup {
        let ball_seconds = self.balls as f64 * self.span_s;
        let fitted: f64 = (0..KINDS.len()).map(|kind| self.micros(kind)).sum();
        let row = |kind: usize| {
            vec![
                KINDS[kind].to_owned(),
                COUNTS[kind].to_owned(),
                plain(self.whole.counts[kind] / ball_seconds),
                plain(1e9 * self.each_s[kind]),
                plain(self.micros(kind)),
                format!("{:.0} %", 100.0 * self.micros(kind) / fitted),
            ]
        };
        let rows: Vec<_> = (0..KINDS.len()).filter(|&kind| self.whole.counts[kind] > 0.0).map(row).collect();
        html! {
            h3 { "Where the time goes" }
            p {
                "The engine counts and has no clock. The scene was run for " (plain(self.span_s)) " s in " (self.variants)
                " variants (radii down to " (RADII[RADII.len() - 1]) " of its own, other tolerances, balls alone); the cost of one of each count is what fits all their CPU times, "
                "none below zero. The fit is off by " (plain(100.0 * self.residual)) " % (root mean square); together it gives "
                (plain(fitted)) " of the " (plain(self.measured())) " µs measured. An arc’s cost includes its windows and walls, a hit’s the arcs it begins."
            }
            (table(&["part", "counted by", "a ball-second", "ns each", "µs a ball-second", "share"], &rows))
        }
    }

    /// As rows.
    pub fn rows(&self, subject: &Subject) -> Table {
        let mut table = Table::new("phases", &["scene", "part", "count", "ns_each", "us_per_ball_second"]);
        for (kind, name) in KINDS.iter().enumerate() {
            let numbers = [self.whole.counts[kind], 1e9 * self.each_s[kind], self.micros(kind)];
            let [count, each, micros] = numbers.map(numbers::csv);
            table.push([subject.name.clone(), (*name).to_owned(), count, each, micros]);
        }
        table
    }

    /// For programs.
    pub fn json(&self) -> Value {
        let part = |kind: usize| {
            json!({
                "part": KINDS[kind],
                "counted_by": COUNTS[kind],
                "count": self.whole.counts[kind],
                "ns_each": 1e9 * self.each_s[kind],
                "us_per_ball_second": self.micros(kind),
            })
        };
        json!({
            "span_s": self.span_s,
            "measured_us_per_ball_second": self.measured(),
            "fit_residual": self.residual,
            "variants": self.variants,
            "parts": (0..KINDS.len()).map(part).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_are_found_and_none_is_negative() {
        let costs = [500e-9, 0.0, 40e-9, 900e-9];
        let mixes = [
            [9.0, 5.0, 1.0, 1.0],
            [3.0, 9.0, 4.0, 1.0],
            [1.0, 2.0, 8.0, 5.0],
            [7.0, 1.0, 0.0, 0.0],
            [2.0, 6.0, 6.0, 3.0],
        ];
        let cpu = |counts: [f64; 4]| counts.iter().zip(costs).map(|(count, cost)| count * cost).sum();
        let samples = mixes.map(|counts| Sample { counts, cpu_s: cpu(counts) });
        let (each, residual) = fit(&samples);
        assert!(residual < 1e-12 && each.iter().zip(costs).all(|(a, b)| (a - b).abs() < 1e-18), "{each:?}");
        // A cost below zero would fit these best: none it is instead.
        let odd = samples.map(|s| Sample { cpu_s: s.cpu_s - 30e-9 * s.counts[1], ..s });
        assert!(fit(&odd).0.iter().all(|&cost| cost >= 0.0) && fit(&odd).1 > 1e-3);
    }
}
