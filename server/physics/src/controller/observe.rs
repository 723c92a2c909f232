//! What a tick shows: states, energy, hash. Looking changes nothing.

use super::{BallState, Controller};
use crate::motion::law::{angular_velocity, velocity};
use crate::motion::rotation;
use nalgebra::Vector2;

impl Controller {
    /// Reads every ball's state at the caller's time off its arc.
    pub(super) fn observe(&mut self) {
        for (ball, out) in self.states.iter_mut().enumerate() {
            let b = &self.balls[ball];
            let arc = &self.arcs[ball];
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
            *out = BallState { uv: Vector2::new(u, v), center, normal: n, velocity: w, omega, orientation };
        }
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

    /// Hash of everything that influences the future; equal at equal times whatever the tick rate and the order
    /// of the scene's list.
    pub fn state_hash(&self) -> u64 {
        let mut hash = Hash(0x243f_6a88_85a3_08d3);
        hash.time(self.time);
        for ((ball, b), arc) in self.balls.iter().enumerate().zip(&self.arcs) {
            hash.time(arc.start);
            hash.time(b.window_end);
            hash.word(arc.path as u64);
            hash.number(arc.length);
            arc.state
                .iter()
                .chain(&arc.orientation)
                .chain(b.body.applied.iter())
                .for_each(|x| hash.number(*x));
            hash.number(b.stepping.try_s);
            hash.word(u64::from(b.rest_hits) << 32 | u64::from(b.stamp));
            hash.word(u64::from(b.hits));
            hash.word(b.hits_quantum as u64);
            if let Some(drive) = b.drive {
                drive.direction.iter().for_each(|x| hash.number(*x));
                hash.number(drive.acceleration);
                hash.number(drive.speed_limit);
            }
            let (time, kind, low, high) = self.queue.of(ball).key(ball as u32);
            hash.time(time);
            hash.word(u64::from(kind));
            hash.word(u64::from(low) << 32 | u64::from(high));
        }
        hash.word(self.report.collisions.ball_ball);
        hash.word(self.report.collisions.ball_wall);
        hash.0
    }
}

/// Mixes words one by one with the finaliser of splitmix64 (Steele, Lea, Flood 2014).
struct Hash(u64);

impl Hash {
    fn word(&mut self, word: u64) {
        let mut x = (self.0 ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        self.0 = x ^ (x >> 31);
    }

    fn number(&mut self, x: f64) {
        self.word(x.to_bits());
    }

    fn time(&mut self, time: crate::schedule::time::Time) {
        self.word(time.quantum() as u64);
        self.number(time.offset());
    }
}
