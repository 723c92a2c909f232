//! B17: N equal beads thrown at a wall hit without end if and only if `e < tan^2(pi/4 (1 - 1/N))` (Bernu and Mazighi,
//! J. Phys. A 23, 1990). The oracle is their recursion: beads on a line, one hit after the other.

use super::SLIDING;
use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::ride::{Largest, hits, miscount, run};
use crate::scenes::{center, in_list_order, plane};
use ballroom_physics::tolerance::REST_SPEED;
use ballroom_physics::{BallSpec, Controller, Scene, SceneFault, Time, Wall};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::FRAC_PI_4;

const RADIUS: f64 = 1.0 / 1024.0;

/// The restitution below which N beads collapse.
fn threshold(beads: usize) -> f64 {
    (FRAC_PI_4 * (1.0 - 1.0 / beads as f64)).tan().powi(2)
}

/// Gaps in front of each bead at the start, m: unequal, so that no two hits come at once.
fn gap(bead: usize) -> f64 {
    1.0 + 0.125 * bead as f64
}

/// What is left when hits end.
struct End {
    hits: u64,
    /// Of the last hit, s.
    time: f64,
    velocities: Vec<f64>,
    /// The slowest closing speed of any hit, m/s.
    gentlest: f64,
}

/// One hit after the other; none if they do not end before closing speeds are too small to matter to anyone.
fn recursion(beads: usize, e: f64, speed: f64) -> Option<End> {
    let (mut time, mut gentlest) = (0.0, f64::INFINITY);
    let mut gaps: Vec<f64> = (0..beads).map(gap).collect();
    let mut v = vec![-speed; beads];
    let closing = |v: &[f64], bead: usize| if bead == 0 { -v[0] } else { v[bead - 1] - v[bead] };
    for count in 0.. {
        let times = (0..beads).filter(|b| closing(&v, *b) > 0.0).map(|b| (gaps[b] / closing(&v, b), b));
        let Some((t, bead)) = times.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            return Some(End { hits: count, time, velocities: v, gentlest });
        };
        time += t;
        gentlest = gentlest.min(closing(&v, bead));
        if gentlest < 1e-100 {
            break;
        }
        for other in 0..beads {
            gaps[other] -= closing(&v, other) * t;
        }
        gaps[bead] = 0.0;
        if bead == 0 {
            v[0] *= -e;
        } else {
            let push = 0.5 * (1.0 + e) * closing(&v, bead);
            v[bead - 1] -= push;
            v[bead] += push;
        }
    }
    None
}

fn scene(beads: usize, e: f64, speed: f64) -> Scene {
    let mut scene = plane(4e6);
    scene.restitution = e;
    scene.walls.push(Wall { point: Vector2::zeros(), normal: Vector2::x() });
    let mut x = -RADIUS;
    for bead in 0..beads {
        x += gap(bead) + 2.0 * RADIUS;
        let velocity = Vector3::new(-speed, 0.0, 0.0);
        let ball = SLIDING.ball(RADIUS, center(x, 0.0));
        scene.balls.push(BallSpec { name: format!("{bead:02}"), velocity, ..ball });
    }
    scene
}

/// Number of hits and velocities. The first speed is so large that no hit falls below the rest speed.
fn above(beads: usize, e: f64) -> Result<[f64; 3], SceneFault> {
    let speed = 1_048_576.0;
    let exact = recursion(beads, e, speed).expect("above the threshold hits end");
    let mut engine = Controller::new(&scene(beads, e, speed))?;
    engine.advance_to(Time::of_seconds(exact.time * 1.001));
    let mut largest = Largest::default();
    for (own, v) in in_list_order(&engine).iter().zip(&exact.velocities) {
        largest.see(own.velocity.x / v - 1.0);
    }
    let slow = u64::from(exact.gentlest < 10.0 * REST_SPEED);
    Ok([miscount(hits(&engine), exact.hits), largest.value(), slow as f64])
}

/// What speed is left below the threshold, where the recursion does not end.
fn below(beads: usize, e: f64) -> Result<[f64; 2], SceneFault> {
    let ends = recursion(beads, e, 1.0).is_some();
    let engine = run(&scene(beads, e, 1.0), 1, 60, |_, _| {})?;
    let mut largest = Largest::default();
    engine.balls().for_each(|ball| largest.see(ball.velocity.norm()));
    Ok([miscount(u64::from(ends), 0), largest.value()])
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![];
    for beads in [2, 3, 4, 6, 10] {
        for factor in [1.03, 1.1] {
            let e = threshold(beads) * factor;
            cases.push(Case::new(
                format!("B17/{beads}-above-{factor}"),
                format!("{beads} beads on a wall, {factor} of the threshold: hits end"),
                [
                    Demand::count("hits", Span::Runs(1)),
                    Demand {
                        norm: "largest relative",
                        ..Demand::at_the_end("velocities", "1", Span::Runs(1), 1e-9)
                    },
                    Demand::never("hits near the rest speed", Span::Runs(1)),
                ],
                move || above(beads, e),
            ));
        }
        let e = threshold(beads) * 0.97;
        cases.push(Case::new(
            format!("B17/{beads}-below"),
            format!("{beads} beads on a wall, 0.97 of the threshold: hits do not end and nothing is left"),
            [
                Demand::never("an end of the recursion", Span::Runs(1)),
                Demand::at_the_end("speed", "m/s", Span::Seconds(60.0), 1e-5),
            ],
            move || below(beads, e),
        ));
    }
    cases
}
