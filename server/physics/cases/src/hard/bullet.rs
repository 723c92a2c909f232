//! H5, H6, H7, H26: fast, grazing, tiny.

use super::rods::rods;
use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::ride::{Largest, hits, run};
use crate::scenes::{center, in_list_order, moving, plane, random, still, walls};
use ballroom_physics::{BallSpec, Place, SceneFault};
use nalgebra::{Vector2, Vector3};

/// A bullet of a thousand diameters a tick between two walls, and a thin target at rest: as rods on a line.
fn bullet() -> Result<[f64; 1], SceneFault> {
    let mut scene = plane(16.0);
    scene.walls = walls([-8.0, 8.0], [-8.0, 8.0]);
    let radius = 1.0 / 64.0;
    let speed = 1000.0 * 2.0 * radius * 60.0;
    let starts = [(-3.0, speed), (2.5, 0.0)];
    scene.balls = starts
        .iter()
        .enumerate()
        .map(|(n, (x, v))| moving(&format!("{n}"), radius, center(*x, 0.0), *v, 0.0))
        .collect();
    let mut largest = Largest::default();
    run(&scene, 60, 60, |tick, engine| {
        for (ball, x) in engine.balls().zip(rods(&starts, radius, [-8.0, 8.0], tick as f64 / 60.0)) {
            largest.see_center(&ball, Vector3::new(x, 0.0, radius));
        }
    })?;
    Ok([largest.value()])
}

/// A speck of 1 mm comes a kilometre to meet another off centre. Equal masses part at right angles: along the line of
/// centres, which b = R/2 turns by 30 degrees, and across it. Relative errors of both velocities.
fn speck() -> Result<[f64; 2], SceneFault> {
    let (radius, v) = (1e-3, 64.0);
    let mut scene = plane(1024.0);
    scene.balls =
        vec![moving("0", radius, center(-1000.0, radius), v, 0.0), still("1", radius, center(0.0, 0.0))];
    let engine = run(&scene, 1, 16, |_, _| {})?;
    let (sin, cos) = (0.5, 0.75_f64.sqrt());
    let exact = [Vector3::new(sin * sin, sin * cos, 0.0) * v, Vector3::new(cos * cos, -sin * cos, 0.0) * v];
    let [a, b] = [engine.ball(0).velocity, engine.ball(1).velocity];
    Ok([(a - exact[0]).norm() / v, (b - exact[1]).norm() / v])
}

/// Whether one ball passing another at rest at (1 + margin) diameters hits: verdicts that are wrong.
fn grazes_along_an_axis() -> Result<[f64; 1], SceneFault> {
    let mut wrong = 0;
    for exponent in 3..=14 {
        for sign in [-1.0, 1.0] {
            let margin = sign * 10.0_f64.powi(-exponent);
            for offset in [0.0, 0.123, 0.777] {
                let mut scene = plane(16.0);
                scene.balls = vec![
                    moving("a", 0.5, center(-5.0 + offset, 1.0 + margin), 3.0, 0.0),
                    still("b", 0.5, center(0.0, 0.0)),
                ];
                let engine = run(&scene, 60, 180, |_, _| {})?;
                wrong += u32::from(hits(&engine) != u64::from(margin < 0.0));
            }
        }
    }
    Ok([f64::from(wrong)])
}

/// A line through the plane whose distance from the origin is known exactly, in units of 2^-40 m and of 2^-18 m/s: a
/// point p and a direction v with integer coordinates and p x v = `cross` exactly, p some metres before the origin.
struct Line {
    p: [i64; 2],
    v: [i64; 2],
}

/// Scale of a line's points and of its velocities.
const PLACE: f64 = 1.0 / (1_u64 << 40) as f64;
const SPEED: f64 = 1.0 / (1_u64 << 18) as f64;

impl Line {
    /// A random line at about (1 + margin) metres from the origin, on the far side of that distance from 1 m.
    fn random(next: &mut impl FnMut() -> f64, margin: f64) -> Self {
        loop {
            let mut part = || ((2.0 * next() - 1.0) * 1_048_576.0) as i64;
            let v = [part(), part()];
            let (gcd, x, y) = extended_gcd(v[0], v[1]);
            let size = i128::from(v[0]).pow(2) + i128::from(v[1]).pow(2);
            if gcd != 1 || size < 1 << 36 {
                continue;
            }
            // |p x v| = |v| (1 + margin), rounded to an integer: 1e-18 of it.
            let cross = ((size as f64).sqrt() * (1.0 + margin) / PLACE) as i128;
            // p0 = cross (y, -x)/gcd has p0 x v = cross (v . (x, y)) = cross; others differ by multiples of v.
            let p0 = [cross * i128::from(y), -cross * i128::from(x)];
            // About 5 m before the foot of the perpendicular.
            let along = p0[0] * i128::from(v[0]) + p0[1] * i128::from(v[1]);
            let back = (5.0 / PLACE * (size as f64).sqrt()) as i128;
            let k = (along + back) / size;
            let p = [p0[0] - k * i128::from(v[0]), p0[1] - k * i128::from(v[1])];
            return Self { p: p.map(|c| i64::try_from(c).expect("a few metres")), v };
        }
    }

    /// Whether the line comes nearer to the origin than 1 m, decided in integers.
    fn hits(&self) -> bool {
        let [p, v] = [self.p, self.v].map(|q| q.map(i128::from));
        let cross = p[0] * v[1] - p[1] * v[0];
        let size = v[0] * v[0] + v[1] * v[1];
        // (p x v)^2 < v^2 2^80, as p x v < |v| 2^40 without overflow.
        wide_square(cross.unsigned_abs()) < wide_product(size.unsigned_abs(), 1 << 80)
    }
}

/// x a + y b = gcd.
fn extended_gcd(a: i64, b: i64) -> (i64, i64, i64) {
    if b == 0 {
        return (a.abs(), a.signum(), 0);
    }
    let (gcd, x, y) = extended_gcd(b, a % b);
    (gcd, y, x - a / b * y)
}

/// The product as high and low half: 128 bits are not enough for both sides of a graze.
fn wide_product(a: u128, b: u128) -> (u128, u128) {
    let half = |x: u128| (x >> 64, x & u128::from(u64::MAX));
    let ((a1, a0), (b1, b0)) = (half(a), half(b));
    let (low, mid, other) = (a0 * b0, a1 * b0, a0 * b1);
    let carry = (low >> 64) + (mid & u128::from(u64::MAX)) + (other & u128::from(u64::MAX));
    let high = a1 * b1 + (mid >> 64) + (other >> 64) + (carry >> 64);
    (high, (carry << 64) | (low & u128::from(u64::MAX)))
}

fn wide_square(a: u128) -> (u128, u128) {
    wide_product(a, a)
}

/// Wrong verdicts and the largest change of velocity for random lines that pass at (1 + margin) of the reach.
fn grazes_at_random(margin: f64, lines: u64) -> Result<[f64; 1], SceneFault> {
    let mut next = random(margin.to_bits());
    let mut wrong = 0;
    for _ in 0..lines {
        let line = Line::random(&mut next, margin);
        let p = Vector2::new(line.p[0] as f64, line.p[1] as f64) * PLACE;
        let v = Vector2::new(line.v[0] as f64, line.v[1] as f64) * SPEED;
        let mut scene = plane(16.0);
        scene.balls = vec![moving("a", 0.5, Place::Center(p), v.x, v.y), still("b", 0.5, center(0.0, 0.0))];
        let engine = run(&scene, 1, (10.0 / v.norm()).ceil() as u64, |_, _| {})?;
        wrong += u32::from((engine.report().collisions.ball_ball > 0) != line.hits());
    }
    Ok([f64::from(wrong)])
}

/// Change of velocity in a pass at exactly one reach, relative to the speed.
fn tangency() -> Result<[f64; 1], SceneFault> {
    let mut scene = plane(16.0);
    scene.balls = vec![moving("a", 0.5, center(-5.0, 1.0), 3.0, 0.0), still("b", 0.5, center(0.0, 0.0))];
    let engine = run(&scene, 60, 180, |_, _| {})?;
    Ok([(engine.ball(0).velocity - Vector3::new(3.0, 0.0, 0.0)).norm() / 3.0])
}

/// A ball onto one a thousand times as large and 1e9 times as heavy: errors of both places after 2 s, of the light one in
/// metres, of the heavy one, which goes 4 nm, over its way. The centres lie at heights of their own, so that they meet when
/// a horizontal leg closes the reach.
fn a_thousand_to_one() -> Result<[f64; 2], SceneFault> {
    let mut scene = plane(16.0);
    let small = BallSpec { mass: 1e-9, ..moving("small", 0.001, center(-6.0, 0.0), 4.0, 0.0) };
    let large = BallSpec { mass: 1.0, ..still("large", 1.0, center(0.0, 0.0)) };
    scene.balls = vec![small, large];
    let engine = run(&scene, 60, 120, |_, _| {})?;
    let balls = in_list_order(&engine);
    let leg = (1.001_f64 * 1.001 - 0.999 * 0.999).sqrt();
    let hit = (6.0 - leg) / 4.0;
    let [heavy, light] = [1.0, 1e-9];
    let turned = 4.0 * (light - heavy) / (light + heavy);
    let exact = -leg + turned * (2.0 - hit);
    let pushed = 8.0 * light / (light + heavy) * (2.0 - hit);
    Ok([(balls[0].center.x - exact).abs(), (balls[1].center.x / pushed - 1.0).abs()])
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![
        Case::new(
            "H5/bullet",
            "a thousand diameters a tick, walls and a thin target",
            [Demand::over_ticks("centres", "m", Span::Seconds(1.0), 1e-12)],
            bullet,
        ),
        Case::new(
            "H6/axis",
            "passes at 1 - 1e-3 to 1 + 1e-14 of the reach",
            [Demand::never("wrong verdicts", Span::Runs(72))],
            grazes_along_an_axis,
        ),
        Case::new(
            "H7/tangency",
            "a pass at exactly the reach",
            [Demand::at_the_end("velocity, relative", "1", Span::Seconds(3.0), 1e-7)],
            tangency,
        ),
        Case::new(
            "H26/radii",
            "a ball onto one a thousand times as large",
            [("light ball", "m"), ("heavy ball, relative to its way", "1")]
                .map(|(ball, unit)| Demand::at_the_end(ball, unit, Span::Seconds(2.0), 1e-12)),
            a_thousand_to_one,
        ),
        Case::new(
            "X3/speck",
            "a speck of 1 mm meets another off centre after a kilometre",
            ["velocity of the first, relative", "velocity of the second, relative"]
                .map(|quantity| Demand::at_the_end(quantity, "1", Span::Seconds(16.0), 1e-12)),
            speck,
        ),
    ];
    for (name, margin) in [
        ("-1e-9", -1e-9),
        ("1e-9", 1e-9),
        ("-1e-12", -1e-12),
        ("1e-12", 1e-12),
        ("-1e-14", -1e-14),
        ("1e-14", 1e-14),
        ("-1e-15", -1e-15),
        ("1e-15", 1e-15),
    ] {
        cases.push(Case::new(
            format!("H6/random{name}"),
            format!("random lines that pass at 1 + {margin:e} of the reach, decided in integers"),
            [Demand::never("wrong verdicts", Span::Runs(2000))],
            move || grazes_at_random(margin, 2000),
        ));
    }
    cases
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_on_the_side_that_was_asked_for() {
        let mut next = random(5);
        for _ in 0..1000 {
            assert!(Line::random(&mut next, -1e-15).hits());
            assert!(!Line::random(&mut next, 1e-15).hits());
        }
    }
}
