//! B4: horizontal circles in a paraboloid. Sliding `W^2 = g kappa/(1 - r kappa cos)`; rolling, with spin sigma/r,
//! `(1+k) rho cos W^2 + k sigma sin W - g sin = 0`. Seen from the turning frame the angular velocity stands still, so that
//! the orientation is a turn about it after a turn about the vertical.

use super::{Kind, ROLLING_HOLLOW, ROLLING_SOLID, SLIDING, with};
use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::references::angle_between;
use crate::ride::{Largest, run};
use crate::scenes::{contact, graph};
use ballroom_physics::{BallSpec, MotionLaw, SceneFault};
use nalgebra::{UnitQuaternion, Vector3};

const SECONDS: f64 = 10.0;
const RADIUS: f64 = 0.2;

/// Centre, velocity, spin and orientation. `spin` is the angular velocity about the normal, rad/s.
fn measure(kind: Kind, spin: f64) -> Result<[f64; 4], SceneFault> {
    let (kappa, r, g, tangent) = (0.5_f64, RADIUS, 9.81, 0.45_f64);
    let (sin, cos) = tangent.atan().sin_cos();
    let contact_radius = tangent / kappa;
    let rho = contact_radius - r * sin;
    let height = tangent * tangent / (2.0 * kappa) + r * cos;
    let rate = if kind.motion == MotionLaw::Frictionless {
        (g * kappa / (1.0 - r * kappa * cos)).sqrt()
    } else {
        let [a, b, c] = [(1.0 + kind.k) * rho * cos, kind.k * r * spin * sin, -g * sin];
        (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
    };
    let velocity = Vector3::new(0.0, rate * rho, 0.0);
    let normal = Vector3::new(-sin, 0.0, cos);
    // A sliding ball keeps the spin it has about the first normal.
    let rolls = kind.motion == MotionLaw::Rolling;
    let omega = normal * spin + if rolls { normal.cross(&velocity) / r } else { Vector3::zeros() };
    let turning = Vector3::new(0.0, 0.0, if rolls { rate } else { 0.0 });
    let ball = BallSpec { velocity, spin, ..kind.ball(r, contact(contact_radius, 0.0)) };
    let scene = with(graph(2.0, &[(2, 0, 0.25), (0, 2, 0.25)], kind.motion), ball);
    let mut largest = [Largest::default(); 4];
    run(&scene, 60, (60.0 * SECONDS) as u64, |tick, engine| {
        let t = tick as f64 / 60.0;
        let ball = engine.ball(0);
        let (sin, cos) = (rate * t).sin_cos();
        largest[0].see_center(&ball, Vector3::new(rho * cos, rho * sin, height));
        largest[1].see((ball.velocity - Vector3::new(-sin, cos, 0.0) * (rho * rate)).norm());
        let around = UnitQuaternion::from_scaled_axis(turning * t);
        largest[2].see((ball.omega - around * omega).norm());
        let exact = around * UnitQuaternion::from_scaled_axis((omega - turning) * t);
        largest[3].see(angle_between(&ball, &exact));
    })?;
    Ok(largest.map(Largest::value))
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let span = Span::Seconds(SECONDS);
    [
        (SLIDING, 3.0),
        (ROLLING_SOLID, 0.0),
        (ROLLING_HOLLOW, 0.0),
        (ROLLING_SOLID, 20.0),
        (ROLLING_HOLLOW, -13.0),
    ]
    .into_iter()
    .map(|(kind, spin)| {
        let suffix = if spin == 0.0 { "" } else { "-spinning" };
        Case::new(
            format!("B4/{}{suffix}", kind.name),
            "a horizontal circle in a paraboloid",
            [
                Demand::over_ticks("centre", "m", span, 1e-12),
                Demand::over_ticks("velocity", "m/s", span, 1e-11),
                Demand::over_ticks("angular velocity", "rad/s", span, 1e-11 / RADIUS),
                Demand::over_ticks("orientation", "rad", span, 1e-12 / RADIUS),
            ],
            move || measure(kind, spin),
        )
    })
    .collect()
}
