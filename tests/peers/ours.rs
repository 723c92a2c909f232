//! Ballroom beside its peers.

use super::contestant::{Entry, World};
use super::problem::{Ground, Problem, Sample};
use ballroom_physics::{
    Accuracy, BallSpec, Controller, Floor, HIT_BUDGET, MotionLaw, Place, Scene, SceneFault, Time,
};
use nalgebra::{Vector2, Vector3};

/// As the page calls us.
pub const ENGINE: &str = "Ballroom";

/// An entry with this tolerance over 10 s, m.
pub fn entry(tolerance: f64) -> Entry {
    let make = move |problem: &Problem, _: bool| -> Box<dyn World> {
        let engine = Controller::new(&scene(problem, tolerance)).expect("a case that loads");
        Box::new(Ballroom { engine, problem: (problem.sample_hz, problem.rolls) })
    };
    Entry { engine: ENGINE, setting: format!("tolerance {tolerance:e} m"), make: Box::new(make) }
}

struct Ballroom {
    engine: Controller,
    problem: (u32, bool),
}

impl World for Ballroom {
    fn go_to(&mut self, sample: u64) {
        self.engine.advance_to(Time::of_tick(sample, self.problem.0));
    }

    fn look(&self) -> Sample {
        let mut sample = Sample::default();
        for ball in ballroom_cases::scenes::in_list_order(&self.engine) {
            sample.centers.push(ball.center.into());
            sample.velocities.push(ball.velocity.into());
            if self.problem.1 {
                sample.omegas.push(ball.omega.into());
            }
        }
        sample
    }

    fn hits(&self) -> Option<u64> {
        Some(ballroom_cases::ride::hits(&self.engine))
    }
}

/// Where the balls of a problem come to lie, and how fast they are along the floor: what every contestant starts from.
pub fn set_down(problem: &mut Problem) -> Result<(), SceneFault> {
    let engine = Controller::new(&scene(problem, 1e-9))?;
    for (ball, state) in problem.balls.iter_mut().zip(ballroom_cases::scenes::in_list_order(&engine)) {
        ball.center = state.center.into();
        ball.velocity = state.velocity.into();
        ball.omega = state.omega.into();
    }
    Ok(())
}

/// The problem as a scene.
fn scene(problem: &Problem, tolerance: f64) -> Scene {
    let c = if let Ground::Bowl(c) = problem.ground { c } else { 0.0 };
    let terms = if c == 0.0 { vec![] } else { vec![vec![0.0, 0.0, c], vec![0.0; 3], vec![c, 0.0, 0.0]] };
    let half = problem.half;
    let [x, y] = problem.walls.unwrap_or([[-half, half]; 2]);
    Scene {
        floor: Floor::Polynomial { x, y, terms },
        walls: ballroom_cases::scenes::walls(x, y),
        balls: problem.balls.iter().enumerate().map(|(n, _)| ball(problem, n)).collect(),
        gravity: Vector3::new(0.0, 0.0, -problem.gravity),
        motion: if problem.rolls { MotionLaw::Rolling } else { MotionLaw::Frictionless },
        restitution: 1.0,
        accuracy: Accuracy::Tolerance(tolerance),
        hit_budget: HIT_BUDGET,
    }
}

fn ball(problem: &Problem, number: usize) -> BallSpec {
    let ball = &problem.balls[number];
    BallSpec {
        name: format!("{number:06}"),
        radius: ball.radius,
        mass: ball.mass,
        inertia_factor: ball.inertia_factor,
        place: Place::Center(Vector2::new(ball.center[0], ball.center[1])),
        velocity: ball.velocity.into(),
        spin: ball.spin,
    }
}
