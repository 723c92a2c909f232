//! Balls set anew: the outside puts some of them elsewhere, with another velocity or spin; all of them, or none.

use super::Controller;
use super::load::first_step;
use crate::motion::law::{State, velocity};
use crate::scene::Place;
use crate::surface::place;
use crate::tolerance::OVERLAP_ULPS;
use nalgebra::{Vector2, Vector3};

type V3 = Vector3<f64>;

/// Largest speed and spin that may be asked for, as in a scene.
const ABSURD: f64 = 1e12;
/// How far the centre of a [`Spot`] may be from where it was asked for, of the size of its coordinates.
const SPOT_KEPT: f64 = 1e-9;

/// A place for a ball's centre, solved onto the floor by [`Controller::spot`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    center: Vector2<f64>,
    q: [f64; 2],
}

/// What a ball shall be from now on. What is not given stays; a velocity is projected to the tangent plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seat {
    /// Which ball, by id.
    pub ball: usize,
    /// Where.
    pub spot: Option<Spot>,
    /// Velocity of the centre, m/s.
    pub velocity: Option<V3>,
    /// Spin about the floor's normal, rad/s.
    pub spin: Option<f64>,
}

/// Why balls were not set; none of them was.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SeatFault {
    /// A ball that is not there, or a spot that was found for another floor or radius.
    #[error("ball {ball} is not there, or its place was found for another one")]
    Stranger {
        /// Its id.
        ball: usize,
    },
    /// A number that is not finite or too large.
    #[error("velocity and spin of ball {ball} must be finite and at most 1e12")]
    Number {
        /// Its id.
        ball: usize,
    },
    /// A ball that is named twice.
    #[error("ball {ball} is set twice")]
    Twice {
        /// Its id.
        ball: usize,
    },
    /// The balls of the scene slide, and what turns them never changes.
    #[error("ball {ball} slides: nothing changes its spin")]
    Slides {
        /// Its id.
        ball: usize,
    },
    /// No place on the floor.
    #[error("ball {ball} would not be over the floor: {why}")]
    OffFloor {
        /// Its id.
        ball: usize,
        /// What was tried.
        why: &'static str,
    },
    /// In a wall.
    #[error("ball {ball} would reach {depth:e} m into wall {wall}")]
    InWall {
        /// Its id.
        ball: usize,
        /// Place in the scene's list.
        wall: usize,
        /// How deep, m.
        depth: f64,
    },
    /// In another ball.
    #[error("balls {ball} and {other} would overlap by {depth:e} m")]
    Overlap {
        /// Its id.
        ball: usize,
        /// The other's.
        other: usize,
        /// How deep, m.
        depth: f64,
    },
}

/// A ball as it is to stand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seated {
    pub ball: usize,
    pub state: State,
    pub center: V3,
}

impl Controller {
    /// Where `ball` touches the floor when its centre has these x and y. It reads nothing that moves, so that it can be
    /// asked of any controller of the scene, beforehand.
    pub fn spot(&self, ball: usize, center: Vector2<f64>) -> Result<Spot, SeatFault> {
        let radius = self.balls.get(ball).ok_or(SeatFault::Stranger { ball })?.body.radius;
        if !center.iter().all(|x| x.abs() <= ABSURD) {
            return Err(SeatFault::OffFloor { ball, why: "its place is not a finite number" });
        }
        let q = place::contact(&self.surface, &Place::Center(center), radius)
            .map_err(|why| SeatFault::OffFloor { ball, why })?;
        Ok(Spot { center, q })
    }

    /// Sets balls anew at the controller's time, all at once: checked as they will stand, on the floor, in no wall and
    /// in no ball, before any is moved. What follows is a function of what was set, not of what the ball did before, but
    /// for its orientation, which it keeps. The energy put in counts as steering work.
    pub fn set_balls(&mut self, seats: &[Seat]) -> Result<(), SeatFault> {
        let before = self.now;
        self.recall();
        self.now = self.now.max(self.time);
        // A refusal leaves no trace.
        let seated = self.all_seated(seats).inspect_err(|_| self.now = before)?;
        for Seated { ball, state, .. } in &seated {
            self.seat(*ball, state);
        }
        for Seated { ball, .. } in &seated {
            self.predict(*ball, self.now);
        }
        Ok(())
    }

    /// Sets every ball as it stands in `other`, a controller of the same scene at a time of its own, and turned as there,
    /// if there is room for all of them. Held forces end.
    pub fn set_as_in(&mut self, other: &Self) -> Result<(), SeatFault> {
        let stand = other.now.max(other.time);
        self.recall();
        let seated = |ball: usize| {
            let other = other.holder(ball);
            let (arc, body) = (&other.arcs[ball], &other.balls[ball].body);
            let state = arc.land(body, &other.surface, other.accuracy, stand.since(arc.start).max(0.0)).0;
            Seated { ball, state, center: body.seat(&other.surface, &state).0 }
        };
        let all: Vec<_> = (0..self.balls.len().min(other.balls.len())).map(seated).collect();
        self.find_room(&all)?;
        self.stand_as_in(other);
        Ok(())
    }

    /// The same without asking for room: where the balls touch and roll, rounding may have them overlap.
    fn stand_as_in(&mut self, other: &Self) {
        self.now = self.now.max(self.time);
        let stand = other.now.max(other.time);
        for ball in 0..self.balls.len().min(other.balls.len()) {
            let other = other.holder(ball);
            let arc = &other.arcs[ball];
            let dt = stand.since(arc.start).max(0.0);
            let state = arc.land(&other.balls[ball].body, &other.surface, other.accuracy, dt).0;
            let orientation = arc.orientation_at(dt);
            self.release(ball);
            self.seat(ball, &state);
            self.arcs[ball].turning.start = orientation;
        }
        for ball in 0..self.balls.len() {
            self.predict(ball, self.now);
        }
    }

    /// The balls as they are, at time 0 and with every count at 0, in a copy of `start`, a controller of the same scene.
    #[must_use]
    pub fn at_time_zero(&self, start: &Self) -> Self {
        let mut fresh = start.clone();
        fresh.stand_as_in(self);
        fresh.report = crate::diagnostics::Report::default();
        fresh
    }

    /// In the order of ids, and with room for all.
    fn all_seated(&mut self, seats: &[Seat]) -> Result<Vec<Seated>, SeatFault> {
        let mut seated = seats.iter().map(|seat| self.seated(seat)).collect::<Result<Vec<_>, _>>()?;
        seated.sort_by_key(|seated| seated.ball);
        if let Some(pair) = seated.windows(2).find(|pair| pair[0].ball == pair[1].ball) {
            return Err(SeatFault::Twice { ball: pair[0].ball });
        }
        self.find_room(&seated)?;
        Ok(seated)
    }

    fn seated(&self, seat: &Seat) -> Result<Seated, SeatFault> {
        let &Seat { ball, spot, velocity: wanted, spin } = seat;
        let b = self.balls.get(ball).ok_or(SeatFault::Stranger { ball })?;
        let small = |x: &f64| x.abs() <= ABSURD;
        if !wanted.iter().flatten().chain(&spin).all(small) {
            return Err(SeatFault::Number { ball });
        }
        if spin.is_some() && !b.body.rolls {
            return Err(SeatFault::Slides { ball });
        }
        let arc = &self.arcs[ball];
        let mut state = arc.land(&b.body, &self.surface, self.accuracy, self.now.since(arc.start).max(0.0)).0;
        if let Some(spot) = spot {
            state[..2].copy_from_slice(&spot.q);
        }
        let (center, n) = b.body.seat(&self.surface, &state);
        if let Some(spot) = spot
            && (center.xy() - spot.center).amax() > SPOT_KEPT * (1.0 + spot.center.amax())
        {
            return Err(SeatFault::Stranger { ball });
        }
        let w = wanted.unwrap_or_else(|| velocity(&state));
        state[2..5].copy_from_slice((w - n * w.dot(&n)).as_slice());
        if let Some(spin) = spin {
            state[5] = spin * b.body.radius;
        }
        Ok(Seated { ball, state, center })
    }

    /// Refuses what would stand in a wall or in a ball. `seated` is in the order of ids.
    pub(super) fn find_room(&mut self, seated: &[Seated]) -> Result<(), SeatFault> {
        seated.iter().try_for_each(|seated| self.clear_of_walls(seated))?;
        self.clear_of_balls(seated)
    }

    fn clear_of_walls(&self, seated: &Seated) -> Result<(), SeatFault> {
        let &Seated { ball, center, .. } = seated;
        let r = self.balls[ball].body.radius;
        for (wall, plane) in self.walls.iter().enumerate() {
            let depth = r - plane.distance(&center);
            if depth > OVERLAP_ULPS * f64::EPSILON * (center.amax() + plane.point.amax() + r) {
                return Err(SeatFault::InWall { ball, wall, depth });
            }
        }
        Ok(())
    }

    /// No two overlap, of those that are set and those that are not. The others' bounds hold them during their windows.
    fn clear_of_balls(&mut self, seated: &[Seated]) -> Result<(), SeatFault> {
        let before: Vec<_> = seated.iter().map(|s| *self.broad_phase.bounds_of(s.ball)).collect();
        for &Seated { ball, center, .. } in seated {
            let r = self.balls[ball].body.radius;
            self.broad_phase.file(ball, [center.x - r, center.y - r, center.x + r, center.y + r]);
        }
        let fault = seated.iter().find_map(|seated_ball| self.overlap(seated_ball, seated));
        for (seated, bounds) in seated.iter().zip(before) {
            self.broad_phase.file(seated.ball, bounds);
        }
        fault.map_or(Ok(()), Err)
    }

    /// The deepest overlap of one that is to be set.
    fn overlap(&self, &Seated { ball, center, .. }: &Seated, seated: &[Seated]) -> Option<SeatFault> {
        let mut deepest: Option<(usize, f64)> = None;
        self.broad_phase.neighbours(ball, |other| {
            let arc = &self.arcs[other];
            let theirs = seated.binary_search_by_key(&other, |seated| seated.ball).map_or_else(
                |_| arc.center_at(self.now.since(arc.start).max(0.0)),
                |place| seated[place].center,
            );
            let reach = self.balls[ball].body.radius + self.balls[other].body.radius;
            let depth = reach - (theirs - center).norm();
            let rounding = OVERLAP_ULPS * f64::EPSILON * (center.amax() + theirs.amax() + reach);
            if depth > rounding && deepest.is_none_or(|(whom, least)| (depth, other) > (least, whom)) {
                deepest = Some((other, depth));
            }
        });
        deepest.map(|(other, depth)| SeatFault::Overlap { ball, other, depth })
    }

    fn release(&mut self, ball: usize) {
        if self.balls[ball].drive.is_some() {
            self.drive(ball, None);
        }
    }

    /// Puts a ball on a new arc from `state`, to be looked ahead for by the caller when all are seated.
    fn seat(&mut self, ball: usize, state: &State) {
        let arc = &self.arcs[ball];
        let dt = self.now.since(arc.start).max(0.0);
        let old = arc.land(&self.balls[ball].body, &self.surface, self.accuracy, dt).0;
        self.report.steering_work += self.energy_of(ball, state) - self.energy_of(ball, &old);
        self.balls[ball].stepping.try_s = first_step(self.accuracy);
        self.relaunch(ball, self.now, state);
        // Nobody may look for a hit on the new arc within the old one's window.
        self.arcs[ball].window_end = self.now;
    }

    /// Translation, spin and height of a ball in a state, J.
    pub(super) fn energy_of(&self, ball: usize, state: &State) -> f64 {
        let b = &self.balls[ball];
        let k = b.body.inertia_factor;
        let (center, _) = b.body.seat(&self.surface, state);
        let spin = if b.body.rolls { 0.5 * k * state[5] * state[5] } else { 0.0 };
        b.mass * (0.5 * (1.0 + k) * velocity(state).norm_squared() + spin - self.gravity.dot(&center))
    }
}
