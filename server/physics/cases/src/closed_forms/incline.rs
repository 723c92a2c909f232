//! B0: the plane z = 3/4 x. The centre falls with g sin(alpha)/(1+k) along a parabola, whatever the spin; straight down, a
//! rolling ball turns by its path over its radius.

use super::{KINDS, Kind, with};
use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::references::angle_between;
use crate::ride::{Largest, run};
use crate::scenes::{contact, graph};
use ballroom_physics::{BallSpec, MotionLaw, SceneFault};
use nalgebra::{UnitQuaternion, Vector3};

const SLOPE: f64 = 0.75;
const SECONDS: f64 = 3.0;

fn scene(kind: Kind, velocity: Vector3<f64>, spin: f64) -> ballroom_physics::Scene {
    let ball = BallSpec { velocity, spin, ..kind.ball(0.5, contact(3.0, -7.0)) };
    with(graph(100.0, &[(1, 0, SLOPE)], kind.motion), ball)
}

fn normal() -> Vector3<f64> {
    Vector3::new(-SLOPE, 0.0, 1.0).normalize()
}

fn acceleration(kind: Kind) -> Vector3<f64> {
    Vector3::new(-1.0, 0.0, -SLOPE).normalize() * (9.81 * 0.6 / (1.0 + kind.k))
}

/// Thrown across the slope: centre, velocity, slip and spin.
fn thrown(kind: Kind, spin: f64) -> Result<[f64; 4], SceneFault> {
    let start = Vector3::new(3.0, -7.0, 2.25) + 0.5 * normal();
    let velocity = Vector3::new(2.0, 3.0, 1.5);
    let mut largest = [Largest::default(); 4];
    run(&scene(kind, velocity, spin), 60, (60.0 * SECONDS) as u64, |tick, engine| {
        let t = tick as f64 / 60.0;
        let ball = engine.ball(0);
        largest[0].see_center(&ball, start + velocity * t + acceleration(kind) * (0.5 * t * t));
        largest[1].see((ball.velocity - (velocity + acceleration(kind) * t)).norm());
        if kind.motion == MotionLaw::Rolling {
            largest[2].see((ball.velocity - ball.omega.cross(&(0.5 * normal()))).norm());
        }
        largest[3].see(ball.omega.dot(&normal()) - spin);
    })?;
    Ok(largest.map(Largest::value))
}

/// Released: orientation.
fn straight_down(kind: Kind) -> Result<[f64; 1], SceneFault> {
    let axis = normal().cross(&acceleration(kind));
    let mut largest = Largest::default();
    run(&scene(kind, Vector3::zeros(), 0.0), 60, (60.0 * SECONDS) as u64, |tick, engine| {
        let t = tick as f64 / 60.0;
        let exact = UnitQuaternion::from_scaled_axis(axis * (0.5 * t * t / 0.5));
        largest.see(angle_between(&engine.ball(0), &exact));
    })?;
    Ok([largest.value()])
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let span = Span::Seconds(SECONDS);
    let mut cases = vec![];
    for kind in KINDS {
        for (suffix, spin) in [("", 0.0), ("-spinning", 12.0)] {
            cases.push(Case::new(
                format!("B0/{}{suffix}", kind.name),
                "thrown across an incline",
                [
                    Demand::over_ticks("centre", "m", span, 1e-12),
                    Demand::over_ticks("velocity", "m/s", span, 1e-12),
                    Demand::over_ticks("slip", "m/s", span, 1e-12),
                    Demand::over_ticks("spin about the normal", "rad/s", span, 1e-12),
                ],
                move || thrown(kind, spin),
            ));
        }
        if kind.motion == MotionLaw::Rolling {
            cases.push(Case::new(
                format!("B0/{}-straight", kind.name),
                "released on an incline",
                [Demand::over_ticks("orientation", "rad", span, 1e-12)],
                move || straight_down(kind),
            ));
        }
    }
    cases
}
