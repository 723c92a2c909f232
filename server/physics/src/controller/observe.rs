//! What a tick shows: states, energy. Read off the arcs when somebody asks; looking changes nothing.

use super::{BallState, Controller};
use crate::motion::law::{State, angular_velocity, velocity};
use crate::motion::rotation;
use nalgebra::{Vector2, Vector3};

type V3 = Vector3<f64>;

impl Controller {
    /// A ball at the controller's time, by id: about 0.3 us on a curved floor, most of it for the orientation.
    pub fn ball(&self, ball: usize) -> BallState {
        let at = self.holder(ball);
        let b = &at.balls[ball];
        let (state, center, normal) = at.seen(ball);
        let [u, v] = self.surface.uv([state[0], state[1]]);
        let w = velocity(&state);
        let (omega, orientation) = if b.body.rolls {
            let arc = &at.arcs[ball];
            let dt = at.time.since(arc.start).max(0.0);
            (angular_velocity(&normal, &w, state[5], b.body.radius), arc.orientation_at(dt))
        } else {
            let angle = b.free_omega * self.time.seconds();
            (b.free_omega, rotation::of_rotation_vector(angle))
        };
        BallState { uv: Vector2::new(u, v), center, normal, velocity: w, omega, orientation }
    }

    /// The balls at the controller's time, by id, each computed as it is asked for.
    pub fn balls(&self) -> impl ExactSizeIterator<Item = BallState> + Clone + '_ {
        (0..self.balls.len()).map(|ball| self.ball(ball))
    }

    /// State, centre and normal at the controller's time.
    pub(super) fn seen(&self, ball: usize) -> (State, V3, V3) {
        let arc = &self.arcs[ball];
        let dt = self.time.since(arc.start).max(0.0);
        arc.sample(&self.balls[ball].body, &self.surface, dt)
    }

    /// Total energy at the controller's time, J: translation, rotation, height. The spin of a sliding ball, which
    /// nothing changes, is left out.
    pub fn energy(&self) -> f64 {
        let of_ball = |ball: usize| {
            let at = self.holder(ball);
            let (state, center, normal) = at.seen(ball);
            let velocity = velocity(&state);
            let omega = angular_velocity(&normal, &velocity, state[5], at.balls[ball].body.radius);
            self.energy_seen(ball, &BallState { center, normal, velocity, omega, ..BallState::default() })
        };
        (0..self.balls.len()).map(of_ball).sum()
    }

    /// A ball's part of [`Self::energy`] in a state that was read, J.
    pub fn energy_seen(&self, ball: usize, state: &BallState) -> f64 {
        let b = &self.holder(ball).balls[ball];
        let k = b.body.inertia_factor;
        let mut spin = 0.0;
        if b.body.rolls {
            let sigma = state.omega.dot(&state.normal) * b.body.radius;
            spin = 0.5 * k * sigma * sigma;
        }
        b.mass * (0.5 * (1.0 + k) * state.velocity.norm_squared() + spin - self.gravity.dot(&state.center))
    }
}
