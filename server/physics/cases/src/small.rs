//! Small scenes to time and to count: some that differ in one feature, and some of everyday use.

use crate::scenes::{as_net, center, cloud, contact, graph, moving, original, plane, still};
use ballroom_physics::surface::bezier::BezierPatch;
use ballroom_physics::{
    Accuracy, BallSpec, Controller, Drive, Floor, MotionLaw, Scene, SceneFault, Time, Wall,
};
use nalgebra::{Vector2, Vector3};
use std::hint::black_box;

const RATE_HZ: u32 = 60;
/// Half the side of a lone ball's floor, m.
const HALF: f64 = 3.0;
/// A bowl of curvature 0.5/m, wide enough that the lone ball meets no wall.
const BOWL: &[(usize, usize, f64)] = &[(2, 0, 0.25), (0, 2, 0.25)];

/// A scene, and how it is run.
#[derive(Clone, Debug)]
pub struct Small {
    /// What tables call it.
    pub name: &'static str,
    /// Simulated seconds of a run.
    pub seconds: u32,
    /// The scene.
    pub scene: Scene,
    /// A force held on the first ball.
    pub drive: Option<Drive>,
    /// Whether all states are read at every tick.
    pub looks: bool,
}

impl Small {
    fn new(name: &'static str, seconds: u32, scene: Scene) -> Self {
        Self { name, seconds, scene, drive: None, looks: true }
    }

    /// The engine at the start.
    pub fn start(&self) -> Result<Controller, SceneFault> {
        let mut engine = Controller::new(&self.scene)?;
        engine.drive(0, self.drive);
        Ok(engine)
    }

    /// Runs it to its end by ticks of 60 Hz, as a server does.
    pub fn run(&self, engine: &mut Controller) {
        for tick in 1..=u64::from(self.seconds * RATE_HZ) {
            engine.advance_to(Time::of_tick(tick, RATE_HZ));
            if self.looks {
                for ball in engine.balls() {
                    black_box(ball);
                }
            }
        }
    }
}

/// One ball for 10 s; each differs from another in one thing.
pub fn lone() -> Vec<Small> {
    let sliding = MotionLaw::Frictionless;
    let rolling = lone_ball(graph(HALF, BOWL, MotionLaw::Rolling));
    let with = |change: fn(&mut Scene)| {
        let mut scene = rolling.clone();
        change(&mut scene);
        scene
    };
    let drive = Drive { direction: Vector2::new(1.0, 0.0), acceleration: 0.5, speed_limit: 4.0 };
    vec![
        Small::new("a ball slides on a plane", 10, lone_ball(plane(HALF))),
        Small::new("a ball rolls on a plane", 10, lone_ball(graph(HALF, &[], MotionLaw::Rolling))),
        Small::new("a ball slides in a bowl", 10, lone_ball(graph(HALF, BOWL, sliding))),
        Small::new("a ball rolls in a bowl", 10, rolling.clone()),
        Small::new("the bowl as a net of heights", 10, as_net(&rolling)),
        Small::new("the bowl as a net of any points", 10, turned(&as_net(&rolling))),
        Small::new("the bowl with eight walls", 10, with(|scene| scene.walls.extend(corners()))),
        Small::new("the bowl with another ball far off", 10, with(|scene| scene.balls.push(opposite()))),
        Small { drive: Some(drive), ..Small::new("the bowl with a force held", 10, rolling.clone()) },
        Small { looks: false, ..Small::new("the bowl with no states read", 10, rolling.clone()) },
    ]
}

/// The first scene of all, gases and cradles.
pub fn everyday() -> Vec<Small> {
    vec![
        Small::new("original", 10, original()),
        Small::new("gas of 100 on a plane", 1, gas(&[], MotionLaw::Frictionless)),
        Small::new("gas of 100 in a bowl", 1, gas(&[(2, 0, 0.00625), (0, 2, 0.00625)], MotionLaw::Rolling)),
        Small::new("cradle", 10, cradle(0.0)),
        Small::new("cradle with gaps", 10, cradle(1.0 / 64.0)),
    ]
}

fn lone_ball(mut scene: Scene) -> Scene {
    scene.accuracy = Accuracy::Tolerance(1e-9);
    scene.balls = vec![moving("ball", 0.05, contact(0.9, 0.2), 0.3, 1.1)];
    scene
}

/// The lone ball's image across the middle of the bowl, where it stays.
fn opposite() -> BallSpec {
    moving("opposite", 0.05, contact(-0.9, -0.2), -0.3, -1.1)
}

/// Four walls across the corners.
fn corners() -> [Wall; 4] {
    let side = 0.5_f64.sqrt();
    [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
        .map(|(x, y)| Wall { point: Vector2::new(x, y) * (0.9 * HALF), normal: Vector2::new(-x, -y) * side })
}

/// The scene turned about the vertical by the angle whose cosine is 4/5.
fn turned(scene: &Scene) -> Scene {
    let turn = |v: Vector2<f64>| Vector2::new(0.8 * v.x - 0.6 * v.y, 0.6 * v.x + 0.8 * v.y);
    let turn_all = |v: &Vector3<f64>| turn(v.xy()).push(v.z);
    let mut scene = scene.clone();
    if let Floor::Bezier(patch) = &scene.floor {
        let net = patch.net().iter().map(turn_all).collect();
        scene.floor = Floor::Bezier(BezierPatch::new(patch.degree(), net).unwrap());
    }
    for wall in &mut scene.walls {
        (wall.point, wall.normal) = (turn(wall.point), turn(wall.normal));
    }
    let place = turn(Vector2::new(0.9, 0.2));
    let velocity = turn(Vector2::new(0.3, 1.1));
    scene.balls = vec![moving("ball", 0.05, contact(place.x, place.y), velocity.x, velocity.y)];
    scene
}

/// Equal balls that cover a fifth of the floor.
fn gas(terms: &[(usize, usize, f64)], motion: MotionLaw) -> Scene {
    let mut scene = graph(1.0, terms, motion);
    scene.accuracy = Accuracy::Tolerance(1e-8);
    scene.balls = cloud(100, [0.05, 0.05], 0.94, 1.2, 1738);
    scene
}

/// Five balls in a row, `gap` m apart, and a sixth that comes in.
fn cradle(gap: f64) -> Scene {
    let mut scene = plane(2.0);
    let row = |i: u8| still(&format!("row-{i}"), 0.125, center(f64::from(i) * (0.25 + gap), 0.0));
    scene.balls = (0..5).map(row).collect();
    scene.balls.push(moving("incoming", 0.125, center(-1.0, 0.0), 1.0, 0.0));
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::in_list_order;

    fn end_of(name: &str) -> Controller {
        let all: Vec<Small> = lone().into_iter().chain(everyday()).collect();
        let small = all.iter().find(|small| small.name == name).unwrap();
        let mut engine = small.start().unwrap();
        small.run(&mut engine);
        engine
    }

    fn height(engine: &Controller) -> f64 {
        in_list_order(engine)[0].center.z
    }

    #[test]
    fn a_bowl_is_the_same_however_it_is_written() {
        let plain = height(&end_of("a ball rolls in a bowl"));
        for name in
            ["the bowl as a net of heights", "the bowl as a net of any points", "the bowl with eight walls"]
        {
            assert!((height(&end_of(name)) - plain).abs() < 1e-8, "{name}");
        }
    }

    #[test]
    fn balls_far_off_and_gases_do_what_their_names_say() {
        let far = end_of("the bowl with another ball far off").report().collisions;
        assert_eq!((far.ball_ball, far.ball_wall), (0, 0));
        let driven = end_of("the bowl with a force held");
        assert!(driven.report().steering_work != 0.0 && driven.report().collisions == far);
        let gas = end_of("gas of 100 in a bowl").report();
        assert!(gas.collisions.ball_ball > 100 && gas.clusters == 0);
        assert!(end_of("cradle").report().clusters > 0 && end_of("cradle with gaps").report().clusters == 0);
    }
}
