//! What a run is worth: its error, its energy, its deepest overlap; the same arithmetic for every contestant.

use super::problem::{Ground, Problem, Sample, Triple, Truth};

/// Worth of one run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Worth {
    /// In the case's norm, see [`norm`]; infinite for a run that ended in no numbers.
    pub error: f64,
    /// Energy at the end over that of the start, less 1.
    pub energy_change: f64,
    /// Deepest overlap of two balls at any sample, in radii.
    pub overlap: f64,
}

/// The case's norm, in words.
pub fn norm(problem: &Problem) -> &'static str {
    match problem.truth {
        Truth::Centers(_) => "largest distance of a centre from the exact one over all ticks, m",
        Truth::Velocities(..) => {
            "difference of the last velocities in the kinetic norm, over the norm at the start"
        }
        Truth::Energy => "largest relative change of energy over all ticks (exact: none)",
    }
}

/// Judges a run by its samples, the start included.
pub fn judge(problem: &Problem, samples: &[Sample]) -> Worth {
    let energies: Vec<f64> = samples.iter().map(|sample| energy(problem, sample)).collect();
    let change = |e: f64| e / energies[0] - 1.0;
    let error = match &problem.truth {
        Truth::Centers(exact) => {
            let pairs = samples.iter().zip(exact).flat_map(|(own, exact)| own.centers.iter().zip(exact));
            worst(pairs.map(|(own, exact)| distance(*own, *exact)))
        }
        Truth::Velocities(exact, _) => kinetic_difference(problem, &samples[samples.len() - 1], exact),
        Truth::Energy => worst(energies.iter().map(|e| change(*e))),
    };
    let overlap = samples.iter().map(|sample| overlap(problem, sample)).fold(0.0, f64::max);
    Worth { error: finite(error), energy_change: change(energies[energies.len() - 1]), overlap }
}

/// The largest, and infinity for what is no number.
fn worst(errors: impl Iterator<Item = f64>) -> f64 {
    errors.map(|error| finite(error.abs())).fold(0.0, f64::max)
}

fn finite(error: f64) -> f64 {
    if error.is_finite() { error } else { f64::INFINITY }
}

fn distance(a: Triple, b: Triple) -> f64 {
    square(std::array::from_fn(|k| a[k] - b[k])).sqrt()
}

fn square(a: Triple) -> f64 {
    a.iter().map(|x| x * x).sum()
}

/// Kinetic and potential energy, J. The plane's height is no matter, and of a sliding ball neither is its spin.
pub fn energy(problem: &Problem, sample: &Sample) -> f64 {
    let height =
        |center: &Triple| if problem.ground == Ground::Plane { 0.0 } else { problem.gravity * center[2] };
    let balls = problem.balls.iter().zip(&sample.centers).zip(&sample.velocities);
    let moving: f64 = balls.map(|((b, c), v)| b.mass * (0.5 * square(*v) + height(c))).sum();
    let turning = problem.balls.iter().zip(&sample.omegas);
    let turning: f64 =
        turning.map(|(b, w)| 0.5 * b.inertia_factor * b.mass * b.radius * b.radius * square(*w)).sum();
    if problem.rolls { moving + turning } else { moving }
}

/// |w - v| over |v at the start|, each ball weighed with its mass.
fn kinetic_difference(problem: &Problem, last: &Sample, exact: &[f64]) -> f64 {
    let weighed = |speeds: &mut dyn Iterator<Item = f64>| -> f64 {
        problem.balls.iter().zip(speeds).map(|(ball, v)| ball.mass * v * v).sum()
    };
    let off = weighed(&mut last.velocities.iter().zip(exact).map(|(own, exact)| own[0] - exact));
    (off / weighed(&mut problem.balls.iter().map(|ball| ball.velocity[0]))).sqrt()
}

/// The deepest overlap of any two balls, in radii of the smaller: by a sweep along x.
fn overlap(problem: &Problem, sample: &Sample) -> f64 {
    let reach = 2.0 * problem.balls.iter().map(|ball| ball.radius).fold(0.0, f64::max);
    let mut order: Vec<usize> = (0..sample.centers.len()).collect();
    order.sort_by(|a, b| sample.centers[*a][0].total_cmp(&sample.centers[*b][0]));
    let mut deepest: f64 = 0.0;
    for (rank, &a) in order.iter().enumerate() {
        for &b in &order[rank + 1..] {
            if sample.centers[b][0] - sample.centers[a][0] >= reach {
                break;
            }
            let radii = [problem.balls[a].radius, problem.balls[b].radius];
            let depth = radii[0] + radii[1] - distance(sample.centers[a], sample.centers[b]);
            deepest = deepest.max(depth / radii[0].min(radii[1]));
        }
    }
    deepest
}
