//! H22, H23, H25, H32, H34: many hits, backwards, far away, steered.

use super::discs_table::{DISCS, START};
use super::rods::rods;
use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::ride::{Drift, Largest, hits, run};
use crate::scenes::{center, cloud, contact, graph, in_list_order, moving, plane, still, walls};
use ballroom_physics::surface::bezier::BezierPatch;
use ballroom_physics::{Accuracy, Controller, Drive, Floor, MotionLaw, Place, Scene, SceneFault, Time};
use nalgebra::{Vector2, Vector3};

/// A crowd of mixed radii that rolls in a box.
fn crowd(terms: &[(usize, usize, f64)]) -> Scene {
    let mut scene = graph(1.5, terms, MotionLaw::Rolling);
    scene.balls = cloud(60, [0.05, 0.12], 1.3, 4.0, 5);
    scene
}

/// Relative error of the energy over `wanted` hits.
fn energy(terms: &[(usize, usize, f64)], wanted: u64) -> Result<[f64; 1], SceneFault> {
    let mut engine = Controller::new(&crowd(terms))?;
    let mut drift = Drift::default();
    for second in 1.. {
        drift.see(engine.energy());
        if hits(&engine) >= wanted {
            break;
        }
        engine.advance_to(Time::of_seconds(f64::from(second)));
    }
    Ok([drift.value()])
}

/// The scene as it stands, with every motion turned round.
fn reversed(scene: &Scene, engine: &Controller) -> Scene {
    let mut scene = scene.clone();
    for (spec, state) in scene.balls.iter_mut().zip(in_list_order(engine)) {
        spec.place = Place::Uv(state.uv);
        spec.velocity = -state.velocity;
        spec.spin = -state.omega.dot(&state.normal);
    }
    scene
}

fn farthest(a: &Controller, b: &Controller) -> f64 {
    let mut largest = Largest::default();
    a.balls().zip(b.balls()).for_each(|(a, b)| largest.see_center(&a, b.center));
    largest.value()
}

/// Runs until ten hits are past, turns every motion round and runs as long again. Distance from the start, m, over the
/// factor by which a small shift grows on the way there and back; and how many hits there were too few.
fn reversal(scene: &Scene, seconds: u64) -> Result<[f64; 2], SceneFault> {
    const SHIFT: f64 = 1e-9;
    let start = Controller::new(scene)?;
    let there = run(scene, 1, seconds, |_, _| {})?;
    let back = run(&reversed(scene, &there), 1, seconds, |_, _| {})?;
    let mut shifted = scene.clone();
    for ball in &mut shifted.balls {
        if let Place::Center(p) | Place::Contact(p) = &mut ball.place {
            p.y += SHIFT;
        }
    }
    let growth = farthest(&run(&shifted, 1, seconds, |_, _| {})?, &there) / SHIFT;
    let few = 10_u64.saturating_sub(there.report().collisions.ball_ball);
    Ok([farthest(&back, &start) / growth.max(1.0), few as f64])
}

fn reversible(terms: &[(usize, usize, f64)]) -> Scene {
    let mut scene = graph(2.0, terms, MotionLaw::Rolling);
    scene.balls = cloud(4, [0.2, 0.3], 1.5, 2.0, 9);
    scene
}

/// A million metres, of which an f64 resolves 1.2e-10.
const FAR: f64 = 1_048_576.0;

/// Three balls on a line between walls, a million metres from the origin: largest error of a centre over 20 s.
fn far_rods() -> Result<[f64; 1], SceneFault> {
    let border = [FAR - 8.0, FAR + 8.0];
    let mut scene = plane(8.0);
    scene.floor = Floor::Polynomial { x: border, y: border, terms: vec![] };
    scene.walls = walls(border, border);
    let starts = [(-5.0, 3.0), (0.0, 0.0), (4.0, -1.5)];
    let ball =
        |(n, (x, v)): (usize, &(f64, f64))| moving(&format!("{n}"), 0.5, center(FAR + x, FAR), *v, 0.0);
    scene.balls = starts.iter().enumerate().map(ball).collect();
    let mut largest = Largest::default();
    run(&scene, 60, 1200, |tick, engine| {
        for (ball, x) in engine.balls().zip(rods(&starts, 0.5, [-8.0, 8.0], tick as f64 / 60.0)) {
            let near = ball.center - Vector3::new(FAR, FAR, 0.0);
            largest.see((near - Vector3::new(x, 0.0, 0.5)).norm());
        }
    })?;
    Ok([largest.value()])
}

/// A ball in a bowl a million metres from the origin against the same at the origin: largest difference over 20 s.
fn far_bowl() -> Result<[f64; 1], SceneFault> {
    let patch = |shift: f64| {
        // z = (x^2 + y^2)/16: the middle control point of x^2 over [-8, 8] is -64.
        let row = |i: usize| (0..3_usize).map(move |j| [i, j]);
        let at = |n: usize| [-8.0, 0.0, 8.0][n];
        let square = |n: usize| if n == 1 { -64.0 } else { 64.0 };
        let point =
            |[i, j]: [usize; 2]| Vector3::new(at(i) + shift, at(j) + shift, (square(i) + square(j)) / 16.0);
        Floor::Bezier(
            BezierPatch::new([2, 2], (0..3).flat_map(row).map(point).collect()).expect("nine points"),
        )
    };
    let scene = |shift: f64| {
        let mut scene = graph(8.0, &[], MotionLaw::Rolling);
        scene.floor = patch(shift);
        scene.walls = walls([shift - 8.0, shift + 8.0], [shift - 8.0, shift + 8.0]);
        scene.balls = vec![moving("ball", 0.5, contact(shift + 3.0, shift - 2.0), 1.0, 2.0)];
        scene
    };
    let mut far = Controller::new(&scene(FAR))?;
    let mut largest = Largest::default();
    run(&scene(0.0), 60, 1200, |tick, engine| {
        far.advance_to(Time::of_tick(tick, 60));
        largest.see_center(&engine.ball(0), far.ball(0).center - Vector3::new(FAR, FAR, 0.0));
    })?;
    Ok([largest.value()])
}

/// Six discs in a square, and the same a little aside.
fn discs(aside: f64) -> Scene {
    let mut scene = plane(4.0);
    let ball = |(n, [x, y, vx, vy]): (usize, &[f64; 4])| {
        moving(&format!("{n}"), 0.5, center(*x + if n == 0 { aside } else { 0.0 }, *y), *vx, *vy)
    };
    scene.balls = START.iter().enumerate().map(ball).collect();
    scene
}

/// Six discs in a square against a run in 80 digits, until each had `horizon` hits with others on the average: largest error
/// of a place over the radius; and over what becomes of a shift of one of them by 2^-40 m, per metre of it.
///
/// In an endless gas with a mean free path l = A/(sqrt(2) N 2R) = 5.8 m a shift grows by about 2 l/R = 23 a hit, so that an
/// f64 would hold out for ln(1e16)/ln(23) = 12 hits. Here it grew 2e3, 8e6 and 3e10 times in 4, 8 and 12, by 7 a hit: an
/// error is as large as a disc after 17. Places of up to 4 m are rounded to 4.4e-16 m; what is rounded later grows less.
fn horizon(horizon: f64) -> Result<[f64; 2], SceneFault> {
    const ASIDE: f64 = 1.0 / (1_u64 << 40) as f64;
    let mut shifted = Controller::new(&discs(ASIDE))?;
    let (mut growth, mut error, mut grown) = (1.0_f64, Largest::default(), Largest::default());
    run(&discs(0.0), 2, DISCS.len() as u64 - 1, |tick, engine| {
        let (hits, places) = &DISCS[tick as usize];
        if 2.0 * f64::from(*hits) / START.len() as f64 > horizon {
            return;
        }
        shifted.advance_to(Time::of_tick(tick, 2));
        growth = growth.max(farthest(&shifted, engine) / ASIDE);
        for (ball, place) in engine.balls().zip(places.chunks_exact(2)) {
            let off = (ball.center.xy() - Vector2::new(place[0], place[1])).norm();
            error.see(off / 0.5);
            grown.see(off / growth);
        }
    })?;
    Ok([error.value(), grown.value()])
}

/// A held force that flips at every tick: parabolas from tick to tick. Largest error of a centre over 10 s, m.
fn flips(rate_hz: u32, motion: MotionLaw) -> Result<[f64; 1], SceneFault> {
    let mut scene = graph(64.0, &[], motion);
    scene.accuracy = Accuracy::Tolerance(1e-12);
    scene.balls = vec![moving("ball", 0.5, center(1.0, 2.0), 0.5, -0.25)];
    let mut engine = Controller::new(&scene)?;
    let k = if motion == MotionLaw::Rolling { 0.4 } else { 0.0 };
    let (mut place, mut velocity) = (Vector2::new(1.0, 2.0), Vector2::new(0.5, -0.25));
    let dt = 1.0 / f64::from(rate_hz);
    let mut largest = Largest::default();
    for tick in 1..=10 * u64::from(rate_hz) {
        let direction = Vector2::new(0.6, 0.8) * if tick % 2 == 0 { 1.0 } else { -1.0 };
        engine.drive(0, Some(Drive { direction, acceleration: 6.0, speed_limit: 1e6 }));
        engine.advance_to(Time::of_tick(tick, rate_hz));
        let acceleration = direction * (6.0 / (1.0 + k));
        place += velocity * dt + acceleration * (0.5 * dt * dt);
        velocity += acceleration * dt;
        largest.see_center(&engine.ball(0), Vector3::new(place.x, place.y, 0.5));
    }
    Ok([largest.value()])
}

/// Two pushes with ten thousand ticks between: error of the centre after as many again, m.
fn patient() -> Result<[f64; 1], SceneFault> {
    let mut scene = graph(256.0, &[], MotionLaw::Rolling);
    scene.balls = vec![still("ball", 0.5, center(1.0, 2.0))];
    let mut engine = Controller::new(&scene)?;
    for (tick, x, y) in [(0, 0.125, 0.25), (10_000, 0.5, -0.125)] {
        engine.advance_to(Time::of_tick(tick, 60));
        engine.push(0, Vector2::new(x, y), 8.0);
    }
    engine.advance_to(Time::of_tick(20_000, 60));
    let pause = 10_000.0 / 60.0;
    let exact = Vector3::new(1.0 + 0.75 * pause, 2.0 + 0.375 * pause, 0.5);
    Ok([(engine.ball(0).center - exact).norm()])
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    const BOWL: &[(usize, usize, f64)] = &[(2, 0, 0.1), (0, 2, 0.12), (1, 1, 0.03)];
    let million = Span::Hits(1_000_000);
    let mut cases = vec![
        Case::new("H22/plane", "sixty balls in a box", [Demand::relative("energy", million, 1e-10)], || {
            energy(&[], 1_000_000)
        }),
        Case::new("H22/bowl", "sixty balls in a bowl", [Demand::relative("energy", million, 1e-10)], || {
            energy(BOWL, 1_000_000)
        }),
        Case::new(
            "H25/rods",
            "three balls and walls, a million metres away",
            [Demand::over_ticks("centres", "m", Span::Seconds(20.0), 1e-9)],
            far_rods,
        ),
        Case::new(
            "H25/bowl",
            "a ball in a bowl, a million metres away",
            [Demand::over_ticks("centre", "m", Span::Seconds(20.0), 1e-9)],
            far_bowl,
        ),
        Case::new(
            "X11/patient",
            "two pushes with ten thousand ticks between",
            [Demand::at_the_end("centre", "m", Span::Seconds(20_000.0 / 60.0), 1e-12)],
            patient,
        ),
    ];
    for (name, terms, seconds) in [("plane", &[][..], 10), ("bowl", BOWL, 10)] {
        let span = Span::Seconds(2.0 * seconds as f64);
        cases.push(Case::new(
            format!("H23/{name}"),
            format!("there and back through at least ten hits, {name}"),
            [
                Demand::at_the_end("centres over Lyapunov factor", "m", span, 1e-9),
                Demand::never("hits too few", span),
            ],
            move || reversal(&reversible(terms), seconds),
        ));
    }
    for (hits, limit) in [(4.0, 1e-11), (8.0, 4e-8), (12.0, 2e-4)] {
        let span = Span::Hits(hits as u64 * 3);
        cases.push(Case::new(
            format!("H32/{hits}-hits"),
            format!("six discs against 80 digits until {hits} hits a disc"),
            [
                Demand::over_ticks("places over radius", "1", span, limit),
                Demand::over_ticks("places over the growth of a shift", "m", span, 2e-15),
            ],
            move || horizon(hits),
        ));
    }
    for (law, motion) in [("slide", MotionLaw::Frictionless), ("roll", MotionLaw::Rolling)] {
        for rate_hz in [60, 64, 240] {
            cases.push(Case::new(
                format!("H34/{rate_hz}-hz-{law}"),
                format!("a force that flips at every tick of {rate_hz} Hz"),
                [Demand::over_ticks("centre", "m", Span::Seconds(10.0), 1e-13)],
                move || flips(rate_hz, motion),
            ));
        }
    }
    cases
}
