//! Landing on hits: the balls of several at once, and each hit moved until its balls touch.

use super::Controller;
use crate::diagnostics::HitPartner;
use crate::lanes::LANES_MAX;
use crate::motion::arc::Path;
use crate::motion::law::{State, velocity};
use crate::motion::together::{self, Landing, Seat};
use crate::resolve::impact::{Contact, Member};
use crate::schedule::time::Time;
use crate::tolerance::{self, POLISH, POLISH_ROUNDS, REST_SPEED, TOUCH_ULPS};

/// A ball landed on the instant of an impact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Landed {
    pub ball: usize,
    pub at: Landing,
}

/// A hit that is due: who meets, and from [`Controller::approach`] on when and where.
#[derive(Clone, Copy, Debug)]
pub(super) struct Due {
    pub ball: usize,
    /// A ball of a larger id, or a wall.
    pub partner: HitPartner,
    /// What it was predicted for.
    pub event: Time,
    /// The instant of the impact.
    pub time: Time,
    /// The ball, and the other if there is one.
    landed: [Landed; 2],
}

impl Due {
    /// Nobody's hit.
    pub(super) const NOBODY: Self = Self {
        ball: usize::MAX,
        partner: HitPartner::Wall(usize::MAX),
        event: Time::NEVER,
        time: Time::NEVER,
        landed: [Landed { ball: usize::MAX, at: Landing::NOWHERE }; 2],
    };

    /// A hit predicted for `event`.
    pub(super) fn new(ball: usize, partner: HitPartner, event: Time) -> Self {
        let (ball, partner) = match partner {
            HitPartner::Ball(other) => (ball.min(other), HitPartner::Ball(ball.max(other))),
            HitPartner::Wall(_) => (ball, partner),
        };
        let other = if let HitPartner::Ball(other) = partner { other } else { ball };
        let landed = [ball, other].map(|ball| Landed { ball, at: Landing::NOWHERE });
        Self { ball, partner, event, time: event, landed }
    }

    /// Whether both are one hit.
    pub(super) fn is(&self, other: &Self) -> bool {
        (self.ball, self.partner, self.event) == (other.ball, other.partner, other.event)
    }

    /// Those who are landed.
    pub(super) fn landed(&self) -> &[Landed] {
        let count = if let HitPartner::Ball(_) = self.partner { 2 } else { 1 };
        &self.landed[..count]
    }

    fn landed_mut(&mut self) -> &mut [Landed] {
        let count = self.landed().len();
        &mut self.landed[..count]
    }
}

impl Controller {
    /// Lands the balls of `hits` on the instants of their impacts; no more than [`LANES_MAX`] balls.
    pub(super) fn approach(&self, hits: &mut [Due]) {
        let mut done = [false; LANES_MAX];
        for round in 0..=POLISH_ROUNDS {
            let open = hits.iter_mut().zip(&mut done).filter(|(_, done)| !**done);
            self.land_all(open.map(|(hit, _)| hit));
            let open = hits.iter_mut().zip(&mut done).filter(|(_, done)| !**done);
            for (hit, done) in open {
                *done = self.polish(hit, round == POLISH_ROUNDS);
            }
            if done[..hits.len()].iter().all(|done| *done) {
                break;
            }
        }
    }

    /// Lands the balls of one hit on the instant of their impact.
    pub(super) fn approach_one(&self, hit: &mut Due) {
        for round in 0..=POLISH_ROUNDS {
            let time = hit.time;
            for landed in hit.landed_mut() {
                *landed = self.land(landed.ball, time);
            }
            if self.polish(hit, round == POLISH_ROUNDS) {
                break;
            }
        }
    }

    /// Lands one ball.
    pub(super) fn land(&self, ball: usize, time: Time) -> Landed {
        let (arc, body) = (&self.arcs[ball], &self.balls[ball].body);
        let dt = time.since(arc.start).max(0.0);
        Landed { ball, at: together::land_alone(&self.surface, self.accuracy, Seat { body, arc, dt }) }
    }

    /// Lands the balls of `hits` at the times that these have now: all at once, the same numbers.
    fn land_all<'a>(&self, hits: impl Iterator<Item = &'a mut Due>) {
        let mut targets: [Option<&mut Landing>; LANES_MAX] = [const { None }; LANES_MAX];
        let mut seats: [Option<Seat<'_>>; LANES_MAX] = [None; LANES_MAX];
        let mut count = 0;
        for hit in hits {
            let time = hit.time;
            for landed in hit.landed_mut() {
                let arc = &self.arcs[landed.ball];
                let dt = time.since(arc.start).max(0.0);
                seats[count] = Some(Seat { body: &self.balls[landed.ball].body, arc, dt });
                targets[count] = Some(&mut landed.at);
                count += 1;
            }
        }
        together::land(&self.surface, self.accuracy, &seats[..count], &mut targets[..count]);
    }

    /// Moves a landed hit to where its balls touch, to first order; whether that is enough, or the `last` that is done.
    fn polish(&self, hit: &mut Due, last: bool) -> bool {
        let (gap, closing, speed) = self.gap(hit);
        let Some(shift) = self.correction(gap, closing, hit) else { return true };
        hit.time = hit.time.after(shift);
        let done = last || shift.abs() * speed <= POLISH;
        if done {
            for landed in hit.landed_mut() {
                self.shift(landed, shift);
            }
        }
        done
    }

    /// Gap of the balls of a landed hit, m, their closing speed and the larger of their speeds, m/s.
    fn gap(&self, hit: &Due) -> (f64, f64, f64) {
        let a = &hit.landed[0];
        let (radius, w) = (self.balls[a.ball].body.radius, velocity(&a.at.state));
        match hit.partner {
            HitPartner::Ball(_) => {
                let b = &hit.landed[1];
                let apart = b.at.center - a.at.center;
                let distance = apart.norm();
                let wb = velocity(&b.at.state);
                let closing = (w - wb).dot(&apart) / distance;
                let reach = radius + self.balls[b.ball].body.radius;
                (distance - reach, closing, w.norm().max(wb.norm()))
            }
            HitPartner::Wall(wall) => {
                let plane = &self.walls[wall];
                (plane.distance(&a.at.center) - radius, -w.dot(&plane.normal), w.norm())
            }
        }
    }

    /// Seconds by which a hit must be moved to close `gap`; None when it stands within rounding, when nothing
    /// closes, or when the place lies beyond the arcs (a graze that they did not see alike). Never before the arcs
    /// begin.
    fn correction(&self, gap: f64, closing: f64, hit: &Due) -> Option<f64> {
        let landed = hit.landed();
        let size = landed.iter().map(|l| l.at.center.amax()).fold(0.0, f64::max);
        if closing <= REST_SPEED || gap.abs() <= TOUCH_ULPS * f64::EPSILON * size {
            return None;
        }
        let arcs = landed.iter().map(|l| &self.arcs[l.ball]);
        let earliest =
            arcs.clone().map(|arc| -hit.time.since(arc.start).max(0.0)).fold(f64::NEG_INFINITY, f64::max);
        let latest = arcs.map(|arc| arc.finish().since(hit.time)).fold(tolerance::POLISH_SPAN, f64::min);
        let shift = (gap / closing).max(earliest);
        (shift <= latest).then_some(shift)
    }

    /// Moves a landed ball by a small time along its slope.
    fn shift(&self, landed: &mut Landed, shift: f64) {
        let body = &self.balls[landed.ball].body;
        let at = &mut landed.at;
        let slope = match self.arcs[landed.ball].path {
            Path::Parabola => body.slope(&self.surface, &at.state),
            Path::Curved | Path::Held => at.slope,
        };
        for (y, s) in at.state.iter_mut().zip(&slope) {
            *y += s * shift;
        }
        (at.center, at.normal) = body.settle(&self.surface, &mut at.state);
    }

    /// A landed ball as the solver of impacts sees it.
    pub(super) fn member(&self, landed: &Landed) -> Member {
        Member {
            velocity: velocity(&landed.at.state),
            normal: landed.at.normal,
            inverse_mass: self.balls[landed.ball].inverse_mass,
        }
    }

    /// The two of a landed hit; with a wall only the first is anybody.
    pub(super) fn members(&self, hit: &Due) -> [Member; 2] {
        [&hit.landed[0], &hit.landed[1]].map(|landed| self.member(landed))
    }

    /// The contact of a landed hit, and how far its balls overlap, m.
    pub(super) fn contact(&self, hit: &Due) -> (Contact, f64) {
        let a = &hit.landed[0];
        let radius = self.balls[a.ball].body.radius;
        match hit.partner {
            HitPartner::Ball(_) => {
                let b = &hit.landed[1];
                let apart = b.at.center - a.at.center;
                let distance = apart.norm();
                let reach = radius + self.balls[b.ball].body.radius;
                (Contact { a: 0, b: Some(1), line: apart / distance }, reach - distance)
            }
            HitPartner::Wall(wall) => {
                let plane = &self.walls[wall];
                let depth = radius - plane.distance(&a.at.center);
                (Contact { a: 0, b: None, line: -plane.normal }, depth)
            }
        }
    }

    /// What a landed hit makes of its balls if nothing else touches them and it is not slow.
    pub(super) fn outcome(&self, hit: &Due) -> Option<[State; 2]> {
        let mut members = self.members(hit);
        let (contact, _) = self.contact(hit);
        if contact.closing(&members) <= REST_SPEED {
            return None;
        }
        crate::resolve::impact::resolve_one(&mut members, &contact, self.restitution);
        let mut states = hit.landed.map(|landed| landed.at.state);
        for (state, member) in states.iter_mut().zip(&members) {
            state[2..5].copy_from_slice(member.velocity.as_slice());
        }
        Some(states)
    }
}
