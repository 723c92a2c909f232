//! H27 and hits in closed form at awkward instants, speeds and masses.

use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::ride::{Largest, hits, miscount, run};
use crate::scenes::{all_bits, bits, center, graph, moving, plane, random, still};
use ballroom_physics::{BallSpec, Controller, MotionLaw, Place, Scene, SceneFault, Time};
use nalgebra::{Vector2, Vector3};

/// Whether a fault is the right one.
type Expected = fn(&SceneFault) -> bool;

/// Wrong verdicts on six scenes that must be refused, each by its own fault, and two that just fit.
fn refusals() -> f64 {
    let pair = |x: f64| vec![still("a", 0.5, center(0.0, 0.0)), still("b", 0.5, center(x, 0.0))];
    let one = |x: f64, radius: f64| vec![still("a", radius, center(x, 0.0))];
    let wrong: [(Vec<BallSpec>, Expected); 6] = [
        (
            pair(0.9),
            |fault| matches!(fault, SceneFault::Overlap { first: 0, second: 1, depth } if (depth - 0.1).abs() < 1e-12),
        ),
        (pair(1.0 - 1e-9), |fault| matches!(fault, SceneFault::Overlap { first: 0, second: 1, .. })),
        (pair(0.0), |fault| matches!(fault, SceneFault::Overlap { first: 0, second: 1, .. })),
        (one(9.0, 0.5), |fault| {
            matches!(fault, SceneFault::OffFloor { ball: 0, .. } | SceneFault::InWall { ball: 0, .. })
        }),
        (
            one(7.75, 0.5),
            |fault| matches!(fault, SceneFault::InWall { ball: 0, wall: 1, depth } if (depth - 0.25).abs() < 1e-12),
        ),
        (one(0.0, f64::NAN), |fault| matches!(fault, SceneFault::Number { .. })),
    ];
    let mut mistaken = 0;
    for (balls, expected) in wrong {
        let outcome = Controller::new(&Scene { balls, ..plane(8.0) });
        mistaken += u32::from(!outcome.is_err_and(|fault| expected(&fault)));
    }
    for balls in [pair(1.0), one(7.5, 0.5)] {
        mistaken += u32::from(Controller::new(&Scene { balls, ..plane(8.0) }).is_err());
    }
    f64::from(mistaken)
}

/// A hit exactly at a tick that is also a boundary of the engine's quantum belongs to that tick: hits missed at it and
/// errors of place and velocity shown there.
fn at_the_tick(rate_hz: u32) -> Result<[f64; 3], SceneFault> {
    let mut scene = plane(8.0);
    scene.balls = vec![moving("a", 0.5, center(0.0, 0.0), 2.0, 0.0), still("b", 0.5, center(2.0, 0.0))];
    let half = u64::from(rate_hz / 2);
    let engine = run(&scene, rate_hz, half, |_, _| {})?;
    let [a, b] = [engine.ball(0), engine.ball(1)];
    let place = (a.center.x - 1.0).abs().max((b.center.x - 2.0).abs());
    let velocity = a.velocity.x.abs().max((b.velocity.x - 2.0).abs());
    Ok([miscount(hits(&engine), 1), place, velocity])
}

/// Three balls that lie still until one is pushed at `start`; every bit of their motion for 8 s from then on.
fn after_a_push(start: f64) -> Result<Vec<Vec<u64>>, SceneFault> {
    let mut scene = graph(8.0, &[], MotionLaw::Rolling);
    scene.balls = vec![
        still("a", 0.5, center(-3.0, 0.1)),
        still("b", 0.25, center(0.0, 0.3)),
        still("c", 0.5, center(2.0, -1.0)),
    ];
    let mut engine = Controller::new(&scene)?;
    engine.advance_to(Time::of_seconds(start));
    engine.push(0, Vector2::new(5.0, 0.25), 8.0);
    let mut seen = vec![];
    for tick in 1..=512 {
        engine.advance_to(Time::of_seconds(start).after(f64::from(tick) / 64.0));
        seen.push(engine.balls().flat_map(|ball| bits(&ball)[..9].to_vec()).collect());
    }
    Ok(seen)
}

/// Ticks at which a run that begins after a million seconds differs from one that begins at once.
fn late() -> Result<[f64; 1], SceneFault> {
    let (now, late) = (after_a_push(0.0)?, after_a_push(1e6)?);
    Ok([now.iter().zip(&late).filter(|(a, b)| a != b).count() as f64])
}

/// Pairs that hit at one instant at opposite ends of a hall: numbers that differ from those of each pair alone.
fn far_apart() -> Result<[f64; 1], SceneFault> {
    let pair = |names: [&str; 2], x: f64| {
        [moving(names[0], 0.5, center(x, 0.25), 2.0, 0.0), still(names[1], 0.5, center(x + 3.0, 0.0))]
    };
    let (west, east) = (pair(["a", "b"], -60.0), pair(["c", "d"], 50.0));
    let end = |balls: Vec<BallSpec>| -> Result<Vec<u64>, SceneFault> {
        Ok(all_bits(&run(&Scene { balls, ..plane(64.0) }, 60, 120, |_, _| {})?))
    };
    let alone = [end(west.to_vec())?, end(east.to_vec())?].concat();
    let both = end([west, east].concat())?;
    Ok([both.iter().zip(&alone).filter(|(a, b)| a != b).count() as f64])
}

/// Two rolling balls of one mass meet head on: they exchange their velocities and keep their spins. Largest relative
/// errors of velocities and of spins.
fn exchange_with_spin() -> Result<[f64; 2], SceneFault> {
    let mut scene = graph(16.0, &[], MotionLaw::Rolling);
    let spin = [30.0, -7.0];
    scene.balls = vec![
        BallSpec { spin: spin[0], ..moving("a", 0.5, center(-3.0, 1.0), 3.0, 0.0) },
        BallSpec { spin: spin[1], ..moving("b", 0.5, center(2.0, 1.0), -0.7, 0.0) },
    ];
    let engine = run(&scene, 60, 180, |_, _| {})?;
    let [a, b] = [engine.ball(0), engine.ball(1)];
    let velocity = (a.velocity.x + 0.7).abs().max((b.velocity.x - 3.0).abs()) / 3.0;
    let spins = (a.omega.z / spin[0] - 1.0).abs().max((b.omega.z / spin[1] - 1.0).abs());
    Ok([velocity, spins])
}

/// Random hits off centre of unlike masses: with d the line of centres at the hit, each velocity changes along d alone, by
/// -2 M/(m + M) of the closing speed. Largest relative error of a velocity, and passes that should have hit.
fn random_hits(count: u32, motion: MotionLaw) -> Result<[f64; 2], SceneFault> {
    let mut next = random(123);
    let (mut largest, mut missed) = (Largest::default(), 0);
    for _ in 0..count {
        let masses = [10.0_f64.powf(4.0 * next() - 2.0), 10.0_f64.powf(4.0 * next() - 2.0)];
        let angle = std::f64::consts::TAU * next();
        let (speed, b) = (0.5 + 3.0 * next(), 1.98 * next() - 0.99);
        let along = Vector2::new(angle.cos(), angle.sin());
        let across = Vector2::new(-along.y, along.x);
        let from = across * b - along * 3.0;
        let drift = Vector2::new(next() - 0.5, next() - 0.5);
        let velocities = [along * speed + drift, drift];
        let mut scene = graph(64.0, &[], motion);
        let spec = |name: &str, place, v: Vector2<f64>| moving(name, 0.5, Place::Center(place), v.x, v.y);
        scene.balls = vec![spec("a", from, velocities[0]), spec("b", Vector2::zeros(), velocities[1])];
        scene.balls.iter_mut().zip(masses).for_each(|(ball, mass)| ball.mass = mass);
        let engine = run(&scene, 1, 8, |_, _| {})?;
        // In the frame of the second the first comes along `along` at a distance b.
        let line = along * (1.0 - b * b).sqrt() - across * b;
        let closing = speed * (1.0 - b * b).sqrt();
        let total = masses[0] + masses[1];
        let exact = [
            velocities[0] - line * (2.0 * masses[1] / total * closing),
            velocities[1] + line * (2.0 * masses[0] / total * closing),
        ];
        missed += u32::from(engine.report().collisions.ball_ball != 1);
        for (ball, exact) in engine.balls().zip(exact) {
            largest.see((ball.velocity.xy() - exact).norm() / (speed + 1.0));
        }
    }
    Ok([largest.value(), f64::from(missed)])
}

/// Head on with masses 1 : 1e12, both ways: largest error of a velocity over that of the exact outcome.
fn unlike_masses() -> Result<[f64; 1], SceneFault> {
    let mut largest = Largest::default();
    for (mass, speeds) in [([1.0, 1e12], [3.0, 0.0]), ([1.0, 1e12], [0.0, -3.0]), ([1e12, 1.0], [3.0, -2.0])]
    {
        let mut scene = plane(64.0);
        for n in 0..2 {
            let ball = moving(["a", "b"][n], 0.5, center(3.0 * n as f64, 0.0), speeds[n], 0.0);
            scene.balls.push(BallSpec { mass: mass[n], ..ball });
        }
        let engine = run(&scene, 1, 4, |_, _| {})?;
        let (total, closing) = (mass[0] + mass[1], speeds[0] - speeds[1]);
        let exact =
            [speeds[0] - 2.0 * mass[1] / total * closing, speeds[1] + 2.0 * mass[0] / total * closing];
        for (ball, exact) in engine.balls().zip(exact) {
            largest.see((ball.velocity.x - exact) / exact);
        }
    }
    Ok([largest.value()])
}

/// An exchange at `speed`: error of both velocities over it.
fn slow(speed: f64) -> Result<[f64; 1], SceneFault> {
    let mut scene = plane(8.0);
    scene.balls = vec![moving("a", 0.5, center(0.0, 0.0), speed, 0.0), still("b", 0.5, center(1.25, 0.0))];
    let engine = run(&scene, 1, (0.5 / speed) as u64, |_, _| {})?;
    let [a, b] = [engine.ball(0).velocity, engine.ball(1).velocity];
    Ok([(a.norm() / speed).max((b - Vector3::x() * speed).norm() / speed)])
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![
        Case::new(
            "H27/refusals",
            "balls that overlap, leave the floor or reach into walls; balls that just fit",
            [Demand::never("wrong verdicts", Span::Loads(8))],
            || Ok([refusals()]),
        ),
        Case::new(
            "X13/late",
            "a push after a million seconds, as at the start",
            [Demand::never("ticks that differ", Span::Seconds(8.0))],
            late,
        ),
        Case::new(
            "X14/far-apart",
            "two pairs hit at one instant at opposite ends",
            [Demand::never("numbers that differ", Span::Seconds(2.0))],
            far_apart,
        ),
        Case::new(
            "X15/spin",
            "rolling balls exchange velocities and keep their spins",
            ["velocities, relative", "spins, relative"]
                .map(|quantity| Demand::at_the_end(quantity, "1", Span::Seconds(3.0), 1e-15)),
            exchange_with_spin,
        ),
        Case::new(
            "X17/masses",
            "head on with masses 1 : 1e12",
            [Demand::at_the_end("velocities, relative", "1", Span::Runs(3), 1e-15)],
            unlike_masses,
        ),
        Case::new(
            "X18/slow",
            "an exchange at 2e-6 m/s, twice the speed that counts as rest",
            [Demand::at_the_end("velocities, relative", "1", Span::Seconds(250_000.0), 1e-12)],
            || slow(2e-6),
        ),
    ];
    for rate_hz in [2, 60, 64, 1000] {
        let span = Span::Seconds(0.5);
        cases.push(Case::new(
            format!("X12/tick-{rate_hz}"),
            format!("a hit exactly at a tick of {rate_hz} Hz and a boundary of the quantum"),
            [
                Demand::count("hits", span),
                Demand::at_the_end("centres", "m", span, 0.0),
                Demand::at_the_end("velocities", "m/s", span, 0.0),
            ],
            move || at_the_tick(rate_hz),
        ));
    }
    for (law, motion) in [("slide", MotionLaw::Frictionless), ("roll", MotionLaw::Rolling)] {
        cases.push(Case::new(
            format!("X16/random-{law}"),
            "random hits off centre, masses 1 : 1e4",
            [
                Demand::at_the_end("velocities, relative", "1", Span::Runs(1000), 1e-13),
                Demand::never("hits missed or doubled", Span::Runs(1000)),
            ],
            move || random_hits(1000, motion),
        ));
    }
    cases
}
