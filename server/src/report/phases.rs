//! Where the time goes.
//!
//! The engine has no clock, and a sampling profile sees little of loops that are inlined. It counts, though. Variants
//! of the scene (fewer balls, smaller ones, other tolerances) mix the counts in other proportions, so that the cost of one
//! of each can be fitted to CPU times. Pairs looked at, pairs whose distance polynomial is formed and hits keep nearly one
//! proportion in all variants: their costs cannot be told apart so, and are shown as one.

use super::clock::cost;
use super::numbers::{self, plain};
use super::section::{Table, table};
use super::subject::Subject;
use super::{Options, ReportError};
use ballroom_physics::{Accuracy, Report, Scene, Time};
use maud::{Markup, html};
use nalgebra::{DMatrix, DVector};
use serde_json::{Value, json};

/// Parts of the time.
const PARTS: usize = 3;
/// A fit that is off by more than this says nothing about parts.
const HOLDS: f64 = 0.2;
/// What is counted.
const KINDS: [&str; PARTS] = ["windows, queue", "arcs", "meetings"];
/// The same, in words for the page.
const COUNTS: [&str; PARTS] = ["ball-seconds over radius", "steps", "pairs looked at"];
/// Factors of all radii in the variants.
const RADII: [f64; 3] = [1.0, 0.8, 0.6];
/// One ball of so many is in a variant.
const STRIDES: [usize; 4] = [1, 2, 4, 8];

/// One variant of the scene, run.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sample {
    counts: [f64; PARTS],
    formed_and_hits: [f64; 2],
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
    each_s: [f64; PARTS],
    /// Pairs whose distance polynomial was formed, and hits.
    formed_and_hits: [f64; 2],
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
    let whole = sample(subject, subject.scene(), 1.0, span_s)?;
    let mut samples = vec![whole];
    if subject.balls() > 1 {
        for (scene, factor) in variants(subject, options).into_iter().skip(1) {
            samples.push(sample(subject, &scene, factor, span_s)?);
        }
    }
    let (each_s, residual) = if subject.balls() == 1 {
        // Nothing to tell apart: no pairs, and hits on walls only.
        ([whole.cpu_s / whole.counts[0], 0.0, 0.0], 0.0)
    } else {
        fit(&samples)
    };
    Ok(Phases {
        whole,
        span_s,
        balls: subject.balls(),
        each_s,
        formed_and_hits: whole.formed_and_hits,
        residual,
        variants: samples.len(),
    })
}

/// Scenes with other proportions of everything: with every second, fourth … ball only, with smaller balls, with other
/// tolerances.
fn variants(subject: &Subject, options: &Options) -> Vec<(Scene, f64)> {
    let mut accuracies = vec![subject.own()];
    if !subject.is_flat() {
        accuracies.push(Accuracy::Tolerance(1e-4));
        accuracies.extend((!options.quick).then_some(Accuracy::Tolerance(1e-12)));
    }
    let mut variants = Vec::new();
    for accuracy in accuracies {
        for stride in STRIDES {
            for factor in RADII {
                let mut scene = Scene { accuracy, ..subject.scene().clone() };
                scene.balls = scene.balls.into_iter().step_by(stride).collect();
                scene.balls.iter_mut().for_each(|ball| ball.radius *= factor);
                variants.push((scene, factor));
            }
        }
    }
    variants
}

fn sample(subject: &Subject, scene: &Scene, factor: f64, span_s: f64) -> Result<Sample, ReportError> {
    let start = subject.start_of(scene)?;
    let mut report = Report::default();
    let cost = cost(|| start.clone(), |run| report = run.advance_to(Time::of_seconds(span_s)));
    let hits = report.collisions.ball_ball + report.collisions.ball_wall;
    let [steps, looked_at, formed, hits] =
        [report.steps, report.pairs[0], report.pairs[1], hits].map(|n| n as f64);
    // A window is so many radii long: smaller balls have more of them.
    let windows = scene.balls.len() as f64 * span_s / factor;
    Ok(Sample { counts: [windows, steps, looked_at], formed_and_hits: [formed, hits], cpu_s: cost.seconds })
}

/// The costs, none below zero, whose sums come nearest to the measured times by the squares of the relative distances:
/// the best of all choices of kinds that may cost something.
fn fit(samples: &[Sample]) -> ([f64; PARTS], f64) {
    let mut best = ([0.0; PARTS], f64::INFINITY);
    for chosen in 1_usize..1 << KINDS.len() {
        let kinds: Vec<usize> = (0..KINDS.len()).filter(|kind| chosen >> kind & 1 == 1).collect();
        let matrix = DMatrix::from_fn(samples.len(), kinds.len(), |row, column| {
            samples[row].counts[kinds[column]] / samples[row].cpu_s
        });
        let ones = DVector::from_element(samples.len(), 1.0);
        let Ok(solved) = matrix.clone().svd(true, true).solve(&ones, 1e-12) else { continue };
        let residual = ((&matrix * &solved - &ones).norm_squared() / samples.len() as f64).sqrt();
        if solved.iter().all(|&cost| cost >= 0.0) && residual < best.1 {
            best = ([0.0; PARTS], residual);
            kinds.iter().zip(solved.iter()).for_each(|(&kind, &cost)| best.0[kind] = cost);
        }
    }
    best
}

impl Phases {
    /// Hits on balls and walls a simulated second.
    pub fn hits_per_second(&self) -> f64 {
        self.formed_and_hits[1] / self.span_s
    }

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
            @if self.balls == 1 {
                p { "A ball alone: all of its time goes into its arcs, with their windows and walls." }
            } @else {
                p {
                    "The engine counts and has no clock. The scene was run for " (plain(self.span_s)) " s in " (self.variants)
                    " variants (fewer balls, smaller ones, other tolerances); the cost of one of each "
                    "count is what fits all their CPU times, none below zero. The fit is off by " (plain(100.0 * self.residual))
                    " % (root mean square); together it gives " (plain(fitted)) " of the " (plain(self.measured()))
                    " µs measured. Meetings are the search for "
                    "neighbours, the roots and the impacts: their counts keep one proportion in all variants and cannot be told apart by them. A pair "
                    "whose distance polynomial was formed came up " (plain(self.formed_and_hits[0] / ball_seconds)) " times a ball-second, a hit "
                    (plain(self.formed_and_hits[1] / ball_seconds)) " times."
                }
                @if self.residual > HOLDS { p { "That is too far off to tell parts from one another: there is too little of some of them." } }
                @else { (table(&["part", "counted by", "a ball-second", "ns each", "µs a ball-second", "share"], &rows)) }
            }
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
            "pairs_formed": self.formed_and_hits[0],
            "hits": self.formed_and_hits[1],
            "parts": (0..KINDS.len()).map(part).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_are_found_and_none_is_negative() {
        let costs = [70e-9, 0.0, 900e-9];
        let mixes = [[1.0, 9.0, 5.0], [2.0, 3.0, 9.0], [1.0, 1.0, 2.0], [3.0, 7.0, 1.0], [9.0, 2.0, 6.0]];
        let cpu = |counts: [f64; PARTS]| -> f64 {
            counts.iter().zip(costs).map(|(count, cost)| count * cost).sum()
        };
        let samples = mixes.map(|counts| Sample { counts, formed_and_hits: [0.0; 2], cpu_s: cpu(counts) });
        let (each, residual) = fit(&samples);
        assert!(residual < 1e-12 && each.iter().zip(costs).all(|(a, b)| (a - b).abs() < 1e-18), "{each:?}");
        // A cost below zero would fit these best: none it is instead.
        let odd = samples.map(|s| Sample { cpu_s: s.cpu_s - 30e-9 * s.counts[1], ..s });
        assert!(fit(&odd).0.iter().all(|&cost| cost >= 0.0) && fit(&odd).1 > 1e-3);
    }
}
