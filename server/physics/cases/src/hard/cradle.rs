//! H2, H31: rows of touching balls.

use super::rods::rods;
use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::mirror::differing_states;
use crate::ride::{Drift, Largest, hits, run};
use crate::scenes::{all_bits, center, graph, in_list_order, moving, plane, still};
use ballroom_physics::{BallSpec, Controller, MotionLaw, Scene, SceneFault};
use nalgebra::Vector3;

/// `count` touching balls, `swung` of them a metre to the left with speed 2.
fn cradle(count: usize, swung: usize, motion: MotionLaw) -> Scene {
    let mut scene = graph(512.0, &[], motion);
    for n in 0..count {
        let place = n as f64 - if n < swung { 1.0 } else { 0.0 };
        let speed = if n < swung { 2.0 } else { 0.0 };
        scene.balls.push(moving(&format!("{n:03}"), 0.5, center(place, 0.0), speed, 0.0));
    }
    scene
}

/// Largest error of a centre over 3 s: the swung balls arrive after half a second, and as many leave.
fn as_many_leave(count: usize, swung: usize, motion: MotionLaw) -> Result<[f64; 1], SceneFault> {
    let mut largest = Largest::default();
    run(&cradle(count, swung, motion), 60, 180, |tick, engine| {
        let t = tick as f64 / 60.0;
        for (n, ball) in engine.balls().enumerate() {
            let came = if n < swung { 2.0 * t.min(0.5) - 1.0 } else { 0.0 };
            let left = if n >= count - swung { 2.0 * (t - 0.5).max(0.0) } else { 0.0 };
            largest.see_center(&ball, Vector3::new(n as f64 + came + left, 0.0, 0.5));
        }
    })?;
    Ok([largest.value()])
}

/// Bits that change and hits that are counted while touching balls lie at rest for 10 s.
fn rest() -> Result<[f64; 2], SceneFault> {
    let mut scene = cradle(5, 0, MotionLaw::Rolling);
    scene.balls.push(still("above", 0.5, center(0.5, 0.75_f64.sqrt())));
    let start = all_bits(&Controller::new(&scene)?);
    let engine = run(&scene, 60, 600, |_, _| {})?;
    let changed = all_bits(&engine).iter().zip(&start).filter(|(a, b)| a != b).count();
    Ok([changed as f64, hits(&engine) as f64])
}

/// Three touching balls whose speeds differ by `noise`, m/s: largest error of a centre over 1 s. They exchange their speeds,
/// however little these differ, or part if the foremost is the fastest.
fn together(noise: f64) -> Result<[f64; 1], SceneFault> {
    let mut scene = plane(32.0);
    let starts = [2.0 + noise, 2.0, 2.0 - noise].into_iter().enumerate().map(|(n, v)| (n as f64, v));
    let starts: Vec<(f64, f64)> = starts.collect();
    let ball = |(n, (x, v)): (usize, &(f64, f64))| moving(&format!("{n}"), 0.5, center(*x, 0.0), *v, 0.0);
    scene.balls = starts.iter().enumerate().map(ball).collect();
    let mut largest = Largest::default();
    run(&scene, 60, 60, |tick, engine| {
        for (ball, x) in engine.balls().zip(rods(&starts, 0.5, [-32.0, 32.0], tick as f64 / 60.0)) {
            largest.see_center(&ball, Vector3::new(x, 0.0, 0.5));
        }
    })?;
    Ok([largest.value()])
}

/// Equal balls with gaps between two walls, as rods on a line.
fn with_gaps(starts: &[(f64, f64)], seconds: u64) -> Result<[f64; 1], SceneFault> {
    let mut scene = plane(16.0);
    let radius = 4.0 / (starts.len() as f64 * 8.0);
    scene.balls = starts
        .iter()
        .enumerate()
        .map(|(n, (x, v))| moving(&format!("{n:03}"), radius, center(*x, 0.0), *v, 0.0))
        .collect();
    let mut largest = Largest::default();
    run(&scene, 60, 60 * seconds, |tick, engine| {
        let exact = rods(starts, radius, [-16.0, 16.0], tick as f64 / 60.0);
        for (ball, x) in engine.balls().zip(exact) {
            largest.see_center(&ball, Vector3::new(x, 0.0, radius));
        }
    })?;
    Ok([largest.value()])
}

/// A train of `first` touching balls at 2 m/s meets one of `second` at -1 m/s, and both meet walls: rods on a line.
/// Largest error of a centre over 20 s.
fn trains(first: usize, second: usize) -> Result<[f64; 1], SceneFault> {
    let radius = 0.25;
    let mut starts = vec![];
    for n in 0..first {
        starts.push((-6.0 + 0.5 * n as f64, 2.0));
    }
    for n in 0..second {
        starts.push((4.0 + 0.5 * n as f64, -1.0));
    }
    let mut scene = plane(16.0);
    let ball =
        |(n, (x, v)): (usize, &(f64, f64))| moving(&format!("{n:03}"), radius, center(*x, 0.0), *v, 0.0);
    scene.balls = starts.iter().enumerate().map(ball).collect();
    let mut largest = Largest::default();
    run(&scene, 60, 1200, |tick, engine| {
        for (ball, x) in engine.balls().zip(rods(&starts, radius, [-16.0, 16.0], tick as f64 / 60.0)) {
            largest.see_center(&ball, Vector3::new(x, 0.0, radius));
        }
    })?;
    Ok([largest.value()])
}

/// A hundred balls at even places with speeds that repeat after 17, so that many meet by three and more at an instant;
/// or a little unlike, so that none do.
fn hundred(unlike: f64) -> Vec<(f64, f64)> {
    (0..100)
        .map(|n| {
            let speed = f64::from(n * 7 % 17) * 0.25 - 2.0;
            (-15.84 + 0.32 * f64::from(n), speed + unlike * (f64::from(n) * 12.9898).sin())
        })
        .collect()
}

/// Relative error of a free group's momentum over 10 s: a ball of 1000 kg meets a row of light ones.
fn momentum(e: f64, count: u32) -> Result<[f64; 1], SceneFault> {
    let mut scene = plane(64.0);
    scene.restitution = e;
    scene.balls.push(BallSpec { mass: 1000.0, ..moving("heavy", 0.25, center(2.0, 0.0), -1.0, 0.0) });
    for n in 0..count {
        let place = center(-0.625 * f64::from(n), 0.0);
        scene.balls.push(moving(&format!("light-{n}"), 0.25, place, 2.0, 0.0));
    }
    let mut drift = Drift::default();
    run(&scene, 60, 600, |_, engine| {
        let balls = in_list_order(engine);
        drift.see(balls.iter().zip(&scene.balls).map(|(b, spec)| b.velocity.x * spec.mass).sum());
    })?;
    Ok([drift.value()])
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let centres = |seconds| Demand::over_ticks("centres", "m", Span::Seconds(seconds), 1e-12);
    let mut cases = vec![];
    for (law, motion) in [("slide", MotionLaw::Frictionless), ("roll", MotionLaw::Rolling)] {
        for swung in 1..=3 {
            cases.push(Case::new(
                format!("H2/{swung}-in-{law}"),
                format!("{swung} into a cradle of five, {swung} out"),
                [centres(3.0)],
                move || as_many_leave(5, swung, motion),
            ));
        }
        for swung in [1, 37] {
            cases.push(Case::new(
                format!("H31/{swung}-in-{law}"),
                format!("{swung} into a row of a hundred, {swung} out"),
                [centres(3.0)],
                move || as_many_leave(100, swung, motion),
            ));
        }
    }
    let mirror = || Demand::never("states that differ", Span::Seconds(3.0));
    cases.push(Case::new("H2/mirror", "a cradle in a mirror", [mirror()], || {
        Ok([differing_states(&cradle(5, 2, MotionLaw::Rolling), 60, 180)? as f64])
    }));
    cases.push(Case::new("H31/mirror", "a row of a hundred in a mirror", [mirror()], || {
        Ok([differing_states(&cradle(100, 3, MotionLaw::Rolling), 60, 180)? as f64])
    }));
    let rest_s = Span::Seconds(10.0);
    let demands = [Demand::never("numbers that change", rest_s), Demand::never("hits", rest_s)];
    cases.push(Case::new("H2/rest", "touching balls at rest", demands, rest));
    for noise in ["0", "1e-15", "-1e-15", "1e-13", "1e-9", "-1e-9", "1e-5", "1e-3"] {
        let speed = noise.parse().unwrap_or(f64::NAN);
        cases.push(Case::new(
            format!("H2/together{noise}"),
            format!("touching balls at 2 m/s, each {noise} m/s faster than the next"),
            [centres(1.0)],
            move || together(speed),
        ));
    }
    cases.push(Case::new(
        "H31/gaps-5",
        "five balls with gaps between walls, unfolded",
        [centres(20.0)],
        || with_gaps(&[(-9.0, 5.0), (-3.0, 0.0), (-1.5, -1.0), (0.5, 0.25), (4.0, -3.0)], 20),
    ));
    for (name, unlike) in [("even", 0.0), ("unlike", 0.01)] {
        cases.push(Case::new(
            format!("H31/gaps-100-{name}"),
            "a hundred balls with gaps between walls, unfolded",
            [centres(20.0)],
            move || with_gaps(&hundred(unlike), 20),
        ));
    }
    for (first, second) in [(5, 0), (5, 3), (8, 8), (20, 1)] {
        cases.push(Case::new(
            format!("X19/trains-{first}-{second}"),
            format!("a train of {first} touching balls meets one of {second}, and walls"),
            [centres(20.0)],
            move || trains(first, second),
        ));
    }
    for swung in [1, 150] {
        cases.push(Case::new(
            format!("X20/{swung}-of-300"),
            format!("{swung} into a row of three hundred"),
            [centres(3.0)],
            move || as_many_leave(300, swung, MotionLaw::Rolling),
        ));
    }
    for (e, count) in [(0.9, 8), (0.5, 5), (0.1, 3), (0.0, 2)] {
        cases.push(Case::new(
            format!("H31/momentum-{e}"),
            format!("momentum of 1000 kg and {count} times 1 kg at restitution {e}"),
            [Demand::relative("momentum", Span::Seconds(10.0), 1e-12)],
            move || momentum(e, count),
        ));
    }
    cases
}
