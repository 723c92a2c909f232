//! A scene in a mirror must run as the mirror image, without a bit of difference.

use crate::ride;
use crate::scenes::as_net;
use ballroom_physics::surface::bezier::BezierPatch;
use ballroom_physics::{BallState, Controller, Floor, Place, Scene, SceneFault, Time};
use nalgebra::Vector3;

/// The scene in a mirror across x = 0: coordinates negated, parameters kept, spin turned about.
pub fn mirrored(scene: &Scene) -> Scene {
    let mut scene = as_net(scene);
    if let Floor::Bezier(patch) = &scene.floor {
        let net = patch.net().iter().map(mirrored_vector).collect();
        scene.floor = Floor::Bezier(BezierPatch::new(patch.degree(), net).expect("a net of the same size"));
    }
    scene.gravity.x = -scene.gravity.x;
    for wall in &mut scene.walls {
        wall.point.x = -wall.point.x;
        wall.normal.x = -wall.normal.x;
    }
    for ball in &mut scene.balls {
        if let Place::Center(p) | Place::Contact(p) = &mut ball.place {
            p.x = -p.x;
        }
        ball.velocity.x = -ball.velocity.x;
        ball.spin = -ball.spin;
    }
    scene
}

fn mirrored_vector(v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(-v.x, v.y, v.z)
}

/// A ball seen in the same mirror.
pub fn mirrored_state(ball: &BallState) -> BallState {
    let [x, y, z, w] = ball.orientation;
    BallState {
        uv: ball.uv,
        center: mirrored_vector(&ball.center),
        normal: mirrored_vector(&ball.normal),
        velocity: mirrored_vector(&ball.velocity),
        omega: -mirrored_vector(&ball.omega),
        orientation: [x, -y, -z, w],
    }
}

/// Number of tick states of single balls that differ between a scene's mirror image and the run of the mirrored scene
/// (0 and -0 are one number).
pub fn differing_states(scene: &Scene, rate_hz: u32, ticks: u64) -> Result<u64, SceneFault> {
    let scene = as_net(scene);
    let mut image = Controller::new(&mirrored(&scene))?;
    let mut differing = 0;
    ride::run(&scene, rate_hz, ticks, |tick, engine| {
        image.advance_to(Time::of_tick(tick, rate_hz));
        let pairs = engine.balls().zip(image.balls());
        differing += pairs.filter(|(ball, seen)| mirrored_state(ball) != *seen).count() as u64;
    })?;
    Ok(differing)
}
