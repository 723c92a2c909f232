//! H8, H9 and billiards between walls at any angle, unfolded.
//!
//! Walls are vertical planes without ends, at any angle; a room is where a ball is in front of all of them, and so always
//! convex. A wall's direction is a pair of f64, off by up to 4e-16 rad: where hits add that up, the demand says so. A wedge
//! of pi/n and the equilateral triangle are mirrors that unfold the path into one straight line.

use super::rods::rods;
use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::ride::{Largest, hits, miscount, run};
use crate::scenes::{center, graph, moving, plane, random};
use ballroom_physics::{MotionLaw, Place, Scene, SceneFault, Wall};
use nalgebra::{Vector2, Vector3};
use std::f64::consts::{PI, TAU};

type V2 = Vector2<f64>;

/// Radius of the balls here, m.
const RADIUS: f64 = 0.25;

fn unit(angle: f64) -> V2 {
    V2::new(angle.cos(), angle.sin())
}

/// A wall whose plane keeps centres of balls behind a line through `point`.
fn wall(point: V2, normal: V2) -> Wall {
    Wall { point: point - normal * RADIUS, normal }
}

fn ball(place: V2, velocity: V2) -> ballroom_physics::BallSpec {
    moving("ball", RADIUS, Place::Center(place), velocity.x, velocity.y)
}

fn over(place: V2) -> Vector3<f64> {
    Vector3::new(place.x, place.y, RADIUS)
}

/// Largest error of a centre over 20 s of a ball that runs into a corner of two walls again and again.
fn corner(motion: MotionLaw) -> Result<[f64; 1], SceneFault> {
    let mut scene = graph(8.0, &[], motion);
    scene.balls = vec![moving("ball", 0.5, center(4.5, 4.5), 3.0, 3.0)];
    let mut largest = Largest::default();
    run(&scene, 60, 1200, |tick, engine| {
        for x in rods(&[(4.5, 3.0)], 0.5, [-8.0, 8.0], tick as f64 / 60.0) {
            largest.see_center(&engine.ball(0), Vector3::new(x, x, 0.5));
        }
    })?;
    Ok([largest.value()])
}

/// Where centres can be: a wedge of pi/n.
struct Wedge {
    apex: V2,
    /// Direction of the first side; the second is `opening` to its left.
    side: f64,
    opening: f64,
}

impl Wedge {
    fn scene(&self, motion: MotionLaw) -> Scene {
        let mut scene = graph(256.0, &[], motion);
        let sides = [unit(self.side + 0.5 * PI), -unit(self.side + self.opening + 0.5 * PI)];
        scene.walls.extend(sides.map(|normal| wall(self.apex, normal)));
        scene
    }

    /// Angle of a point of the unfolded plane from the first side, and its distance from the apex.
    fn polar(&self, unfolded: V2) -> (f64, f64) {
        let away = unfolded - self.apex;
        let (sin, cos) = self.side.sin_cos();
        let angle = (cos * away.y - sin * away.x).atan2(cos * away.x + sin * away.y);
        (angle, away.norm())
    }

    /// A point of the unfolded plane, folded into the wedge.
    fn fold(&self, unfolded: V2) -> V2 {
        let (angle, distance) = self.polar(unfolded);
        let turns = angle.rem_euclid(2.0 * self.opening);
        let inside = if turns > self.opening { 2.0 * self.opening - turns } else { turns };
        self.apex + unit(self.side + inside) * distance
    }
}

/// Largest error of a centre and sum of miscounted hits of random straight paths in a wedge of pi/n. Every eighth aims
/// at the apex.
fn wedge(n: u32, paths: u32, motion: MotionLaw) -> Result<[f64; 2], SceneFault> {
    let mut next = random(u64::from(n));
    let (mut largest, mut missed) = (Largest::default(), 0.0);
    for path in 0..paths {
        let opening = PI / f64::from(n);
        let apex = V2::new(4.0 * next() - 2.0, 4.0 * next() - 2.0);
        let wedge = Wedge { apex, side: TAU * next(), opening };
        let from = wedge.apex + unit(wedge.side + opening * (0.2 + 0.6 * next())) * 6.0;
        let apex_aimed = path % 8 == 0 && n < 8;
        let aim = if apex_aimed { V2::zeros() } else { unit(TAU * next()) * (0.05 + 3.0 * next()) };
        let velocity = (wedge.apex + aim - from).normalize() * 4.0;
        let mut scene = wedge.scene(motion);
        scene.balls = vec![ball(from, velocity)];
        let engine = run(&scene, 16, 64, |tick, engine| {
            let unfolded = from + velocity * (tick as f64 / 16.0);
            largest.see_center(&engine.ball(0), over(wedge.fold(unfolded)));
        })?;
        if !apex_aimed {
            // Sides crossed between the angles at the start and at the end, whichever way the path turns.
            let (begin, _) = wedge.polar(from);
            let (end, _) = wedge.polar(from + velocity * 4.0);
            let turned = (end - begin + PI).rem_euclid(TAU) - PI;
            let side = |angle: f64| (angle / opening).floor();
            let crossed = (side(begin + turned) - side(begin)).abs();
            missed += miscount(engine.report().collisions.ball_wall, crossed as u64);
        }
    }
    Ok([largest.value(), missed])
}

/// A point (x, y sqrt(3)), on which the mirrors of a triangle of side 8 act without rounding while x and y have few bits.
#[derive(Clone, Copy)]
struct Hexagonal {
    x: f64,
    y: f64,
}

impl Hexagonal {
    /// Folds into the triangle with corners (-4, 0), (4, 0), (0, 4 sqrt(3)).
    fn folded(mut self) -> Self {
        loop {
            if self.y < 0.0 {
                self.y = -self.y;
            } else if self.y > self.x + 4.0 {
                // About y = x + 4, a mirror that leans 60 degrees.
                let (x, y) = (self.x + 4.0, self.y);
                self = Self { x: -0.5 * x + 1.5 * y - 4.0, y: 0.5 * x + 0.5 * y };
            } else if self.y > 4.0 - self.x {
                let (x, y) = (4.0 - self.x, self.y);
                self = Self { x: 4.0 + 0.5 * x - 1.5 * y, y: 0.5 * x + 0.5 * y };
            } else {
                return self;
            }
        }
    }

    fn point(self) -> V2 {
        V2::new(self.x, self.y * 3.0_f64.sqrt())
    }
}

/// Walls around a regular polygon for centres.
fn polygon(sides: u32, inradius: f64, middle: V2, turned: f64, motion: MotionLaw) -> Scene {
    let mut scene = graph(64.0, &[], motion);
    for side in 0..sides {
        let outward = unit(turned + TAU * f64::from(side) / f64::from(sides));
        scene.walls.push(wall(middle + outward * inradius, -outward));
    }
    scene
}

/// Largest error of a centre and miscounted hits of a ball in an equilateral triangle over 1000 s and more than 1000 hits.
fn triangle(motion: MotionLaw) -> Result<[f64; 2], SceneFault> {
    let inradius = 4.0 / 3.0_f64.sqrt();
    let mut scene = polygon(3, inradius, V2::new(0.0, inradius), PI / 6.0, motion);
    let (from, speed) = (Hexagonal { x: 0.375, y: 1.25 }, Hexagonal { x: 2.75, y: 1.125 });
    scene.balls = vec![ball(from.point(), speed.point())];
    let at = |t: f64| Hexagonal { x: from.x + speed.x * t, y: from.y + speed.y * t };
    let mut largest = Largest::default();
    let engine = run(&scene, 16, 16 * 1000, |tick, engine| {
        largest.see_center(&engine.ball(0), over(at(tick as f64 / 16.0).folded().point()));
    })?;
    // Mirrors y = 4 n, y = x + 4 + 8 n and y = 4 - x + 8 n, in units of a side of 8.
    let (begin, end) = (at(0.0), at(1000.0));
    let families: [fn(Hexagonal) -> f64; 3] =
        [|p| p.y / 4.0, |p| (p.y - p.x - 4.0) / 8.0, |p| (p.y + p.x - 4.0) / 8.0];
    let crossed: f64 = families.iter().map(|of| (of(end).floor() - of(begin).floor()).abs()).sum();
    Ok([largest.value(), miscount(engine.report().collisions.ball_wall, crossed as u64)])
}

/// A closed path from the middle of each side of a regular polygon to the next: largest error of a centre over 1000
/// hits, and miscounted ones.
fn closed_path(sides: u32, motion: MotionLaw) -> Result<[f64; 2], SceneFault> {
    let (inradius, middle, turned, speed) = (3.0, V2::new(-1.5, 2.25), 0.3, 2.0);
    let angle = TAU / f64::from(sides);
    let corner = |n: u64| middle + unit(turned + angle * (n % u64::from(sides)) as f64) * inradius;
    let chord = 2.0 * inradius * (0.5 * angle).sin();
    // Starts halfway between two hits.
    let place = |t: f64| {
        let chords = speed * t / chord + 0.5;
        let n = chords.floor();
        corner(n as u64) + (corner(n as u64 + 1) - corner(n as u64)) * (chords - n)
    };
    let mut scene = polygon(sides, inradius, middle, turned, motion);
    scene.balls = vec![ball(place(0.0), (corner(1) - corner(0)) * (speed / chord))];
    let seconds = (1000.0 * chord / speed).floor();
    let mut largest = Largest::default();
    let engine = run(&scene, 16, 16 * seconds as u64, |tick, engine| {
        largest.see_center(&engine.ball(0), over(place(tick as f64 / 16.0)));
    })?;
    Ok([largest.value(), miscount(hits(&engine), (speed * seconds / chord + 0.5).floor() as u64)])
}

/// One wall at a random angle and place, a ball that runs into it: relative error of the velocity and error of the centre
/// after the hit.
fn mirrors(count: u32, motion: MotionLaw) -> Result<[f64; 2], SceneFault> {
    let mut next = random(77);
    let mut largest = [Largest::default(); 2];
    for _ in 0..count {
        let (point, normal) = (V2::new(next(), next()) * 4.0, unit(TAU * next()));
        let from = point + normal * (0.5 + next()) + V2::new(-normal.y, normal.x) * (2.0 * next() - 1.0);
        let velocity = unit(TAU * next()) * 3.0;
        let closing = -velocity.dot(&normal);
        if closing < 0.1 {
            continue;
        }
        let mut scene = graph(64.0, &[], motion);
        scene.walls.push(wall(point, normal));
        scene.balls = vec![ball(from, velocity)];
        let hit = (from - point).dot(&normal) / closing;
        let after = velocity + normal * (2.0 * closing);
        let engine = run(&scene, 1, 16, |_, _| {})?;
        let end = engine.ball(0);
        largest[0].see((end.velocity.xy() - after).norm() / 3.0);
        largest[1].see_center(&end, over(from + velocity * hit + after * (16.0 - hit)));
    }
    Ok(largest.map(Largest::value))
}

/// A channel exactly as wide as the ball, at an angle: needless hits, and error of the centre over 10 s.
fn channel(angle: f64) -> Result<[f64; 2], SceneFault> {
    let (along, across) = (unit(angle), unit(angle + 0.5 * PI));
    let mut scene = plane(64.0);
    let from = V2::new(0.3, -0.7);
    scene.walls.push(Wall { point: from - across * RADIUS, normal: across });
    scene.walls.push(Wall { point: from + across * RADIUS, normal: -across });
    scene.balls = vec![ball(from, along * 3.0)];
    let mut largest = Largest::default();
    let engine = run(&scene, 60, 600, |tick, engine| {
        largest.see_center(&engine.ball(0), over(from + along * (0.05 * tick as f64)));
    })?;
    // Where the angle is no exact number, rounding may close on one of the two walls.
    Ok([hits(&engine).saturating_sub(if angle == 0.0 { 0 } else { 2 }) as f64, largest.value()])
}

/// A million hits between two walls: the ball comes back to where it was every four seconds.
fn to_and_fro() -> Result<[f64; 2], SceneFault> {
    let mut scene = plane(64.0);
    scene.walls.push(wall(V2::new(-1.0, 0.0), V2::x()));
    scene.walls.push(wall(V2::new(1.0, 0.0), -V2::x()));
    scene.balls = vec![ball(V2::new(0.3, 0.7), V2::new(16.0, 0.0))];
    let mut largest = Largest::default();
    let engine = run(&scene, 1, 125_000, |_, engine| {
        largest.see_center(&engine.ball(0), over(V2::new(0.3, 0.7)));
    })?;
    Ok([largest.value(), miscount(hits(&engine), 1_000_000)])
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![];
    for (law, motion) in [("slide", MotionLaw::Frictionless), ("roll", MotionLaw::Rolling)] {
        let centre = |span, limit| Demand::over_ticks("centre", "m", span, limit);
        cases.push(Case::new(
            format!("H8/corner-{law}"),
            "both walls of a corner turn a ball at one instant",
            [centre(Span::Seconds(20.0), 1e-12)],
            move || corner(motion),
        ));
        for n in [2, 3, 4, 6] {
            cases.push(Case::new(
                format!("H9/wedge-{}-{law}", 180 / n),
                format!("random paths into a wedge of {} degrees, some into its apex", 180 / n),
                [centre(Span::Runs(200), 1e-12), Demand::count("hits", Span::Runs(200))],
                move || wedge(n, 200, motion),
            ));
        }
        cases.push(Case::new(
            format!("X5/wedge-1-{law}"),
            "random paths into a wedge of 1 degree: up to 180 hits",
            // 180 directions off by 4e-16 rad, seen from 16 m.
            [centre(Span::Runs(200), 1e-11), Demand::count("hits", Span::Runs(200))],
            move || wedge(180, 200, motion),
        ));
        cases.push(Case::new(
            format!("X6/triangle-{law}"),
            "a path in an equilateral triangle, unfolded",
            [centre(Span::Seconds(1000.0), 1e-10), Demand::count("hits", Span::Seconds(1000.0))],
            move || triangle(motion),
        ));
        // An even number of walls is off by 1e-15 rad a round, always to one side: 1e-13 rad after 1000 hits and 3 km.
        for (sides, limit) in [(3, 1e-10), (5, 1e-10), (6, 1e-9), (8, 1e-9)] {
            cases.push(Case::new(
                format!("X7/closed-{sides}-{law}"),
                format!("the closed path in a regular polygon of {sides} sides, turned by 0.3 rad"),
                [centre(Span::Hits(1000), limit), Demand::count("hits", Span::Hits(1000))],
                move || closed_path(sides, motion),
            ));
        }
        cases.push(Case::new(
            format!("X8/mirrors-{law}"),
            "one wall at any angle and place",
            [
                Demand::at_the_end("velocity, relative", "1", Span::Runs(1000), 1e-15),
                Demand::at_the_end("centre", "m", Span::Runs(1000), 1e-12),
            ],
            move || mirrors(1000, motion),
        ));
    }
    for angle in [0.0, 0.7, 2.1] {
        cases.push(Case::new(
            format!("X21/channel-{angle}"),
            format!("a channel exactly as wide as the ball, at {angle} rad"),
            [
                Demand::never("needless hits", Span::Seconds(10.0)),
                Demand::over_ticks("centre", "m", Span::Seconds(10.0), 1e-12),
            ],
            move || channel(angle),
        ));
    }
    cases.push(Case::new(
        "X5/wedge-0.01",
        "random paths into a wedge of 0.01 degree: up to 18 000 hits",
        // 18 000 directions off by 4e-16 rad, seen from 16 m.
        [Demand::over_ticks("centre", "m", Span::Runs(20), 1e-9), Demand::count("hits", Span::Runs(20))],
        || wedge(18_000, 20, MotionLaw::Rolling),
    ));
    cases.push(Case::new(
        "X9/to-and-fro",
        "a million hits between two walls",
        [
            Demand::over_ticks("centre", "m", Span::Hits(1_000_000), 1e-9),
            Demand::count("hits", Span::Seconds(125_000.0)),
        ],
        to_and_fro,
    ));
    cases
}
