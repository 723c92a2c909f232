//! Small scenes, run tick by tick as the server does.

use crate::callgrind::count;
use ballroom_cases::scenes::{center, cloud, contact, graph, moving, original, plane, still};
use ballroom_physics::{Accuracy, BallSpec, Collisions, Controller, MotionLaw, Scene, Time};

const RATE_HZ: u32 = 60;

/// A scene and the seconds that are counted.
pub struct Small {
    /// What the counts call it.
    pub name: &'static str,
    /// Simulated seconds.
    pub seconds: u64,
    /// The scene.
    pub scene: Scene,
}

/// All of them.
pub fn all() -> Vec<Small> {
    let small = |name, seconds, scene| Small { name, seconds, scene };
    vec![
        small("original", 10, original()),
        small("one ball rolling on a bumpy floor", 10, rolling()),
        small(
            "one ball sliding on a bumpy floor",
            10,
            Scene { motion: MotionLaw::Frictionless, ..rolling() },
        ),
        small("one ball sliding on a plane", 10, sliding()),
        small("gas of 100 in a bowl", 1, gas(&[(2, 0, 0.00625), (0, 2, 0.00625)], MotionLaw::Rolling)),
        small("gas of 100 on a plane", 1, gas(&[], MotionLaw::Frictionless)),
        small("cradle", 10, cradle()),
    ]
}

/// Scenes of which little but hits is seen: hits with walls, hits of balls.
fn hits() -> [(&'static str, Scene); 4] {
    let bowl = |half| {
        let mut scene = graph(half, &[(2, 0, 0.05), (0, 2, 0.05)], MotionLaw::Rolling);
        scene.accuracy = Accuracy::Tolerance(1e-9);
        scene
    };
    let with = |mut scene: Scene, balls: &[BallSpec]| {
        scene.balls = balls.to_vec();
        scene
    };
    let one = [moving("ball", 0.25, contact(0.0, 0.0), 4.0, 3.0)];
    let left = moving("left", 0.25, contact(-0.5, 0.0), 4.0, 0.0);
    let right = moving("right", 0.25, contact(0.5, 0.0), -4.0, 0.0);
    let two = [left, right];
    [
        ("hit: a wall on a plane", with(plane(0.5), &one)),
        ("hit: a wall in a bowl", with(bowl(0.5), &one)),
        ("hit: two balls and walls on a plane", with(plane(1.0), &two)),
        ("hit: two balls and walls in a bowl", with(bowl(1.0), &two)),
    ]
}

/// Counts all of them: instructions of a simulated second, and of a hit with the way to it.
pub fn run() {
    for Small { name, seconds, scene } in all() {
        let mut engine = Controller::new(&scene).expect("a scene that loads");
        count(&format!("scene: {name}"), seconds, || run_ticks(&mut engine, seconds));
    }
    for (name, scene) in hits() {
        let mut engine = Controller::new(&scene).expect("a scene that loads");
        let until = Time::of_seconds(10.0);
        let Collisions { ball_ball, ball_wall } = engine.clone().advance_to(until).collisions;
        assert!(ball_ball + ball_wall > 50, "{name}: {ball_ball} and {ball_wall} hits");
        count(name, ball_ball + ball_wall, || engine.advance_to(until));
    }
}

fn run_ticks(engine: &mut Controller, seconds: u64) {
    for tick in 1..=seconds * u64::from(RATE_HZ) {
        engine.advance_to(Time::of_tick(tick, RATE_HZ));
    }
}

fn rolling() -> Scene {
    let terms = [(2, 0, 0.2), (0, 2, 0.15), (1, 1, 0.05), (3, 0, -0.03), (1, 2, 0.02)];
    let mut scene = graph(3.0, &terms, MotionLaw::Rolling);
    scene.accuracy = Accuracy::Tolerance(1e-9);
    scene.balls = vec![moving("ball", 0.05, contact(0.9, 0.2), 0.3, 1.1)];
    scene
}

fn sliding() -> Scene {
    let mut scene = plane(3.0);
    scene.balls = vec![moving("ball", 0.05, center(0.9, 0.2), 0.3, 1.1)];
    scene
}

/// Equal balls that cover a fifth of the floor.
fn gas(terms: &[(usize, usize, f64)], motion: MotionLaw) -> Scene {
    let mut scene = graph(1.0, terms, motion);
    scene.accuracy = Accuracy::Tolerance(1e-8);
    scene.balls = cloud(100, [0.05, 0.05], 0.94, 1.2, 1738);
    scene
}

fn cradle() -> Scene {
    let mut scene = plane(2.0);
    let places = [0.0, 0.25, 0.5, 0.75, 1.0];
    scene.balls =
        places.iter().zip(1..).map(|(x, i)| still(&format!("row-{i}"), 0.125, center(*x, 0.0))).collect();
    scene.balls.push(moving("incoming", 0.125, center(-1.0, 0.0), 1.0, 0.0));
    scene
}
