//! B15: a ball released a distance d up a slope above a vertical wall. Between hits it falls with a = g sin(alpha)/(1+k); each
//! hit leaves e of its speed. Hits at `t0 (1 + 2 (e + ... + e^n))`, t0^2 = 2 d/a, the last at `t0 (1+e)/(1-e)` after a path
//! of `d (1+e^2)/(1-e^2)`.

use super::{KINDS, Kind, with};
use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::ride::{Largest, miscount, run};
use crate::scenes::{center, graph};
use ballroom_physics::tolerance::REST_SPEED;
use ballroom_physics::{Scene, SceneFault};
use nalgebra::Vector3;

const SLOPE: f64 = 0.75;
const HALF: f64 = 16.0;
const RADIUS: f64 = 0.5;
const DISTANCE: f64 = 5.0;

fn acceleration(kind: Kind) -> f64 {
    9.81 * 0.6 / (1.0 + kind.k)
}

fn scene(kind: Kind, restitution: f64) -> Scene {
    // A horizontal distance of 4/5 of that along the slope.
    let ball = kind.ball(RADIUS, center(-HALF + RADIUS + 0.8 * DISTANCE, 0.0));
    let mut scene = with(graph(HALF, &[(1, 0, SLOPE)], kind.motion), ball);
    scene.restitution = restitution;
    scene
}

/// Time of hit n, from 0, in units of the first.
fn hit_time(e: f64, n: i32) -> f64 {
    1.0 + 2.0 * e * (1.0 - e.powi(n)) / (1.0 - e)
}

/// Times of the hits that are faster than the rest speed, the centre before them and their number; the end's time and
/// path, from what the last hit leaves.
fn measure(kind: Kind, e: f64) -> Result<[f64; 5], SceneFault> {
    let a = acceleration(kind);
    let first = (2.0 * DISTANCE / a).sqrt();
    let speed = a * first;
    // The wall sees the horizontal part.
    let count = (REST_SPEED / (0.8 * speed)).log(e).ceil() as i32;
    let end = first * (1.0 + e) / (1.0 - e);
    let wall = Vector3::new(-HALF + RADIUS, 0.0, SLOPE * (-HALF + RADIUS) + 1.25 * RADIUS);
    let uphill = Vector3::new(0.8, 0.0, 0.6);
    let mut largest = [Largest::default(); 2];
    let (mut hits, mut path, mut end_seen) = (0, 0.0, 0.0);
    run(&scene(kind, e), 240, (end * 240.0) as u64 + 60, |tick, engine| {
        for hit in engine.hits() {
            // What follows is the business of rest.
            if hits < count {
                largest[0].see(hit.time.seconds() - first * hit_time(e, hits));
                // The impulse is (1+e) times mass times the speed, whose flight was of so high and so long.
                let mass = 1.0 + kind.k;
                let speed = hit.impulse * 0.8 / (mass * (1.0 + e));
                path += speed * speed / (2.0 * a) * if hits == 0 { 1.0 } else { 2.0 };
                end_seen = hit.time.seconds() + 2.0 * e * speed / a / (1.0 - e);
            }
            hits += 1;
        }
        let t = tick as f64 / 240.0;
        let n = (0..count).find(|n| first * hit_time(e, *n) > t).unwrap_or(count);
        if n < count {
            let (rise, since) = if n == 0 {
                (DISTANCE - 0.5 * a * t * t, 0.0)
            } else {
                (0.0, t - first * hit_time(e, n - 1))
            };
            let up = rise + since * (speed * e.powi(n) - 0.5 * a * since);
            largest[1].see_center(&engine.ball(0), wall + uphill * up);
        }
    })?;
    let exact_path = DISTANCE * (1.0 + e * e) / (1.0 - e * e);
    let shortfall = miscount(u64::from(hits < count), 0);
    Ok([largest[0].value(), largest[1].value(), shortfall, (end_seen - end).abs(), (path - exact_path).abs()])
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![];
    for kind in KINDS {
        for e in [0.5, 0.9] {
            let first = (2.0 * DISTANCE / acceleration(kind)).sqrt();
            let span = Span::Seconds((first * (1.0 + e) / (1.0 - e) * 10.0).ceil() / 10.0);
            cases.push(Case::new(
                format!("B15/{}-{e}", kind.name),
                "bouncing against a wall down a slope",
                [
                    Demand {
                        norm: "largest over hits",
                        ..Demand::over_ticks("time of impact", "s", span, 1e-12)
                    },
                    Demand::over_ticks("centre until the rest speed", "m", span, 1e-12),
                    Demand::never("fewer hits than down to the rest speed", span),
                    Demand::at_the_end("time of the end", "s", span, 1e-9),
                    Demand::at_the_end("path", "m", span, 1e-11),
                ],
                move || measure(kind, e),
            ));
        }
    }
    cases
}
