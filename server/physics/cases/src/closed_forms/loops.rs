//! Holonomy: a ball that rolls round a closed path comes back turned, by a rotation that is known; and orientation over a
//! million ticks.

use super::{Kind, ROLLING_HOLLOW, ROLLING_SOLID, with};
use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::references::angle_between;
use crate::ride::{Largest, run};
use crate::scenes::{center, contact, graph};
use ballroom_physics::{BallSpec, SceneFault, Wall};
use nalgebra::{UnitQuaternion, Vector2, Vector3};

/// A square on its corner between four walls: 1 m a side, a second each.
fn square(laps: u32, spin: f64) -> Result<[f64; 2], SceneFault> {
    let (r, diagonal) = (0.25, 0.5_f64.sqrt());
    let velocity = Vector3::new(diagonal, diagonal, 0.0);
    let ball = BallSpec { velocity, spin, ..ROLLING_SOLID.ball(r, center(0.0, -diagonal)) };
    let mut scene = with(graph(4.0, &[], ROLLING_SOLID.motion), ball);
    for [x, y] in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]] {
        let normal = Vector2::new(-x, -y);
        scene.walls.push(Wall { point: normal * -(diagonal + r), normal });
    }
    // The path begins at a corner, away from its wall, and meets a wall at every tick.
    let side = |n: u32| {
        let [x, y] = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]][n as usize % 4];
        let w = Vector3::new(x, y, 0.0) * diagonal;
        UnitQuaternion::from_scaled_axis(Vector3::z().cross(&w) / r + Vector3::z() * spin)
    };
    let mut exact = UnitQuaternion::identity();
    let mut largest = [Largest::default(); 2];
    run(&scene, 1, u64::from(4 * laps), |tick, engine| {
        let ball = engine.ball(0);
        if tick > 0 {
            exact = side(tick as u32 - 1) * exact;
        }
        largest[1].see(angle_between(&ball, &exact));
        if tick % 4 == 0 {
            largest[0].see_center(&ball, Vector3::new(0.0, -diagonal, r));
        }
    })?;
    Ok(largest.map(Largest::value))
}

/// | |q| - 1 | and slip over a million ticks on bumps.
fn million(kind: Kind) -> Result<[f64; 2], SceneFault> {
    let velocity = Vector3::new(-0.4, 1.3, 0.0);
    let ball = BallSpec { velocity, spin: -9.0, ..kind.ball(0.25, contact(1.2, -0.7)) };
    let bumps =
        [(2, 0, 0.2), (0, 2, 0.15), (1, 1, 0.05), (3, 0, -0.03), (1, 2, 0.02), (2, 2, 0.01), (0, 4, 0.004)];
    let mut largest = [Largest::default(); 2];
    run(&with(graph(3.0, &bumps, kind.motion), ball), 1000, 1_000_000, |_, engine| {
        let ball = engine.ball(0);
        let square: f64 = ball.orientation.iter().map(|x| x * x).sum();
        largest[0].see(square.sqrt() - 1.0);
        largest[1].see((ball.velocity - ball.omega.cross(&(ball.normal * 0.25))).norm());
    })?;
    Ok(largest.map(Largest::value))
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![];
    for (laps, spin) in [(1, 0.0), (1, 5.0), (100, 5.0)] {
        let span = Span::Seconds(f64::from(4 * laps));
        cases.push(Case::new(
            format!("Q/square-{laps}{}", if spin == 0.0 { "" } else { "-spinning" }),
            format!("round a square {laps} times"),
            [
                Demand::over_ticks("centre", "m", span, 1e-13 * f64::from(laps)),
                Demand::over_ticks("orientation", "rad", span, 1e-13 * f64::from(laps)),
            ],
            move || square(laps, spin),
        ));
    }
    for kind in [ROLLING_SOLID, ROLLING_HOLLOW] {
        let span = Span::Seconds(1000.0);
        cases.push(Case::new(
            format!("Q/million-{}", kind.name),
            "a million ticks on a floor without symmetry",
            [
                Demand::over_ticks("length of the quaternion less 1", "1", span, 4.0 * f64::EPSILON),
                Demand::over_ticks("slip", "m/s", span, 1e-14),
            ],
            move || million(kind),
        ));
    }
    cases
}
