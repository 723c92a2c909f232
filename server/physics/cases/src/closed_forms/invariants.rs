//! B8, B9: what spin and speed trade along a path, beside energy.
//!
//! ```text
//! B8  parabolic cylinder, slope angle theta, l^2 = k/(1+k):  v_axis = A cos(l theta + d),  l sigma = A sin(l theta + d)
//! B9  surface of revolution (Routh), h = rho v_phi:          dh/dtheta = -(k/(1+k)) rho sigma
//!                                                             dsigma/dtheta = (h/rho)(1 - sin(theta) s'/rho)
//! ```
//!
//! rho is the centre's distance from the axis and s its arc length along the meridian. Both laws are linear in theta and hold
//! whatever the ball's pace; they are integrated here in theta, in steps so short that their own error is rounding.

use super::{Kind, ROLLING_HOLLOW, ROLLING_SOLID, with};
use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::ride::{Largest, run};
use crate::scenes::{contact, graph};
use ballroom_physics::{BallSpec, SceneFault};
use nalgebra::{Vector2, Vector3};

const SECONDS: f64 = 10.0;
const RATE_HZ: u32 = 30;
/// Steps of the scheme of order 4 between ticks.
const STEPS: u32 = 64;

/// Amplitude A and phase d over all ticks.
fn along_a_cylinder(kind: Kind, spin: f64) -> Result<[f64; 2], SceneFault> {
    let r = 0.2;
    let velocity = Vector3::new(0.0, 0.5, 0.0);
    let ball = BallSpec { velocity, spin, ..kind.ball(r, contact(0.8, -1.5)) };
    let scene = with(graph(12.0, &[(2, 0, 0.75)], kind.motion), ball);
    let lambda = (kind.k / (1.0 + kind.k)).sqrt();
    let mut first = None;
    let mut largest = [Largest::default(); 2];
    run(&scene, RATE_HZ, (f64::from(RATE_HZ) * SECONDS) as u64, |_, engine| {
        let ball = engine.ball(0);
        let theta = ball.normal.x.atan2(ball.normal.z);
        let sigma = r * ball.omega.dot(&ball.normal);
        let phase = (lambda * sigma).atan2(ball.velocity.y) + lambda * theta;
        let amplitude = (lambda * sigma).hypot(ball.velocity.y);
        let [length, angle] = *first.get_or_insert([amplitude, phase]);
        largest[0].see(amplitude - length);
        largest[1].see(phase - angle);
    })?;
    Ok(largest.map(Largest::value))
}

/// A meridian z = f(rho): the contact's rho and f'' by the slope f'.
type Meridian = fn(f64) -> [f64; 2];

/// z = rho^2/4.
fn paraboloid(slope: f64) -> [f64; 2] {
    [2.0 * slope, 0.5]
}

/// z = rho^4/2.
fn quartic(slope: f64) -> [f64; 2] {
    let rho = (0.5 * slope).cbrt();
    [rho, 6.0 * rho * rho]
}

/// (dh/dtheta, dsigma/dtheta).
fn routh(meridian: Meridian, k: f64, r: f64, theta: f64, [h, sigma]: [f64; 2]) -> Vector2<f64> {
    let (sin, cos) = theta.sin_cos();
    let [contact_rho, bend] = meridian(sin / cos);
    let rho = contact_rho - r * sin;
    let stretch = 1.0 / (bend * cos.powi(3)) - r;
    Vector2::new(-k / (1.0 + k) * rho * sigma, h / rho * (1.0 - sin * stretch / rho))
}

/// h and sigma over all ticks.
fn on_revolution(kind: Kind, floor: Revolution, spin: f64) -> Result<[f64; 2], SceneFault> {
    let r = 0.1;
    let velocity = Vector3::new(0.3, 1.1, 0.0);
    let ball = BallSpec { velocity, spin, ..kind.ball(r, contact(0.9, 0.0)) };
    let scene = with(graph(1.6, floor.terms, kind.motion), ball);
    let mut exact: Option<(f64, Vector2<f64>)> = None;
    let mut largest = [Largest::default(); 2];
    run(&scene, RATE_HZ, (f64::from(RATE_HZ) * SECONDS) as u64, |_, engine| {
        let ball = engine.ball(0);
        let theta = ball.normal.xy().norm().atan2(ball.normal.z);
        let (c, w) = (ball.center, ball.velocity);
        let own = Vector2::new(c.x * w.y - c.y * w.x, r * ball.omega.dot(&ball.normal));
        let (mut at, mut y) = *exact.get_or_insert((theta, own));
        let step = (theta - at) / f64::from(STEPS);
        let slope = |at: f64, y: Vector2<f64>| routh(floor.meridian, kind.k, r, at, y.into());
        for _ in 0..STEPS {
            let k1 = slope(at, y);
            let k2 = slope(at + 0.5 * step, y + k1 * (0.5 * step));
            let k3 = slope(at + 0.5 * step, y + k2 * (0.5 * step));
            let k4 = slope(at + step, y + k3 * step);
            y += (k1 + (k2 + k3) * 2.0 + k4) * (step / 6.0);
            at += step;
        }
        exact = Some((theta, y));
        largest[0].see(own.x - y.x);
        largest[1].see(own.y - y.y);
    })?;
    Ok(largest.map(Largest::value))
}

/// A floor of revolution.
#[derive(Clone, Copy)]
struct Revolution {
    name: &'static str,
    terms: &'static [(usize, usize, f64)],
    meridian: Meridian,
}

const PARABOLOID: Revolution =
    Revolution { name: "paraboloid", terms: &[(2, 0, 0.25), (0, 2, 0.25)], meridian: paraboloid };
const QUARTIC: Revolution =
    Revolution { name: "quartic", terms: &[(4, 0, 0.5), (2, 2, 1.0), (0, 4, 0.5)], meridian: quartic };

/// The cases of these families.
pub fn cases() -> Vec<Case> {
    let span = Span::Seconds(SECONDS);
    let mut cases = vec![];
    for (kind, spin) in [(ROLLING_SOLID, 7.0), (ROLLING_HOLLOW, -11.0)] {
        cases.push(Case::new(
            format!("B8/{}", kind.name),
            "spin and axial speed turn into each other along a parabolic cylinder",
            [
                Demand::over_ticks("amplitude", "m/s", span, 1e-11),
                Demand::over_ticks("phase", "rad", span, 1e-11),
            ],
            move || along_a_cylinder(kind, spin),
        ));
        for floor in [PARABOLOID, QUARTIC] {
            cases.push(Case::new(
                format!("B9/{}-{}", floor.name, kind.name),
                "Routh's two invariants on a surface of revolution",
                [
                    Demand::over_ticks("distance from the axis times speed about it", "m^2/s", span, 1e-11),
                    Demand::over_ticks("spin about the normal times radius", "m/s", span, 1e-11),
                ],
                move || on_revolution(kind, floor, spin),
            ));
        }
    }
    cases
}
