//! What a tick shows: states, energy. Looking changes nothing.

use super::{BallState, Controller};
use crate::motion::law::{angular_velocity, velocity};
use crate::motion::rotation;
use nalgebra::Vector2;

impl Controller {
    /// Reads every ball's state at the caller's time off its arc.
    pub(super) fn observe(&mut self) {
        for ball in 0..self.balls.len() {
            self.observe_one(ball);
        }
    }

    /// The same of one ball.
    pub(super) fn observe_one(&mut self, ball: usize) {
        let b = &self.balls[ball];
        let arc = &mut self.arcs[ball];
        let dt = self.time.since(arc.start).max(0.0);
        let (state, center, n) = arc.sample(&b.body, &self.surface, dt);
        let w = velocity(&state);
        let [u, v] = self.surface.uv([state[0], state[1]]);
        let (omega, orientation) = if b.body.rolls {
            (angular_velocity(&n, &w, state[5], b.body.radius), arc.orientation_at(dt))
        } else {
            let angle = b.free_omega * self.time.seconds();
            (b.free_omega, rotation::of_rotation_vector(angle))
        };
        self.states[ball] =
            BallState { uv: Vector2::new(u, v), center, normal: n, velocity: w, omega, orientation };
    }

    /// Total energy at the controller's time, J: translation, rotation, height. The spin of a sliding ball, which
    /// nothing changes, is left out.
    pub fn energy(&self) -> f64 {
        self.balls
            .iter()
            .zip(&self.states)
            .map(|(b, s)| {
                let k = b.body.inertia_factor;
                let sigma = s.omega.dot(&s.normal) * b.body.radius;
                let spin = if b.body.rolls { 0.5 * k * sigma * sigma } else { 0.0 };
                b.mass * (0.5 * (1.0 + k) * s.velocity.norm_squared() + spin - self.gravity.dot(&s.center))
            })
            .sum()
    }
}
