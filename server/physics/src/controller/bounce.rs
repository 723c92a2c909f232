//! A hit of two bodies that nobody else touches, which is what nearly all are: no list of who else is there, and nobody held.

use super::Controller;
use super::approach::Due;
use crate::detect::ball_wall::Plane;
use crate::detect::broad_phase::is_within;
use crate::diagnostics::{Hit, HitPartner};
use crate::motion::law::State;
use crate::resolve::impact::{Contact, resolve_one};
use crate::schedule::time::Time;
use crate::tolerance::{ALONE_MARGIN, REST_SPEED};
use nalgebra::Vector3;

/// A ball that waits for another to be launched with.
pub(super) type Waiting = Option<(usize, State)>;

impl Controller {
    /// Resolves a landed hit by itself, if that is all there is to it; false if not, and nothing has happened.
    pub(super) fn bounce(&mut self, hit: &Due, contact: &Contact) -> bool {
        let mut members = self.members(hit);
        let slow = contact.closing(&members) <= REST_SPEED;
        if slow || self.is_piling_up(hit) || !self.is_clear_of_others(hit) {
            return false;
        }
        let now = hit.time.max(hit.event);
        self.now = self.now.max(now);
        for landed in hit.landed() {
            self.will_change(landed.ball);
            self.reads_neighbours(landed.ball);
        }
        let impulse = resolve_one(&mut members, contact, self.restitution);
        let at = &hit.landed()[0];
        let point = at.at.center + contact.line * self.balls[at.ball].body.radius;
        self.record(&Hit { time: hit.time, ball: hit.ball, partner: hit.partner, point, impulse });
        let mut waiting = None;
        for (landed, member) in hit.landed().iter().zip(&members) {
            self.balls[landed.ball].count_hit(hit.time.quantum(), false);
            self.send_off(landed.ball, hit.time, (landed.at.state, &member.velocity), &mut waiting);
        }
        self.send_last(hit.time, waiting);
        for landed in hit.landed() {
            self.predict(landed.ball, now);
        }
        for landed in hit.landed() {
            self.has_changed(landed.ball);
        }
        true
    }

    /// Whether a hit more in this quantum is too many for one of its balls.
    fn is_piling_up(&self, hit: &Due) -> bool {
        let quantum = hit.time.quantum();
        hit.landed().iter().any(|landed| {
            let b = &self.balls[landed.ball];
            let before = if b.hits_quantum == quantum { b.hits } else { 0 };
            before >= self.hit_budget
        })
    }

    /// Whether surely nothing touches those who hit but each other: the searches ahead have seen to that.
    fn is_clear_of_others(&self, hit: &Due) -> bool {
        hit.time.since(hit.event).abs() < 0.5 * ALONE_MARGIN
            && hit.landed().iter().all(|landed| {
                let radius = self.balls[landed.ball].body.radius;
                self.queue.alone(landed.ball).holds_at(hit.event)
                    && self.is_clear_of_walls(hit, (landed.ball, &landed.at.center), radius)
            })
    }

    /// Whether no wall but the one that is hit touches a ball at `c`.
    fn is_clear_of_walls(&self, hit: &Due, (ball, c): (usize, &Vector3<f64>), radius: f64) -> bool {
        let hits_wall = matches!(hit.partner, HitPartner::Wall(_));
        if !hits_wall && is_within(&[c.x - radius, c.y - radius, c.x + radius, c.y + radius], &self.room) {
            return true;
        }
        let touch = self.touch(ball, c);
        let touches = |plane: &Plane| plane.distance(c) - radius <= touch;
        let mut others =
            self.walls.iter().enumerate().filter(|(wall, _)| hit.partner != HitPartner::Wall(*wall));
        !others.any(|(_, plane)| touches(plane))
    }

    /// Writes down a hit that did something.
    pub(super) fn record(&mut self, hit: &Hit) {
        if hit.impulse <= 0.0 {
            return;
        }
        match hit.partner {
            HitPartner::Ball(_) => self.report.collisions.ball_ball += 1,
            HitPartner::Wall(_) => self.report.collisions.ball_wall += 1,
        }
        if !self.lists_hits_of(hit.ball) {
            return;
        }
        if self.hits_are_full() {
            self.drop_hits(1);
        } else {
            self.hits.push(*hit);
        }
    }

    /// Puts a ball that left an impact with a new velocity on its next arc, at once or two by two.
    pub(super) fn send_off(
        &mut self,
        ball: usize,
        time: Time,
        (mut state, velocity): (State, &Vector3<f64>),
        waiting: &mut Waiting,
    ) {
        state[2..5].copy_from_slice(velocity.as_slice());
        self.leave(ball, time, &state);
        if !self.work.side_by_side {
            return self.launch(ball, time, &state);
        }
        if self.goes_on_as_foreseen(ball, time, &state) {
            return;
        }
        match waiting.take() {
            None => *waiting = Some((ball, state)),
            Some(other) => self.launch_pair(time, [other, (ball, state)]),
        }
    }

    /// Launches who has waited in vain.
    pub(super) fn send_last(&mut self, time: Time, waiting: Waiting) {
        if let Some((ball, state)) = waiting {
            self.launch(ball, time, &state);
        }
    }
}

impl super::Ball {
    /// Counts a hit in `quantum`; returns how many there were in it, and how many of them slow.
    pub(super) fn count_hit(&mut self, quantum: i64, slow: bool) -> (u32, u32) {
        if self.hits_quantum != quantum {
            (self.hits_quantum, self.hits, self.rest_hits) = (quantum, 0, 0);
        }
        self.hits += 1;
        self.rest_hits += u32::from(slow);
        (self.hits, self.rest_hits)
    }
}
