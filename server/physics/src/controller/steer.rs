//! Pushes and held forces: the only ways the outside moves a ball.

use super::{Controller, Drive};
use crate::motion::law::{State, velocity};
use crate::schedule::time::{QUANTUM, Time};
use nalgebra::{Vector2, Vector3};

type V3 = Vector3<f64>;

impl Controller {
    /// Adds `delta` (horizontal, m/s) to a ball's velocity inside the tangent plane, without raising the speed
    /// above `speed_limit`; a speed already above it is not raised further. Does nothing for a ball that is not
    /// there or a `delta` that is not finite.
    pub fn push(&mut self, ball: usize, delta: Vector2<f64>, speed_limit: f64) {
        if ball >= self.balls.len() || !delta.iter().all(|x| x.is_finite()) {
            return;
        }
        self.recall();
        let mut state = self.cut(ball);
        let (_, n) = self.balls[ball].body.seat(&self.surface, &state);
        let before = velocity(&state);
        let delta = V3::new(delta.x, delta.y, 0.0);
        let mut after = before + (delta - n * delta.dot(&n));
        let limit = speed_limit.max(before.norm());
        let speed = after.norm();
        if speed > limit {
            after *= limit / speed;
        }
        state[2..5].copy_from_slice(after.as_slice());
        let gain = 0.5 * (after.norm_squared() - before.norm_squared()) / self.balls[ball].inverse_mass;
        self.report.steering_work += gain;
        self.set_off(ball, &state);
    }

    /// Sets or releases the held force on a ball. Does nothing for a ball that is not there or a drive that is
    /// not finite.
    pub fn drive(&mut self, ball: usize, drive: Option<Drive>) {
        let finite = drive.is_none_or(|d| {
            d.direction.iter().all(|x| x.is_finite()) && d.acceleration.is_finite() && d.speed_limit >= 0.0
        });
        if ball >= self.balls.len() || !finite || self.balls[ball].drive == drive {
            return;
        }
        self.recall();
        let state = self.cut(ball);
        self.balls[ball].drive = drive;
        let applied = self.applied(ball, &state, self.time);
        self.change_force(ball, self.now, &state, applied);
    }

    /// The ball's state at the caller's time, integrated to it.
    fn cut(&mut self, ball: usize) -> State {
        self.now = self.now.max(self.time);
        let arc = &self.arcs[ball];
        let dt = self.now.since(arc.start).max(0.0);
        arc.land(&self.balls[ball].body, &self.surface, self.accuracy, dt).0
    }

    fn set_off(&mut self, ball: usize, state: &State) {
        self.relaunch(ball, self.now, state);
        self.predict(ball, self.now);
    }

    /// Energy put in from outside until the controller's time, J: by pushes and held forces, by balls set anew, added and
    /// removed, by a floor or a gravity changed under them. Total energy less this is constant while every hit is elastic.
    pub fn steering_work(&self) -> f64 {
        let running: f64 =
            (0..self.balls.len()).map(|ball| self.holder(ball).work_of_force(ball, self.time)).sum();
        self.report.steering_work + running
    }

    /// Work of the held force along the present arc until `time`, J: the force is constant on an arc.
    #[inline]
    pub(super) fn work_of_force(&self, ball: usize, time: Time) -> f64 {
        // Nearly all arcs end here: no force but gravity.
        if self.balls[ball].body.applied == self.gravity { 0.0 } else { self.work_of_held_force(ball, time) }
    }

    #[cold]
    fn work_of_held_force(&self, ball: usize, time: Time) -> f64 {
        let b = &self.balls[ball];
        let force = (b.body.applied - self.gravity) * b.mass;
        let arc = &self.arcs[ball];
        force.dot(&(arc.center_at(time.since(arc.start)) - arc.center[0]))
    }

    /// At the start of a quantum: the force for the next one. True if it changed and the ball was relaunched.
    pub(super) fn steer_anew(&mut self, ball: usize, time: Time) -> bool {
        let arc = &self.arcs[ball];
        let dt = time.since(arc.start);
        let (seen, ..) = arc.sample(&self.balls[ball].body, &self.surface, dt);
        if self.applied(ball, &seen, time) == self.balls[ball].body.applied {
            return false;
        }
        let state = arc.land(&self.balls[ball].body, &self.surface, self.accuracy, dt).0;
        let applied = self.applied(ball, &state, time);
        self.change_force(ball, time, &state, applied);
        true
    }

    /// Closes the arc under the old force, then goes on under the new one.
    fn change_force(&mut self, ball: usize, time: Time, state: &State, applied: V3) {
        self.close_arc(ball, time);
        self.balls[ball].body.applied = applied;
        self.launch(ball, time, state);
        self.predict(ball, time);
    }

    /// Acceleration of gravity and of the held force until the quantum ends. The force is constant for a whole
    /// quantum, whatever the tick rate. Near the limit its part along the motion is cut so that a quantum of it
    /// cannot pass the limit, nor raise a speed that gravity brought above it.
    pub(super) fn applied(&self, ball: usize, state: &State, time: Time) -> V3 {
        let b = &self.balls[ball];
        let Some(drive) = b.drive else { return self.gravity };
        let push = V3::new(drive.direction.x, drive.direction.y, 0.0) * drive.acceleration;
        let (_, n) = b.body.seat(&self.surface, state);
        let force = push - n * push.dot(&n);
        let w = velocity(state);
        let speed = w.norm();
        let left = Time::of_quantum(time.quantum()).after(QUANTUM).since(time);
        let gain = force.norm() * left;
        if speed + gain <= drive.speed_limit {
            return self.gravity + push;
        }
        // (v + a t)^2 + (b t)^2 <= top^2 for the parts a along and b across the motion, at the quantum's end and,
        // the left side being convex in t, before it.
        let direction = if speed > 0.0 { w / speed } else { V3::zeros() };
        let top = drive.speed_limit.max(speed);
        let along = force.dot(&direction);
        let across = (force - direction * along) * left;
        let room = top * top - across.norm_squared();
        if room <= 0.0 {
            return self.gravity;
        }
        let allowed = (room.sqrt() - speed) / left;
        let cut = if along > allowed { direction * (along - allowed) } else { V3::zeros() };
        self.gravity + (force - cut)
    }
}
