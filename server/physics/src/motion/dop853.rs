//! Dormand and Prince 8(5,3): one step of order 8 with a dense output of order 7.
//!
//! Twelve stages, one slope at the end and three more for the dense output. The centre's polynomial and the angle turned
//! come from the same formula, since the stages' velocities are the slopes of the centre and of the angle; the centre's
//! ends are set to the exact ones.

use super::dop853_tableau::{A, B, D as DENSE, E3, E5, STAGES, STAGES_DENSE};
use super::law::{Law, ROLLING, Slope, Stand, rotation, velocity_in};
use super::step::{Step, TERMS, combine, weigh};
use crate::number::{Number, Triple};
use crate::surface::chart::Chart;
use crate::tolerance::ERROR_TIME;
use std::hint::black_box;

/// The stages whose weights are not zero, for each stage; see [`A`].
const USED: [&[usize]; STAGES_DENSE] = [
    &[],
    &[0],
    &[0, 1],
    &[0, 2],
    &[0, 2, 3],
    &[0, 3, 4],
    &[0, 3, 4, 5],
    &[0, 3, 4, 5, 6],
    &[0, 3, 4, 5, 6, 7],
    &[0, 3, 4, 5, 6, 7, 8],
    &[0, 3, 4, 5, 6, 7, 8, 9],
    &[0, 3, 4, 5, 6, 7, 8, 9, 10],
    &SOLUTION,
    &[0, 6, 7, 8, 9, 10, 11, 12],
    &[0, 5, 6, 7, 10, 11, 12, 13],
    &[0, 5, 6, 7, 8, 12, 13, 14],
];
/// The stages that the solution and its error estimates take.
const SOLUTION: [usize; 8] = [0, 5, 6, 7, 8, 9, 10, 11];
/// The stages that the dense output takes.
const INSIDE: [usize; 12] = [0, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// The first stage beside the very first that the inside of a step takes: what only that needs is left out before.
const FIRST_INSIDE: usize = INSIDE[1];

/// A step of which the end is known and the inside is not yet. It is large, and worked on where it lies.
#[derive(Clone, Copy, Debug)]
pub struct Attempt<T, const D: usize> {
    slope: [[T; D]; STAGES_DENSE],
    /// The state at the end.
    end: [T; D],
}

/// What the inside of a step takes beside the slopes: velocities of the centre, and angular velocities of a rolling ball.
#[derive(Clone, Copy, Debug)]
pub struct Inside<T> {
    velocity: [[T; 3]; STAGES_DENSE],
    omega: [[T; 3]; STAGES_DENSE],
}

impl<T: Number> Inside<T> {
    /// Room for a step.
    #[inline(always)]
    pub fn new(like: T) -> Self {
        let nothing = [[like.like(0.0); 3]; STAGES_DENSE];
        Self { velocity: nothing, omega: nothing }
    }

    #[inline(always)]
    fn enter<C, const D: usize>(
        &mut self,
        law: &Law<'_, C, T>,
        stage: usize,
        y: &[T; D],
        slope: &Slope<T, D>,
    ) {
        let velocity = velocity_in(y);
        self.velocity[stage] = velocity.0;
        if D == ROLLING {
            self.omega[stage] = rotation(slope.normal, velocity, y[5], law.inverse_radius).0;
        }
    }
}

impl<T: Number, const D: usize> Attempt<T, D> {
    /// Room for a step.
    #[inline(always)]
    pub fn new(like: T) -> Self {
        let zero = like.like(0.0);
        Self { slope: [[zero; D]; STAGES_DENSE], end: [zero; D] }
    }

    /// The state at which a stage's slope is taken.
    #[inline(always)]
    fn state_of(&self, y: &[T; D], h: T, stage: usize) -> [T; D] {
        combine(y, h, &A[stage], &self.slope, USED[stage])
    }

    /// Stages 1 to 11 after the first, and the state at the end. What only [`Self::finish`] needs goes `inside`, if that is
    /// asked for.
    #[inline(always)]
    pub fn run<C: Chart>(
        &mut self,
        mut inside: Option<&mut Inside<T>>,
        law: &Law<'_, C, T>,
        y: &[T; D],
        slope: &[T; D],
        h: T,
    ) {
        self.slope[0] = *slope;
        // Unrolled, the loop would be larger than the cache for instructions.
        for stage in 1..black_box(STAGES) {
            let at = self.state_of(y, h, stage);
            let slope = law.slope(&at);
            self.slope[stage] = slope.rate;
            if let Some(inside) = inside.as_deref_mut().filter(|_| stage >= FIRST_INSIDE) {
                inside.enter(law, stage, &at, &slope);
            }
        }
        self.end = self.state_of(y, h, STAGES);
    }

    /// The state after the step, and the slope there to first order: enough to land on an event.
    #[inline(always)]
    pub fn landed(&self) -> ([T; D], [T; D]) {
        (self.end, self.slope[STAGES - 1])
    }

    /// Estimates of the order 5 and 3 that belong to the solution's errors per second, component by component.
    #[inline(always)]
    pub fn errors(&self) -> [[T; D]; 2] {
        [weigh(&E5, &self.slope, &SOLUTION), weigh(&E3, &self.slope, &SOLUTION)]
    }

    /// The whole step of an attempt that is kept.
    #[inline(always)]
    pub fn finish<C: Chart>(
        &mut self,
        inside: &mut Inside<T>,
        law: &Law<'_, C, T>,
        y: &[T; D],
        first: &Stand<T, D>,
        h: T,
    ) -> Step<T, D> {
        let end = self.end;
        let last = law.stand(&end);
        self.slope[STAGES] = last.slope.rate;
        inside.enter(law, STAGES, &end, &last.slope);
        let mut reaction_inside = last.slope.reaction;
        for stage in STAGES + 1..black_box(STAGES_DENSE) {
            let at = self.state_of(y, h, stage);
            let slope = law.slope(&at);
            self.slope[stage] = slope.rate;
            inside.enter(law, stage, &at, &slope);
            reaction_inside = slope.reaction;
        }
        inside.enter(law, 0, y, &first.slope);
        let mut rise = end;
        for i in 0..D {
            rise[i] = end[i] - y[i];
        }
        let dense = dense_output(h, y, &rise, &self.slope);
        let center = dense_path(h, first.center, last.center - first.center, &inside.velocity);
        let nothing = Triple([h.like(0.0); 3]);
        let mut turn = [nothing; TERMS];
        if D == ROLLING {
            let mut rise = nothing;
            for i in SOLUTION {
                rise = rise + Triple(inside.omega[i]) * h.like(B[i]);
            }
            let rise = rise * h;
            turn = dense_path(h, nothing, rise, &inside.omega);
        }
        let reaction = [first.slope.reaction, reaction_inside, last.slope.reaction];
        Step { end, dense, center, turn, reaction }
    }
}

/// The error of a step in metres, from Hairer's estimates of order 5 and 3: an error of place counts with the floor's
/// `stretch` at the start, one of velocity with [`ERROR_TIME`], or with the time of a turn by the spin's `precession` where
/// that is less.
///
/// One is to the other as h^2: `five * trust` goes with h^8 as in the source, and with one more square root of `trust` it
/// would go with h^9 as the error itself. Half way between keeps what is obtained nearest to what is asked for from 1e-6 to
/// 1e-12 m: errors of place grow with the number of steps, those of energy faster.
#[inline(always)]
pub fn error_estimate<T: Number, const D: usize>(
    h: T,
    [e, g]: [T; 2],
    precession: T,
    errors: &[[T; D]; 2],
) -> T {
    let turn = precession * ERROR_TIME;
    let time_squared = h.like(ERROR_TIME * ERROR_TIME) / (turn * turn + h.like(1.0));
    let mut squares = [h; 2];
    for (square, sum) in squares.iter_mut().zip(errors) {
        let place = e * sum[0] * sum[0] + g * sum[1] * sum[1];
        let mut speed = sum[2] * sum[2] + sum[3] * sum[3] + sum[4] * sum[4];
        if D == ROLLING {
            speed = larger(speed, sum[5] * sum[5]);
        }
        *square = larger(place, speed * time_squared);
    }
    let [five, three] = squares;
    let trust = (five / (five + three * 0.01)).sqrt();
    let error = h * five.sqrt() * trust * trust.sqrt().sqrt();
    // No error at all is no quotient either.
    five.where_less(h.like(f64::MIN_POSITIVE), h.like(0.0), error)
}

/// The larger of two numbers, or the first if that is none.
#[inline(always)]
fn larger<T: Number>(a: T, b: T) -> T {
    a.where_less(b, b, a)
}

/// The dense output of a point whose slopes are `slopes`.
#[inline(always)]
fn dense_path<T: Number>(
    h: T,
    start: Triple<T>,
    rise: Triple<T>,
    slopes: &[[T; 3]; STAGES_DENSE],
) -> [Triple<T>; TERMS] {
    let dense = dense_output(h, &start.0, &rise.0, slopes);
    let mut out = [start; TERMS];
    for i in 0..TERMS {
        out[i] = Triple(dense[i]);
    }
    out
}

/// The dense output in powers of theta. The source gives it nested in theta and 1 - theta; expanded here.
#[inline(always)]
fn dense_output<T: Number, const D: usize>(
    h: T,
    y: &[T; D],
    rise: &[T; D],
    k: &[[T; D]; STAGES_DENSE],
) -> [[T; D]; TERMS] {
    let mut tail = [*y; 4];
    for i in 0..4 {
        tail[i] = weigh(&DENSE[i], k, &INSIDE);
    }
    let mut out = [*y; TERMS];
    for x in 0..D {
        let f0 = rise[x];
        let f1 = h * k[0][x] - f0;
        let f2 = f0 * 2.0 - h * (k[12][x] + k[0][x]);
        let [f3, f4, f5, f6] = [h * tail[0][x], h * tail[1][x], h * tail[2][x], h * tail[3][x]];
        out[1][x] = f0 + f1;
        out[2][x] = (f2 - f1) + f3;
        out[3][x] = (f4 + f5) - (f2 + f3 * 2.0);
        out[4][x] = (f3 + f6) - (f4 * 2.0 + f5 * 3.0);
        out[5][x] = (f4 + f5 * 3.0) - f6 * 3.0;
        out[6][x] = f6 * 3.0 - f5;
        out[7][x] = -f6;
    }
    out
}
