//! Small scenes, and hits with the way to them.

use crate::counted::count;
use ballroom_cases::scenes::{contact, graph, moving, plane};
use ballroom_cases::small::{everyday, lone};
use ballroom_physics::{Accuracy, BallSpec, Collisions, Controller, MotionLaw, Scene, Time};

/// Counts those whose names are wanted: instructions of a simulated second, and of a hit.
pub fn run(wanted: impl Fn(&str) -> bool) {
    for small in lone().into_iter().chain(everyday()) {
        let name = format!("scene: {}", small.name);
        if wanted(&name) {
            let mut engine = small.start().expect("a scene that loads");
            count(&name, u64::from(small.seconds), || small.run(&mut engine));
        }
    }
    for (name, scene) in hits().into_iter().filter(|(name, _)| wanted(name)) {
        let mut engine = Controller::new(&scene).expect("a scene that loads");
        let until = Time::of_seconds(10.0);
        let Collisions { ball_ball, ball_wall } = engine.clone().advance_to(until).collisions;
        assert!(ball_ball + ball_wall > 50, "{name}: {ball_ball} and {ball_wall} hits");
        count(name, ball_ball + ball_wall, || engine.advance_to(until));
    }
}

/// Scenes in which hits follow one another.
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
