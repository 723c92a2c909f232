//! Balls about as large as the floor has room for: they run, or the scene is refused by name.

use crate::scenes::{center, graph, load, moving, run};
use ballroom_physics::{Controller, MotionLaw, Scene, SceneFault, Time};

/// A ball that crosses the vertex of z = x^2/2 + y^2/4, whose curvature there is 1/m.
fn bowl(radius: f64, motion: MotionLaw) -> Scene {
    let mut scene = graph(4.0, &[(2, 0, 0.5), (0, 2, 0.25)], motion);
    scene.balls.push(moving("tight", radius, center(0.3, 0.2), -1.0, 0.1));
    scene
}

#[test]
fn a_ball_of_99_hundredths_of_the_radius_of_curvature_runs() {
    for motion in [MotionLaw::Frictionless, MotionLaw::Rolling] {
        let scene = bowl(0.99, motion);
        let energy = load(&scene).energy();
        run(&scene, 60, 240, |_, engine| {
            let ball = engine.ball(0);
            assert!(ball.center.iter().chain(ball.velocity.iter()).all(|x| x.is_finite()), "{ball:?}");
            assert!(
                (engine.energy() / energy - 1.0).abs() < 1e-9,
                "{motion:?} {}",
                engine.energy() / energy - 1.0
            );
        });
    }
}

#[test]
fn a_ball_of_the_radius_of_curvature_or_more_is_refused_at_the_vertex() {
    for radius in [1.0, 1.01, 3.0] {
        let fault = Controller::new(&bowl(radius, MotionLaw::Rolling)).unwrap_err();
        let SceneFault::TooCurved { ball: 0, lo, hi, at } = fault else { panic!("{fault:?}") };
        assert!(lo <= radius && radius <= hi * (1.0 + 1e-12), "{lo} {hi}");
        assert!(at.point.norm() < 0.1 && (at.uv[0] - 0.5).abs() < 0.05, "{at}");
    }
}

#[test]
fn a_scene_without_balls_runs_on_any_regular_floor() {
    let mut scene = bowl(1.0, MotionLaw::Rolling);
    scene.balls.clear();
    let mut engine = load(&scene);
    engine.advance_to(Time::of_seconds(1.0));
    assert!(engine.balls().len() == 0);
}
