//! H12, H13: hits that take energy, as far as nothing comes to rest.

use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::ride::{Largest, miscount, run};
use crate::scenes::{center, contact, graph, moving, plane, still};
use ballroom_physics::{MotionLaw, Scene, SceneFault, Wall};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::FRAC_PI_4;

/// Below it a hit is taken without rebound, so that times are compared above it, m/s.
const SLOWEST: f64 = 1e-5;

/// B17: beads on a wall collapse, with hits without end in a finite time, where e is below tan^2(pi/4 (1 - 1/N)).
fn collapse(beads: u32) -> f64 {
    (FRAC_PI_4 * (1.0 - 1.0 / f64::from(beads))).tan().powi(2)
}

/// A wall, a bead at rest and one that comes: above the threshold the velocities alone say how often they hit, since the
/// inner bead hits wall and outer bead by turns.
fn hits_of_two_beads(e: f64) -> u64 {
    let (mut inner, mut outer) = (0.0, -1.0);
    for hits in 0.. {
        if inner > outer {
            let (mean, half) = (0.5 * (inner + outer), 0.5 * (inner - outer));
            (inner, outer) = (mean - e * half, mean + e * half);
        } else if inner < 0.0 {
            inner *= -e;
        } else {
            return hits;
        }
    }
    unreachable!("the sequence ends above the threshold")
}

/// Beads between a wall and one that comes fast, so that the last hits are still no rest.
fn beads(count: u32, e: f64) -> Scene {
    let mut scene = plane(65_536.0);
    scene.restitution = e;
    for n in 1..count {
        scene.balls.push(still(&format!("{n}"), 0.25, center(f64::from(n), 0.0)));
    }
    scene.balls.push(moving("last", 0.25, center(f64::from(count) + 8.0, 0.0), -16_384.0, 0.0));
    scene.walls.push(Wall { point: Vector2::zeros(), normal: Vector2::x() });
    scene
}

fn above_collapse(factor: f64) -> Result<[f64; 1], SceneFault> {
    let e = collapse(2) * factor;
    let engine = run(&beads(2, e), 1, 60, |_, _| {})?;
    let collisions = engine.report().collisions;
    Ok([miscount(collisions.ball_ball + collisions.ball_wall, hits_of_two_beads(e))])
}

/// Below the threshold: hits beyond 10 000, rises of the energy over the last tick's, overlap in radii.
fn below_collapse(count: u32) -> Result<[f64; 3], SceneFault> {
    let scene = beads(count, collapse(count) * 0.97);
    let (mut before, mut rises) = (f64::INFINITY, 0.0);
    let mut overlap = Largest::default();
    let engine = run(&scene, 60, 600, |_, engine| {
        let energy = engine.energy();
        rises += f64::from(u8::from(energy > before * (1.0 + 1e-15)));
        before = energy;
        overlap.see((0.25 - engine.balls().map(|ball| ball.center.x).fold(0.25, f64::min)).max(0.0));
        for (n, ball) in engine.balls().enumerate() {
            for other in engine.balls().take(n) {
                overlap.see((0.5 - (ball.center - other.center).norm()).max(0.0));
            }
        }
    })?;
    let collisions = engine.report().collisions;
    let many = collisions.ball_ball + collisions.ball_wall > 10_000;
    Ok([f64::from(u8::from(many)), rises, overlap.value() / 0.25])
}

/// B15 on its side: a ball released `height` from a wall under an acceleration towards it. Hits come at t1 = sqrt(2h/a),
/// then after 2 v e/a, 2 v e^2/a and so on with v = sqrt(2 a h). Largest error of a hit's time, s, and of the count,
/// until the closing speed falls below [`SLOWEST`].
fn bounces(scene: &Scene, height: f64, acceleration: f64, seconds: u64) -> Result<[f64; 2], SceneFault> {
    let e = scene.restitution;
    let speed = (2.0 * acceleration * height).sqrt();
    let mut times = vec![];
    run(scene, 1, seconds, |_, engine| times.extend(engine.hits().iter().map(|hit| hit.time.seconds())))?;
    let (mut exact, mut flight) = ((2.0 * height / acceleration).sqrt(), 2.0 * speed / acceleration);
    let (mut largest, mut closing, mut counted) = (Largest::default(), speed, 0);
    while closing > SLOWEST && exact < seconds as f64 {
        largest.see(times.get(counted).copied().unwrap_or(f64::INFINITY) - exact);
        counted += 1;
        closing *= e;
        flight *= e;
        exact += flight;
    }
    // Elastic bounces go on until the end; others also hit at speeds that are not compared.
    let extra = if e < 1.0 { 0 } else { times.len().abs_diff(counted) };
    Ok([largest.value(), extra as f64])
}

/// A level floor under gravity that leans to the west; the wall is the border at -8.
fn leaning(e: f64, motion: MotionLaw) -> Result<[f64; 2], SceneFault> {
    let mut scene = graph(8.0, &[], motion);
    scene.gravity = Vector3::new(-2.0, 0.0, -9.81);
    scene.restitution = e;
    scene.balls = vec![still("ball", 0.25, center(-6.75, 0.0))];
    let k = if motion == MotionLaw::Rolling { 0.4 } else { 0.0 };
    bounces(&scene, 1.0, 2.0 / (1.0 + k), if e < 1.0 { 60 } else { 1000 })
}

/// An incline of slope 3/4 down to the wall at -8; what counts is the way along x.
fn incline(e: f64, motion: MotionLaw) -> Result<[f64; 2], SceneFault> {
    let mut scene = graph(8.0, &[(1, 0, 0.75)], motion);
    scene.restitution = e;
    // The centre lies 3/5 of a radius west of the contact.
    scene.balls = vec![still("ball", 0.25, contact(-6.75 + 0.15, 0.0))];
    let k = if motion == MotionLaw::Rolling { 0.4 } else { 0.0 };
    bounces(&scene, 1.0, 9.81 * 0.6 * 0.8 / (1.0 + k), if e < 1.0 { 60 } else { 1000 })
}

/// Errors of hits at a restitution under a law of motion.
type Measure = fn(f64, MotionLaw) -> Result<[f64; 2], SceneFault>;

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![];
    for factor in [1.03, 1.1, 1.3, 2.0] {
        cases.push(Case::new(
            format!("H12/above-{factor}"),
            format!("two beads on a wall, e {factor} times that of collapse"),
            [Demand::count("hits", Span::Seconds(60.0))],
            move || above_collapse(factor),
        ));
    }
    for count in [2, 3, 4] {
        cases.push(Case::new(
            format!("H12/below-{count}"),
            format!("{count} beads on a wall, e 0.97 times that of collapse"),
            [
                Demand::never("more than 10 000 hits", Span::Seconds(10.0)),
                Demand::never("rises of energy", Span::Seconds(10.0)),
                Demand::over_ticks("overlap", "r", Span::Seconds(10.0), 1e-9),
            ],
            move || below_collapse(count),
        ));
    }
    let grounds: [(&str, &str, Measure); 2] =
        [("leaning", "under leaning gravity", leaning), ("incline", "down an incline", incline)];
    for (name, title, measure) in grounds {
        for (law, motion) in [("slide", MotionLaw::Frictionless), ("roll", MotionLaw::Rolling)] {
            for e in [0.5, 0.9, 1.0] {
                let (seconds, limit) = if e < 1.0 { (60.0, 1e-12) } else { (1000.0, 1e-10) };
                cases.push(Case::new(
                    format!("H13/{name}-{e}-{law}"),
                    format!("bounces from a wall {title}, e = {e}, down to 1e-5 m/s"),
                    [
                        Demand::over_ticks("time of a hit", "s", Span::Seconds(seconds), limit),
                        Demand::count("hits", Span::Seconds(seconds)),
                    ],
                    move || measure(e, motion),
                ));
            }
        }
    }
    cases
}
