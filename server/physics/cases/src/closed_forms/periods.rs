//! B1, B2, B3 and the pit: periods by elliptic integrals and quadrature; numbers by `generators/periods.py`.

use super::{Kind, ROLLING_HOLLOW, ROLLING_SOLID, SLIDING, with};
use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::scenes::{contact, graph, pit_floor, scene};
use ballroom_physics::{BallSpec, Controller, Scene, SceneFault, Time};
use nalgebra::Vector3;

/// Back at rest where it was released after a period: by what time it misses rest, s, and by how much the place, m.
fn missed(scene: &Scene, period: f64) -> Result<[f64; 2], SceneFault> {
    let mut engine = Controller::new(scene)?;
    let start = engine.ball(0);
    let step = 1e-3;
    engine.advance_to(Time::of_seconds(step));
    let acceleration = engine.ball(0).velocity.norm() / step;
    // Early and late ticks between must not matter.
    engine.advance_to(Time::of_seconds(0.7 * period));
    engine.advance_to(Time::of_seconds(period));
    let ball = engine.ball(0);
    Ok([ball.velocity.norm() / acceleration, (ball.center - start.center).norm()])
}

/// When a ball that moves in and out is turned next near `guess`: a zero of c . w in the plane, by secants.
fn turn(scene: &Scene, guess: f64) -> Result<f64, SceneFault> {
    let mut before = Controller::new(scene)?;
    before.advance_to(Time::of_seconds(guess - 0.05));
    let pace = |t: f64| {
        let mut engine = before.clone();
        engine.advance_to(Time::of_seconds(t));
        let ball = engine.ball(0);
        ball.center.xy().dot(&ball.velocity.xy())
    };
    let (mut last, mut t) = (guess - 0.01, guess);
    let (mut slow, mut pace_now) = (pace(last), pace(t));
    for _ in 0..20 {
        if t == last || pace_now == slow {
            break;
        }
        let next = t - pace_now * (t - last) / (pace_now - slow);
        (last, slow) = (t, pace_now);
        (t, pace_now) = (next, pace(next));
    }
    Ok(t)
}

/// The period of a bead is that of a ball of radius 0: extrapolated from five small radii, in which it is analytic.
fn bead(scene: &Scene, period: f64) -> Result<[f64; 1], SceneFault> {
    let mut sum = 0.0;
    for (n, weight) in (1..).zip([5.0, -10.0, 10.0, -5.0, 1.0]) {
        let mut scene = scene.clone();
        scene.balls[0].radius = 1e-3 * f64::from(n);
        sum += weight * turn(&scene, period)?;
    }
    Ok([(sum - period).abs()])
}

fn in_the_pit(kind: Kind) -> Scene {
    let border = [-10.0, 10.0];
    let mut scene = scene(pit_floor(false), border, border, kind.motion);
    scene.gravity = Vector3::new(0.0, 0.0, -9.8);
    with(scene, kind.ball(1.0, contact(-3.0, 0.0)))
}

fn on_the_parabola(kind: Kind, radius: f64) -> Scene {
    with(graph(3.0, &[(2, 0, 0.75)], kind.motion), kind.ball(radius, contact(0.8, 0.0)))
}

fn released(id: String, title: &str, scene: Scene, period: f64, limit: f64) -> Case {
    let span = Span::Seconds(period);
    let demands =
        [Demand::at_the_end("period", "s", span, limit), Demand::at_the_end("place", "m", span, limit)];
    Case::new(id, title, demands, move || missed(&scene, period))
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![];
    for (kind, period) in [
        (SLIDING, 2.135_585_674_238_205),
        (ROLLING_SOLID, 2.526_859_046_487_561_5),
        (ROLLING_HOLLOW, 2.757_029_250_241_235_3),
    ] {
        let id = format!("B2/pit-{}", kind.name);
        cases.push(released(id, "a swing in the pit", in_the_pit(kind), period, 1e-11));
    }
    for (kind, period) in [(SLIDING, 1.909_591_921_611_005_3), (ROLLING_SOLID, 2.259_459_632_282_643)] {
        let id = format!("B2/{}", kind.name);
        let scene = on_the_parabola(kind, 0.2);
        cases.push(released(id, "a swing across a parabolic cylinder", scene, period, 1e-11));
    }
    let orbit = BallSpec { velocity: Vector3::new(0.0, 1.1, 0.0), ..SLIDING.ball(1.0, contact(0.9, 0.0)) };
    let paraboloid = with(graph(3.0, &[(2, 0, 0.75), (0, 2, 0.75)], SLIDING.motion), orbit);
    for (id, title, scene, period) in [
        ("B1/sliding", "a bead in a parabola", on_the_parabola(SLIDING, 1.0), 2.123_572_137_222_319),
        (
            "B1/solid",
            "the same rolls root 7/5 slower",
            on_the_parabola(ROLLING_SOLID, 1.0),
            2.512_644_437_794_921,
        ),
        ("B3/sliding", "in and out on an orbit in a paraboloid", paraboloid, 1.146_682_140_637_624_2),
    ] {
        cases.push(Case::new(
            id,
            title,
            [Demand {
                norm: "limit from five radii",
                ..Demand::at_the_end("period", "s", Span::Seconds(period), 1e-10)
            }],
            move || bead(&scene, period),
        ));
    }
    cases
}
