//! B5, B6: motion about the bottom of a bowl and the top of a hill in the limit of small amplitude, where it is linear:
//!
//! ```text
//! bowl   K = kappa/(1 - r kappa):  (1+k) nu^2 + k sigma K nu - g K = 0,  x + i y turns with both roots
//! hill   K = kappa/(1 + r kappa):  x = cosh(lambda t),  lambda^2 = g K/(1+k)
//! ```
//!
//! The path over its amplitude is even in the amplitude; two amplitudes leave its fourth power.

use super::{KINDS, Kind, ROLLING_HOLLOW, ROLLING_SOLID, with};
use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::ride::{Largest, run};
use crate::scenes::{contact, graph};
use ballroom_physics::{Accuracy, BallSpec, SceneFault};
use nalgebra::Vector2;

const KAPPA: f64 = 1.5;
const RADIUS: f64 = 0.2;
const AMPLITUDE: f64 = 1e-3;
const RATE_HZ: u32 = 60;

/// The path from rest at `amplitude`, over the first centre's distance.
fn path(
    kind: Kind,
    bend: f64,
    spin: f64,
    amplitude: f64,
    ticks: u64,
) -> Result<Vec<Vector2<f64>>, SceneFault> {
    let ball = BallSpec { spin, ..kind.ball(RADIUS, contact(amplitude, 0.0)) };
    let mut scene = with(graph(0.5, &[(2, 0, 0.5 * bend), (0, 2, 0.5 * bend)], kind.motion), ball);
    // The error asked for is in metres, of a motion of millimetres.
    scene.accuracy = Accuracy::Tolerance(1e-13);
    let mut out = vec![];
    run(&scene, RATE_HZ, ticks, |_, engine| out.push(engine.ball(0).center.xy()))?;
    let first = out[0].x;
    Ok(out.into_iter().map(|place| place / first).collect())
}

/// The largest distance of the limit from the linear motion, over the largest amplitude yet.
fn measure(
    (kind, bend, spin, amplitude): (Kind, f64, f64, f64),
    ticks: u64,
    linear: impl Fn(f64) -> [f64; 2],
) -> Result<[f64; 1], SceneFault> {
    let wide = path(kind, bend, spin, amplitude, ticks)?;
    let narrow = path(kind, bend, spin, 0.5 * amplitude, ticks)?;
    let mut largest = Largest::default();
    for (tick, (wide, narrow)) in wide.iter().zip(&narrow).enumerate() {
        let exact = Vector2::from(linear(tick as f64 / f64::from(RATE_HZ)));
        let limit = (narrow * 4.0 - wide) / 3.0;
        largest.see((limit - exact).norm() / exact.norm().max(1.0));
    }
    Ok([largest.value()])
}

fn in_the_bowl(kind: Kind, spin: f64, ticks: u64) -> Result<[f64; 1], SceneFault> {
    let bend = KAPPA / (1.0 - RADIUS * KAPPA);
    let [a, b, c] = [1.0 + kind.k, kind.k * RADIUS * spin * bend, -9.81 * bend];
    let root = (b * b - 4.0 * a * c).sqrt();
    let [fast, slow] = [(-b + root) / (2.0 * a), (-b - root) / (2.0 * a)];
    // From rest: shares that add up to 1 and whose velocities cancel.
    let share = -slow / (fast - slow);
    measure((kind, KAPPA, spin, AMPLITUDE), ticks, |t| {
        let ((s1, c1), (s2, c2)) = ((fast * t).sin_cos(), (slow * t).sin_cos());
        [share * c1 + (1.0 - share) * c2, share * s1 + (1.0 - share) * s2]
    })
}

fn on_the_hill(kind: Kind, ticks: u64) -> Result<[f64; 1], SceneFault> {
    let growth = (9.81 * KAPPA / (1.0 + RADIUS * KAPPA) / (1.0 + kind.k)).sqrt();
    // It grows a hundredfold.
    measure((kind, -KAPPA, 0.0, 0.01 * AMPLITUDE), ticks, |t| [(growth * t).cosh(), 0.0])
}

fn limit(seconds: f64, bound: f64) -> Demand {
    Demand {
        norm: "limit of two amplitudes, largest over ticks",
        ..Demand::over_ticks("centre over amplitude", "1", Span::Seconds(seconds), bound)
    }
}

/// The cases of these families.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![];
    for kind in KINDS {
        cases.push(Case::new(
            format!("B5/bowl-{}", kind.name),
            "a small swing at the bottom",
            [limit(10.0, 1e-9)],
            move || in_the_bowl(kind, 0.0, 600),
        ));
        cases.push(Case::new(
            format!("B5/hill-{}", kind.name),
            "growth from rest beside the top",
            [limit(1.5, 1e-9)],
            move || on_the_hill(kind, 90),
        ));
    }
    for (kind, spin) in [(ROLLING_SOLID, 15.0), (ROLLING_SOLID, -30.0), (ROLLING_HOLLOW, 15.0)] {
        cases.push(Case::new(
            format!("B6/{}-{}", kind.name, if spin > 0.0 { "left" } else { "right" }),
            "spin splits the small swing in two turns",
            [limit(10.0, 1e-9)],
            move || in_the_bowl(kind, spin, 600),
        ));
    }
    cases
}
