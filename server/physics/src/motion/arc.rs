//! An arc: a ball's path from one cut to the next, as polynomials that walls, pairs, ticks and pictures read.
//!
//! On a plane the arc is the exact parabola and does not end by itself; elsewhere it is one integration step.
//! Ticks do not cut arcs: only hits, pushes and changes of force do.

use super::body::Body;
use super::law::{ROLLING, SLIDING, State, velocity};
use super::rotation::Turning;
use super::step::{REACTION_AT, TERMS};
use crate::scene::Accuracy;
use crate::schedule::time::Time;
use crate::surface::chart::Surface;
use crate::tolerance::SANE;
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// What kind of path an arc is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// One integration step on a curved floor.
    Curved,
    /// The exact parabola on a plane.
    Parabola,
    /// Standing still until the quantum ends, because hits piled up.
    Held,
}

/// A ball's path from `start` for `length` seconds.
///
/// What other balls ask of it stands first, in four lines of cache, and for a parabola in two: a search through neighbours
/// reads nothing else.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Arc {
    /// When it begins.
    pub start: Time,
    /// End of the span over which the ball's future has been searched.
    pub window_end: Time,
    /// Radius of the ball, m.
    pub radius: f64,
    /// Bound of the centre's acceleration, m/s^2.
    pub acceleration_bound: f64,
    /// Changes whenever the path does; predictions that carry an older one are void.
    pub stamp: u32,
    /// What kind.
    pub path: Path,
    /// Whether it does not end by itself: its length is infinite.
    pub endless: bool,
    /// Whether its ball is driven, and looks ahead no farther than the quantum.
    pub driven: bool,
    /// Centre in powers of theta; only the first three count unless the arc is curved.
    pub center: [V3; TERMS],
    /// Seconds per unit of theta; 1 unless curved.
    pub scale: f64,
    /// How long it is valid, s.
    pub length: f64,
    /// State at the start.
    pub state: State,
    /// Floor reaction per mass at [`REACTION_AT`], m/s^2.
    pub reaction: [f64; 3],
    /// Slope at the start (curved arcs only).
    pub slope: State,
    /// State in powers of theta (curved arcs only).
    pub dense: [State; TERMS],
    /// State at the end (curved arcs only).
    pub end: State,
    /// The orientation and its course.
    pub turning: Turning,
}

/// What a search reads of an arc fits in four lines, of a parabola in two.
const _: () = assert!(std::mem::offset_of!(Arc, length) <= 256);
const _: () = assert!(std::mem::offset_of!(Arc, center) + 3 * size_of::<V3>() <= 128);

impl Arc {
    /// An arc of a ball of `radius` that holds nothing yet.
    pub const fn empty(radius: f64) -> Self {
        Self {
            start: Time::ZERO,
            window_end: Time::ZERO,
            scale: 1.0,
            radius,
            acceleration_bound: 0.0,
            stamp: 0,
            path: Path::Held,
            endless: false,
            driven: false,
            length: 0.0,
            state: [0.0; ROLLING],
            slope: [0.0; ROLLING],
            center: [V3::new(0.0, 0.0, 0.0); TERMS],
            dense: [[0.0; ROLLING]; TERMS],
            end: [0.0; ROLLING],
            turning: Turning::STILL,
            reaction: [0.0; 3],
        }
    }

    /// Sets the first three terms of the centre, which are all that count unless the arc is curved.
    pub(super) fn set_parabola(&mut self, terms: [V3; 3]) {
        self.center[..3].copy_from_slice(&terms);
    }

    /// Sets for how long it is valid, s.
    pub(super) fn set_length(&mut self, length: f64) {
        (self.length, self.endless) = (length, length == f64::INFINITY);
    }

    /// When it ends.
    #[inline]
    pub fn finish(&self) -> Time {
        if self.endless { Time::NEVER } else { self.start.after(self.length) }
    }

    /// Centre `dt` seconds after the start, m.
    #[inline]
    pub fn center_at(&self, dt: f64) -> V3 {
        if self.path == Path::Curved { self.curved_center(dt) } else { self.parabola_center(dt) }
    }

    /// Velocity of the centre `dt` seconds after the start, the derivative of [`Self::center_at`], m/s.
    #[inline]
    pub fn velocity_at(&self, dt: f64) -> V3 {
        if self.path == Path::Curved { self.curved_velocity(dt) } else { self.parabola_velocity(dt) }
    }

    #[inline]
    pub(crate) fn parabola_center(&self, dt: f64) -> V3 {
        self.center[0] + (self.center[1] + self.center[2] * dt) * dt
    }

    #[inline]
    pub(crate) fn parabola_velocity(&self, dt: f64) -> V3 {
        self.center[1] + self.center[2] * (2.0 * dt)
    }

    fn curved_center(&self, dt: f64) -> V3 {
        let theta = dt / self.scale;
        let mut sum = self.center[TERMS - 1];
        for c in self.center[..TERMS - 1].iter().rev() {
            sum = sum * theta + c;
        }
        sum
    }

    fn curved_velocity(&self, dt: f64) -> V3 {
        let theta = dt / self.scale;
        let mut sum = self.center[TERMS - 1] * (TERMS - 1) as f64;
        for (k, c) in self.center.iter().enumerate().take(TERMS - 1).skip(1).rev() {
            sum = sum * theta + c * k as f64;
        }
        sum / self.scale
    }

    /// The whole state `dt` seconds after the start with centre and normal, read from the arc: to look at, not to go
    /// on from.
    pub fn sample(&self, body: &Body, surface: &Surface, dt: f64) -> (State, V3, V3) {
        if self.path != Path::Curved {
            let state = self.follow(dt);
            let (center, normal) = body.seat(surface, &state);
            return (state, center, normal);
        }
        let mut out = self.read(dt / self.scale);
        let (center, normal) = body.settle(surface, &mut out);
        (out, center, normal)
    }

    /// The state that the polynomials of a curved arc give at `theta`: near the floor's tangent plane, not in it.
    #[inline(always)]
    pub(super) fn read(&self, theta: f64) -> State {
        let mut out = self.dense[TERMS - 1];
        for row in self.dense[..TERMS - 1].iter().rev() {
            for (o, c) in out.iter_mut().zip(row) {
                *o = *o * theta + c;
            }
        }
        out
    }

    /// State `dt` seconds after the start, integrated afresh: what a hit is resolved on; and on a curved arc its slope, which
    /// comes with it.
    pub fn land(&self, body: &Body, surface: &Surface, accuracy: Accuracy, dt: f64) -> (State, State) {
        match self.path {
            Path::Curved if dt <= 0.0 => (self.state, self.slope),
            Path::Curved => body.land(surface, accuracy, &self.state, &self.slope, dt),
            Path::Parabola | Path::Held => (self.follow(dt), [0.0; ROLLING]),
        }
    }

    /// Exact state on a parabola, or of a held ball.
    #[inline]
    pub(super) fn follow(&self, dt: f64) -> State {
        let mut out = self.state;
        if self.path == Path::Held {
            return out;
        }
        let moved = (self.center[1] + self.center[2] * dt) * dt;
        out[0] += moved.x;
        out[1] += moved.y;
        let w = velocity(&self.state) + self.center[2] * (2.0 * dt);
        out[2..5].copy_from_slice(w.as_slice());
        out
    }

    /// Orientation `dt` seconds after the start.
    pub fn orientation_at(&self, dt: f64) -> [f64; 4] {
        self.turning.at(dt / self.scale)
    }

    /// Whether every number of a launched arc is finite and of a size that can be worked with.
    pub fn is_sane(&self) -> bool {
        // All are looked at, whatever the first say: that is quicker.
        let fine = |all: bool, x: &f64| all & (x.abs() <= SANE);
        let [a, b, c, rest @ ..] = &self.center;
        let all = a.iter().chain(b).chain(c).fold(true, fine) & self.state.iter().fold(true, fine);
        let curved = || rest.iter().flatten().chain(&self.end).fold(true, fine);
        all && (self.path != Path::Curved || curved())
    }

    /// Seconds of the first `dt` of an arc during which the floor would have had to pull: the reaction
    /// is taken as the parabola through three exact values, at 64 midpoints; it is a warning, not a result.
    pub fn negative_reaction(&self, dt: f64) -> f64 {
        if self.path == Path::Held || self.reaction.iter().all(|n| *n >= 0.0) {
            return 0.0;
        }
        if self.path == Path::Parabola {
            return dt;
        }
        let [a, b, c] = self.reaction;
        let m = REACTION_AT[1];
        let second = ((c - a) - (b - a) / m) / (1.0 - m);
        let first = (c - a) - second;
        let at = |x: f64| a + (first + second * x) * x;
        let end = (dt / self.scale).clamp(0.0, 1.0);
        let cells = 64;
        let below = (0..cells).filter(|i| at((f64::from(*i) + 0.5) / f64::from(cells) * end) < 0.0).count();
        below as f64 / f64::from(cells) * end * self.scale
    }
}

/// The leading numbers of a state.
pub(super) fn narrow<const D: usize>(state: &State) -> [f64; D] {
    std::array::from_fn(|i| state[i])
}

/// The numbers of a short state as a whole one; a sliding ball's orientation is kept elsewhere.
pub(super) fn widen<const D: usize>(y: &[f64; D]) -> State {
    let mut out = [0.0; ROLLING];
    out[..D].copy_from_slice(y);
    out
}

const _: () = assert!(SLIDING < ROLLING);
