//! The standard cases.

use super::ours;
use super::problem::{Ball, Ground, Problem, Triple, Truth};
use ballroom_cases::hard::rods::rods;
use ballroom_cases::references::{self, Seen};
use ballroom_cases::scenes::random;
use ballroom_physics::MotionLaw;

/// All cases; `quick` leaves out the large ones, and high rates and fine meshes.
pub fn problems(quick: bool) -> Vec<Problem> {
    let mut problems = vec![
        orbit("bowl-sliding", "One ball slides round a paraboloid bowl for 10 s"),
        orbit("bowl-hollow", "One hollow ball with spin rolls round a paraboloid bowl for 10 s"),
        cradle(),
        bullet(),
    ];
    problems.extend([31, 314, 3141].map(galperin).into_iter().take(if quick { 2 } else { 3 }));
    let sizes: &[usize] = if quick { &[100] } else { &[100, 1_000, 10_000] };
    problems.extend(sizes.iter().map(|count| gas(*count, false)));
    problems.extend(sizes.iter().map(|count| gas(*count, true)));
    if quick {
        for problem in &mut problems {
            problem.rates_hz.truncate(if problem.gas { 1 } else { 2 });
            problem.cells.truncate(1);
        }
    }
    problems
}

const GRAVITY: f64 = 9.81;

fn ball(radius: f64, mass: f64, center: Triple, velocity: Triple) -> Ball {
    Ball { radius, mass, inertia_factor: 0.4, center, velocity, spin: 0.0, omega: [0.0; 3] }
}

/// An orbit beside the reference of that name.
fn orbit(name: &str, title: &str) -> Problem {
    let (scene, table) = references::named(name).expect("a reference of that name");
    let (spec, start) = (&scene.balls[0], table.ticks[0][0]);
    let centers = |balls: &Vec<Seen>| balls.iter().map(|seen| seen.center.into()).collect();
    let ball = Ball {
        inertia_factor: spec.inertia_factor,
        spin: spec.spin,
        omega: start.turning.map_or([0.0; 3], |(omega, _)| omega.into()),
        ..ball(spec.radius, spec.mass, start.center.into(), start.velocity.into())
    };
    Problem {
        id: name.into(),
        title: title.into(),
        ground: Ground::Bowl(0.25),
        half: 3.0,
        rolls: scene.motion == MotionLaw::Rolling,
        balls: vec![ball],
        seconds: f64::from(references::SECONDS),
        sample_hz: references::RATE_HZ,
        // Multiples of the 7 Hz of the reference.
        rates_hz: vec![238, 1_001, 4_004],
        cells: vec![128, 512],
        truth: Truth::Centers(table.ticks.iter().map(centers).collect()),
        ..plane(name, title)
    }
}

/// A plane without anything.
fn plane(id: &str, title: &str) -> Problem {
    Problem {
        id: id.into(),
        title: title.into(),
        ground: Ground::Plane,
        walls: None,
        half: 64.0,
        rolls: false,
        gravity: GRAVITY,
        balls: vec![],
        seconds: 1.0,
        sample_hz: 60,
        rates_hz: vec![],
        cells: vec![],
        gas: false,
        truth: Truth::Energy,
    }
}

/// One ball onto a row of four that touch: the last one leaves with its speed.
fn cradle() -> Problem {
    const COUNT: usize = 5;
    let place = |n: usize| if n == 0 { -1.0 } else { n as f64 };
    let speed = |n: usize| if n == 0 { 2.0 } else { 0.0 };
    let at = |n: usize, t: f64| match n {
        0 => 2.0 * t.min(0.5) - 1.0,
        _ if n == COUNT - 1 => n as f64 + 2.0 * (t - 0.5).max(0.0),
        _ => n as f64,
    };
    let (seconds, sample_hz) = (3.0, 60);
    let exact =
        |tick: u64| (0..COUNT).map(|n| [at(n, tick as f64 / f64::from(sample_hz)), 0.0, 0.5]).collect();
    Problem {
        balls: (0..COUNT).map(|n| ball(0.5, 1.0, [place(n), 0.0, 0.5], [speed(n), 0.0, 0.0])).collect(),
        seconds,
        sample_hz,
        rates_hz: vec![240, 960, 9_600, 96_000],
        truth: Truth::Centers((0..=180).map(exact).collect()),
        ..plane("cradle", "One ball onto a row of four that touch, elastic, for 3 s")
    }
}

/// A thousand diameters a sixtieth of a second, between two walls and onto a ball at rest.
fn bullet() -> Problem {
    let radius = 1.0 / 64.0;
    let starts = [(-3.0, 1875.0), (2.5, 0.0)];
    let ends = [-8.0, 8.0];
    let sample_hz = 60;
    let exact = |tick: u64| {
        let places = rods(&starts, radius, ends, tick as f64 / f64::from(sample_hz));
        places.into_iter().map(|x| [x, 0.0, radius]).collect()
    };
    Problem {
        walls: Some([ends; 2]),
        half: 8.0,
        balls: starts.iter().map(|(x, v)| ball(radius, 1.0, [*x, 0.0, radius], [*v, 0.0, 0.0])).collect(),
        sample_hz,
        rates_hz: vec![60, 960, 9_600, 96_000],
        truth: Truth::Centers((0..=60).map(exact).collect()),
        ..plane("bullet", "A bullet of 1875 m/s between two walls and onto a thin target at rest, for 1 s")
    }
}

/// A light ball between a wall and a heavy one: as many hits as the first figures of pi.
fn galperin(hits: u64) -> Problem {
    let heavier = match hits {
        31 => 1e2,
        314 => 1e4,
        _ => 1e6,
    };
    Problem {
        walls: Some([[0.0, 64.0], [-64.0, 64.0]]),
        balls: vec![
            ball(0.25, 1.0, [1.0, 0.0, 0.25], [0.0; 3]),
            ball(0.25, heavier, [2.0, 0.0, 0.25], [-1.0, 0.0, 0.0]),
        ],
        // The last hit is past after 5.7 s at the most, and the far wall not yet reached.
        seconds: 6.0,
        sample_hz: 1,
        rates_hz: vec![1_000, 10_000, 100_000],
        truth: Truth::Velocities(after_hits(heavier, hits), hits),
        ..plane(
            &format!("galperin-{hits}"),
            &format!("Wall, ball, ball {heavier:e} times as heavy: {hits} hits"),
        )
    }
}

/// Velocities after so many hits, of both balls and of the light one and the wall in turn.
fn after_hits(heavier: f64, hits: u64) -> Vec<f64> {
    let [mut light, mut heavy] = [0.0, -1.0];
    for hit in 0..hits {
        if hit % 2 == 0 {
            let common = (light + heavier * heavy) / (1.0 + heavier);
            [light, heavy] = [2.0 * common - light, 2.0 * common - heavy];
        } else {
            light = -light;
        }
    }
    vec![light, heavy]
}

/// Equal balls that cover a fifth of a box, with 1 m/s each: on the plane, or in a bowl whose rim they hardly climb.
fn gas(count: usize, bowl: bool) -> Problem {
    const RADIUS: f64 = 0.05;
    let side = (count as f64 * std::f64::consts::PI * RADIUS * RADIUS / 0.2).sqrt();
    let half = 0.5 * side;
    let walls = [-half, half];
    let (name, floor) = if bowl { ("gas-bowl", "in a shallow bowl") } else { ("gas-flat", "on the plane") };
    let title = format!("{count} elastic balls of 1 m/s {floor}, a fifth of it covered, for 1 s");
    let mut problem = Problem {
        // 6 cm at the middle of a wall: as high as 1 m/s climbs.
        ground: if bowl { Ground::Bowl(0.06 / (half * half)) } else { Ground::Plane },
        walls: Some([walls; 2]),
        half,
        balls: scattered(count, half, RADIUS),
        gas: true,
        rates_hz: match count {
            0..1_000 => vec![240, 960, 3_840],
            1_000 => vec![240, 960],
            _ => vec![240],
        },
        // A cell for every ball: 20 cm.
        cells: if bowl { vec![(count as f64).sqrt().ceil() as usize] } else { vec![] },
        ..plane(&format!("{name}-{count}"), &title)
    };
    ours::set_down(&mut problem).expect("a gas that lies on its floor");
    problem
}

/// Balls on a lattice that is shaken, in random directions.
fn scattered(count: usize, half: f64, radius: f64) -> Vec<Ball> {
    let next = std::cell::RefCell::new(random(count as u64));
    let next = || next.borrow_mut()();
    let side = (count as f64).sqrt().ceil() as usize;
    let cell = 2.0 * half / side as f64;
    let free = 0.9 * (0.5 * cell - radius);
    let shaken = |k: usize| -half + cell * (k as f64 + 0.5) + free * (2.0 * next() - 1.0);
    let places: Vec<[f64; 2]> = (0..count).map(|n| [shaken(n % side), shaken(n / side)]).collect();
    let direction = || loop {
        let [x, y] = [2.0 * next() - 1.0, 2.0 * next() - 1.0];
        let length = f64::hypot(x, y);
        if (0.1..1.0).contains(&length) {
            return [x / length, y / length, 0.0];
        }
    };
    places.into_iter().map(|[x, y]| ball(radius, 1.0, [x, y, radius], direction())).collect()
}
