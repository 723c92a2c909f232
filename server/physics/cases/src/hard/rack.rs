//! H3, H4: groups that are hit all at once.

use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::mirror::{differing_states, mirrored_state};
use crate::ride::{Drift, Largest, run};
use crate::scenes::{center, cloud, graph, in_list_order, moving, original, plane, still};
use ballroom_physics::{MotionLaw, Place, Scene, SceneFault};
use nalgebra::{Rotation3, Vector2, Vector3};
use std::f64::consts::TAU;

/// B19: a ball onto two touching ones comes back with a fifth of its speed, and they leave at 30 degrees with
/// 2 sqrt(3)/5 of it: momentum, energy and symmetry leave one answer. Largest error of a centre over 4 s.
fn a_fifth_back(motion: MotionLaw) -> Result<[f64; 1], SceneFault> {
    let mut scene = graph(32.0, &[], motion);
    let v = 3.0;
    scene.balls = vec![
        moving("0", 0.5, center(-2.0, 0.0), v, 0.0),
        still("1", 0.5, center(0.0, -0.5)),
        still("2", 0.5, center(0.0, 0.5)),
    ];
    let hit = (2.0 - 0.75_f64.sqrt()) / v;
    let out = 2.0 * 3.0_f64.sqrt() / 5.0 * v;
    let mut largest = Largest::default();
    run(&scene, 60, 240, |tick, engine| {
        let t = tick as f64 / 60.0;
        let after = (t - hit).max(0.0);
        let aside = out * 0.5 * after;
        let along = out * 0.75_f64.sqrt() * after;
        let first = -2.0 + v * t.min(hit) - v / 5.0 * after;
        for (ball, [x, y]) in engine.balls().zip([[first, 0.0], [along, -0.5 - aside], [along, 0.5 + aside]])
        {
            largest.see_center(&ball, Vector3::new(x, y, 0.5));
        }
    })?;
    Ok([largest.value()])
}

/// `count` balls that reach each other on a ring at one instant, each towards the middle at 3 m/s: by symmetry each
/// goes back the way it came. Largest error of a centre over 4 s.
fn meet_in_a_ring(count: usize) -> Result<[f64; 1], SceneFault> {
    let mut scene = plane(32.0);
    let radius = 0.5;
    let touching = radius / (TAU / (2.0 * count as f64)).sin();
    let direction = |n: usize| {
        let angle = TAU * (n as f64 + 0.25) / count as f64;
        Vector2::new(angle.cos(), angle.sin())
    };
    for n in 0..count {
        let (place, v) = (direction(n) * (touching + 3.0), direction(n) * -3.0);
        scene.balls.push(moving(&format!("{n}"), radius, Place::Center(place), v.x, v.y));
    }
    let mut largest = Largest::default();
    run(&scene, 60, 240, |tick, engine| {
        let away = 3.0 * (tick as f64 / 60.0 - 1.0).abs();
        for (n, ball) in engine.balls().enumerate() {
            let exact = direction(n) * (touching + away);
            largest.see_center(&ball, Vector3::new(exact.x, exact.y, radius));
        }
    })?;
    Ok([largest.value()])
}

/// `count` balls released at rest on a ring in a bowl, which reach each other in the middle again and again, each time at
/// one instant but for what integration leaves of it: by symmetry each goes back the way it came. Largest distance of a
/// ball from the first one turned about the axis, m, and relative error of the energy over 5 s.
fn meet_in_a_bowl(count: usize) -> Result<[f64; 3], SceneFault> {
    let mut scene = graph(4.0, &[(2, 0, 0.25), (0, 2, 0.25)], MotionLaw::Rolling);
    let turn = |n: usize| Rotation3::from_axis_angle(&Vector3::z_axis(), TAU * n as f64 / count as f64);
    for n in 0..count {
        let place = turn(n) * Vector3::new(1.6, 0.45, 0.0);
        scene.balls.push(still(&format!("{n}"), 0.25, Place::Contact(place.xy())));
    }
    let (mut symmetry, mut energy) = (Largest::default(), Drift::default());
    let engine = run(&scene, 60, 300, |_, engine| {
        energy.see(engine.energy());
        for (n, ball) in engine.balls().enumerate() {
            symmetry.see_center(&ball, turn(n) * engine.ball(0).center);
        }
    })?;
    let few = 3_u64.saturating_sub(engine.report().clusters);
    Ok([symmetry.value(), energy.value(), few as f64])
}

/// Two balls that reach one at rest from both sides at one instant go back; it stays. Largest error of a speed at the end.
fn squeezed() -> Result<[f64; 1], SceneFault> {
    let mut scene = plane(16.0);
    scene.balls = vec![
        moving("a", 1.0, center(-2.2, 0.0), 6.0, 0.0),
        still("b", 1.0, center(0.0, 0.0)),
        moving("c", 1.0, center(2.2, 0.0), -6.0, 0.0),
    ];
    let engine = run(&scene, 60, 30, |_, _| {})?;
    let mut largest = Largest::default();
    for (ball, exact) in engine.balls().zip([-6.0, 0.0, 6.0]) {
        largest.see(ball.velocity.x - exact);
    }
    Ok([largest.value()])
}

/// Two touching balls that approach at once part at once. Error of a place after a second, m.
fn approaching_at_the_start() -> Result<[f64; 1], SceneFault> {
    let mut scene = plane(16.0);
    scene.balls =
        vec![moving("a", 1.0, center(-1.0, 0.0), 2.0, 0.0), moving("b", 1.0, center(1.0, 0.0), -2.0, 0.0)];
    let engine = run(&scene, 60, 60, |_, _| {})?;
    Ok([(engine.ball(0).center.x + 3.0).abs()])
}

/// Fifteen touching balls in a triangle and one that comes along its axis, y, but for `aside`.
fn rack(half: f64, aside: f64) -> Scene {
    let mut scene = graph(half, &[], MotionLaw::Rolling);
    for row in 0..5 {
        for place in 0..=row {
            let x = f64::from(place) - 0.5 * f64::from(row);
            let y = f64::from(row) * 0.75_f64.sqrt();
            scene.balls.push(still(&format!("{row}{place}"), 0.5, center(x, y)));
        }
    }
    scene.balls.push(moving("cue", 0.5, center(aside, -3.0), 0.0, 9.0));
    scene
}

/// Before the first walls are reached the break is its own mirror image; later it is chaotic and rounding grows.
fn symmetric_break() -> Result<[f64; 3], SceneFault> {
    let (mut symmetry, mut energy, mut momentum) = (Largest::default(), Drift::default(), Drift::default());
    run(&rack(64.0, 0.0), 60, 120, |_, engine| {
        let balls = in_list_order(engine);
        for row in 0..5_usize {
            for place in 0..=row {
                let first = row * (row + 1) / 2;
                symmetry
                    .see_center(&balls[first + place], mirrored_state(&balls[first + row - place]).center);
            }
        }
        symmetry.see(balls[15].center.x);
        energy.see(engine.energy());
        momentum.see(balls.iter().map(|ball| ball.velocity.y).sum());
    })?;
    Ok([symmetry.value(), energy.value(), momentum.value()])
}

/// A hexagon of touching balls, `rings` around one, hit off its axis: errors of energy and of both momenta.
fn hexagon(rings: i32) -> Result<[f64; 3], SceneFault> {
    let mut scene = plane(64.0);
    for i in -rings..=rings {
        for j in (-rings).max(-rings - i)..=rings.min(rings - i) {
            let (x, y) = (f64::from(i) + 0.5 * f64::from(j), f64::from(j) * 0.75_f64.sqrt());
            scene.balls.push(still(&format!("{i}:{j}"), 0.5, center(x, y)));
        }
    }
    scene.balls.push(moving("hits", 0.5, center(-3.0 - f64::from(rings), 0.3), 8.0, 1.0));
    let mut drifts = [Drift::default(); 3];
    run(&scene, 60, 240, |_, engine| {
        let sum: Vector3<f64> = engine.balls().map(|ball| ball.velocity).sum();
        let kept = [engine.energy(), sum.x, sum.y];
        drifts.iter_mut().zip(kept).for_each(|(drift, value)| drift.see(value));
    })?;
    Ok(drifts.map(Drift::value))
}

/// Twelve balls on a floor that is curved every way.
fn crowd_in_a_bowl() -> Scene {
    let mut scene = graph(8.0, &[(2, 0, 0.03), (0, 2, 0.02), (1, 1, 0.01)], MotionLaw::Rolling);
    scene.balls = cloud(12, [0.2, 0.4], 4.0, 2.0, 7);
    scene
}

type Make = fn() -> Scene;

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let centres = |seconds| Demand::over_ticks("centres", "m", Span::Seconds(seconds), 1e-12);
    let mut cases = vec![];
    for (law, motion) in [("slide", MotionLaw::Frictionless), ("roll", MotionLaw::Rolling)] {
        cases.push(Case::new(
            format!("H3/fifth-{law}"),
            "a ball onto two touching ones comes back with a fifth",
            [centres(4.0)],
            move || a_fifth_back(motion),
        ));
    }
    let speeds = Demand::at_the_end("velocities", "m/s", Span::Seconds(0.5), 1e-14);
    cases.push(Case::new(
        "H3/squeezed",
        "two balls reach a third from both sides at once",
        [speeds],
        squeezed,
    ));
    let place = Demand::at_the_end("centre", "m", Span::Seconds(1.0), 1e-14);
    cases.push(Case::new(
        "H3/start",
        "touching balls that approach from the start",
        [place],
        approaching_at_the_start,
    ));
    for count in [3, 4, 6] {
        cases.push(Case::new(
            format!("X1/ring-{count}"),
            format!("{count} balls meet in a ring at one instant"),
            [centres(4.0)],
            move || meet_in_a_ring(count),
        ));
    }
    for count in [3, 4, 5] {
        let span = Span::Seconds(5.0);
        cases.push(Case::new(
            format!("X22/bowl-{count}"),
            format!("{count} balls meet in the middle of a bowl at one instant, at least three times"),
            [
                Demand::over_ticks("symmetry of centres", "m", span, 1e-10),
                Demand::relative("energy", span, 1e-12),
                Demand::never("meetings too few", span),
            ],
            move || meet_in_a_bowl(count),
        ));
    }
    let span = Span::Seconds(2.0);
    cases.push(Case::new(
        "H4/axis",
        "a break of fifteen along its axis",
        [
            Demand::over_ticks("symmetry of centres", "m", span, 1e-12),
            Demand::relative("energy", span, 1e-12),
            Demand::relative("momentum", span, 1e-12),
        ],
        symmetric_break,
    ));
    let mirrors: [(&str, &str, u64, Make); 4] = [
        ("H4/mirror-axis", "a break along the axis in a mirror", 5, || rack(12.0, 0.0)),
        ("H4/mirror-aside", "a break off the axis in a mirror", 5, || rack(12.0, 0.3)),
        ("H4/mirror-bowl", "twelve balls on a curved floor in a mirror", 5, crowd_in_a_bowl),
        ("H4/mirror-original", "the scene original in a mirror", 10, original),
    ];
    for (id, title, seconds, scene) in mirrors {
        let demand = Demand::never("states that differ", Span::Seconds(seconds as f64));
        cases.push(Case::new(id, title, [demand], move || {
            Ok([differing_states(&scene(), 60, 60 * seconds)? as f64])
        }));
    }
    for (rings, count) in [(2, 19), (5, 91), (10, 331)] {
        let kept = |quantity| Demand::relative(quantity, Span::Seconds(4.0), 1e-12);
        cases.push(Case::new(
            format!("X2/hexagon-{count}"),
            format!("a hexagon of {count} touching balls, hit by one"),
            [kept("energy"), kept("momentum along x"), kept("momentum along y")],
            move || hexagon(rings),
        ));
    }
    cases
}
