//! Turning a ball, without platform sine and cosine: about an axis that stands still, and along an arc.

use super::step::TERMS;
use crate::lanes::Lanes;
use crate::number::{Number, Triple, row};
use crate::schedule::time::Time;
use crate::tolerance::{
    TURN_BRACKET, TURN_PIECE, TURN_PIECES_MAX, TURN_REMAINDER, TURN_STEPS_PER_SERIES, TURN_TERMS_MAX,
};
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

type V3 = Vector3<f64>;

/// Coefficients of an arc's angular velocity.
pub(super) const RATE_TERMS: usize = TERMS - 1;

/// An orientation that follows an angular velocity, given as its integral `turn` in powers of theta (rad).
///
/// A rate of constant direction is exact. Else theta from 0 to 1 is divided evenly into pieces, so that fast spin costs
/// pieces here and not steps of the motion. A rate that hardly changes its direction takes Magnus steps of order 6
/// (S. Blanes, F. Casas, J. Ros, "Improved high order integrators based on the Magnus expansion", BIT 40, 2000); where
/// those would be many, the quaternion is summed as its own power series, of any order that the wanted error needs. The pieces stand
/// fixed, so that a look depends on its own time alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turning {
    /// Integral of the angular velocity in powers of theta, rad; zero when sliding.
    pub turn: [V3; TERMS],
    /// Orientation at theta = 0, ball to world: x, y, z, w.
    pub start: [f64; 4],
    /// Pieces from theta = 0 to 1; 0 if the rate keeps its direction.
    pub pieces: u32,
    /// Whether a piece is a Magnus step, or else a power series.
    pub magnus: bool,
    /// Halvings of a Magnus step's angle after which its series converges at once.
    pub doublings: u32,
    /// Rotation that may be left out, rad.
    pub left_out: f64,
}

impl Turning {
    /// Not turning at all.
    pub const STILL: Self = Self {
        turn: [V3::new(0.0, 0.0, 0.0); TERMS],
        start: [0.0, 0.0, 0.0, 1.0],
        pieces: 0,
        magnus: false,
        doublings: 0,
        left_out: 1.0,
    };

    /// From the orientation `start` with another rate; Magnus steps in all, or each series, may leave out `left_out` rad.
    pub fn begin(&mut self, turn: [V3; TERMS], left_out: f64) {
        self.turn = turn;
        self.plan(&Sizes::of(&turn.map(Triple::from)), left_out);
    }

    /// Finds how the orientation is to follow the turn, whose `sizes` are known.
    pub(super) fn plan(&mut self, sizes: &Sizes<f64>, left_out: f64) {
        self.left_out = left_out;
        if sizes.bend == 0.0 {
            (self.magnus, self.pieces, self.doublings) = (true, 0, 0);
            return;
        }
        let (series, steps) = (sizes.series_pieces(), sizes.magnus_pieces(left_out));
        self.magnus = steps <= TURN_STEPS_PER_SERIES * series;
        self.pieces = if self.magnus { steps } else { series };
        self.doublings = doublings(sizes.fastest / f64::from(self.pieces));
    }

    /// The orientation at `theta`.
    pub fn at(&self, theta: f64) -> [f64; 4] {
        if theta == 0.0 || self.turn[1..].iter().all(|c| *c == V3::zeros()) {
            return self.start;
        }
        if self.pieces == 0 {
            return unit(compose(of_rotation_vector(along(&self.turn, theta)), self.start));
        }
        unit(self.follow(theta))
    }

    /// The orientation at `theta`, of unit length but for the rounding of its pieces.
    fn follow(&self, theta: f64) -> [f64; 4] {
        let h = 1.0 / f64::from(self.pieces);
        let whole = (theta / h) as u32;
        let q = if self.magnus {
            Arch::new().dispatch(Steps { turning: self, q: self.start, pieces: 0..whole })
        } else {
            (0..whole).fold(self.start, |q, piece| self.turned(q, f64::from(piece) * h, h))
        };
        let from = f64::from(whole) * h;
        if theta > from { self.turned(q, from, theta - from) } else { q }
    }

    /// An orientation turned on from theta = `from` by `h`.
    fn turned(&self, q: [f64; 4], from: f64, h: f64) -> [f64; 4] {
        let by = if self.magnus {
            let angle = magnus(rates(&self.turn, h), from + 0.5 * h, h);
            exponential(angle, None, self.doublings)
        } else {
            series(&rate_from(&self.turn, from, h), self.left_out)
        };
        compose(by, q)
    }
}

/// Sizes of a turn, rad.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizes<T> {
    /// Sum of its coefficients' lengths.
    pub length: T,
    /// Bound of its rate.
    pub fastest: T,
    /// Bound of what one Magnus step for the whole turn leaves out.
    pub left_out: T,
    /// What of its coefficients lies across the first's direction; 0 if the rate keeps its direction.
    pub bend: T,
}

impl<T: Number> Sizes<T> {
    /// The terms that a Magnus step of order 6 leaves out are brackets of seven orders of h in all. Each holds a term of the
    /// rate, across the rate's first direction, and other terms for the rest of the orders; each bracket more has a smaller
    /// weight.
    #[inline(always)]
    pub(super) fn of(turn: &[Triple<T>; TERMS]) -> Self {
        let first = turn[1].norm();
        let least = first.like(f64::MIN_POSITIVE);
        let divisor = least.where_less(first, first, least);
        let (mut length, mut across, mut axis) = ([first; TERMS], [first; TERMS], turn[1]);
        for i in 0..3 {
            axis.0[i] = axis.0[i] / divisor;
        }
        for k in 2..TERMS {
            length[k] = turn[k].norm();
            across[k] = turn[k].cross(axis).norm();
        }
        let mut sizes = Self { length: first, fastest: first, left_out: first, bend: across[2] };
        for k in 2..TERMS {
            sizes.length = sizes.length + length[k];
            sizes.fastest = sizes.fastest + length[k] * k as f64;
        }
        let weighed = |k: usize| length[k] * TURN_BRACKET;
        let [a, b, c, d, e] = [weighed(1), weighed(2), weighed(3), weighed(4), weighed(5)];
        let rest = [
            a,
            a * a + b,
            a * a * a + a * b + c,
            a * a * a * a + a * a * b + b * b + a * c + d,
            a * a * a * a * a + a * a * a * b + a * b * b + a * a * c + b * c + a * d + e,
        ];
        sizes.left_out = across[2] * rest[4];
        for k in 3..7 {
            sizes.left_out = sizes.left_out + across[k] * rest[6 - k];
            sizes.bend = sizes.bend + across[k];
        }
        sizes.left_out = sizes.left_out * TURN_REMAINDER;
        sizes.bend = sizes.bend + across[7];
        sizes
    }
}

impl Sizes<f64> {
    /// Of a turn that has none.
    pub(super) const NONE: Self = Self { length: 0.0, fastest: 0.0, left_out: 0.0, bend: 0.0 };

    /// Pieces of about [`TURN_PIECE`].
    fn series_pieces(&self) -> u32 {
        (self.length / TURN_PIECE).ceil().clamp(1.0, TURN_PIECES_MAX) as u32
    }

    /// Magnus steps after which the error at theta = 1 is at most `allowed` rad.
    fn magnus_pieces(&self, allowed: f64) -> u32 {
        let mut pieces: u32 = 1;
        while f64::from(pieces) < TURN_PIECES_MAX && self.left_out > allowed * f64::from(pieces).powi(6) {
            pieces += pieces.div_ceil(4);
        }
        pieces
    }
}

/// The angle turned by `theta`.
fn along(turn: &[V3; TERMS], theta: f64) -> V3 {
    turn[1..].iter().rev().fold(V3::zeros(), |sum, c| (sum + c) * theta)
}

/// Magnus steps one after the other; their rotations are computed side by side.
struct Steps<'a> {
    turning: &'a Turning,
    q: [f64; 4],
    pieces: Range<u32>,
}

impl WithSimd for Steps<'_> {
    type Output = [f64; 4];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 4] {
        let Self { turning, mut q, pieces } = self;
        let length = 1.0 / f64::from(turning.pieces);
        let each = Lanes::new(simd, |_| length);
        let rates = rates(&turning.turn, each);
        for first in pieces.clone().step_by(S::F64_LANES) {
            let middle = Lanes::new(simd, |lane| f64::from(first + lane as u32) * length + 0.5 * length);
            let by = exponential(magnus(rates, middle, each), None, turning.doublings);
            let count = S::F64_LANES.min((pieces.end - first) as usize);
            for lane in 0..count {
                q = compose([by[0].lane(lane), by[1].lane(lane), by[2].lane(lane), by[3].lane(lane)], q);
            }
        }
        q
    }
}

/// Coefficients of the angular velocity that `turn` is the integral of, the same in every lane.
#[inline(always)]
fn rates<T: Number>(turn: &[V3; TERMS], of: T) -> [Triple<T>; RATE_TERMS] {
    let mut rate = [Triple([of; 3]); RATE_TERMS];
    for k in 0..RATE_TERMS {
        let c = turn[k + 1] * (k + 1) as f64;
        rate[k] = Triple(row(of, &[c.x, c.y, c.z]));
    }
    rate
}

/// Rotation vector of the piece of length `h` around `middle`, of a rate in powers of theta.
#[inline(always)]
pub(super) fn magnus<T: Number>(mut rate: [Triple<T>; RATE_TERMS], middle: T, h: T) -> Triple<T> {
    // The rate and its derivatives over factorials at the middle: a Taylor shift.
    for k in 0..RATE_TERMS - 1 {
        for i in (k..RATE_TERMS - 1).rev() {
            rate[i] = rate[i] + rate[i + 1] * middle;
        }
    }
    let (h2, h3) = (h * h, h * h * h);
    let [a0, a1, a2, a3, a4, _, a6] = rate;
    // Moments about the middle that reproduce the rate's integrals to order 6.
    let first = a0 * h - a4 * (h3 * h2 * (3.0 / 560.0));
    let second = a1 * h2 + a3 * (h2 * h2 * (3.0 / 20.0));
    let third = a2 * h3 + a4 * (h3 * h2 * (3.0 / 14.0));
    let c1 = first.cross(second);
    let c2 = first.cross(third + third + c1) * h.like(-1.0 / 60.0);
    // The part that commutes is the angle turned, whatever its order.
    let even = a2 * h.like(1.0 / 12.0) + (a4 * h.like(1.0 / 80.0) + a6 * (h2 * (1.0 / 448.0))) * h2;
    let turned = (a0 + even * h2) * h;
    turned + (c1 - first * h.like(20.0) - third).cross(second + c2) * h.like(1.0 / 240.0)
}

/// Coefficients of the angular velocity in powers of (theta - from)/h, times h: a Taylor shift.
fn rate_from(turn: &[V3; TERMS], from: f64, h: f64) -> [V3; RATE_TERMS] {
    let mut rate: [V3; RATE_TERMS] = std::array::from_fn(|k| turn[k + 1] * (k + 1) as f64);
    if from != 0.0 {
        for k in 0..RATE_TERMS - 1 {
            for i in (k..RATE_TERMS - 1).rev() {
                let higher = rate[i + 1];
                rate[i] += higher * from;
            }
        }
    }
    let mut power = 1.0;
    rate.map(|c| {
        power *= h;
        c * power
    })
}

/// The quaternion at 1 of q' = (rate, 0) q / 2 from the identity at 0, where `rate` is in powers of the parameter:
/// `2 (n+1) q_(n+1) = sum over k of (rate_k, 0) q_(n-k)`. Every rate's own term is in it before the sum may end.
fn series(rate: &[V3; RATE_TERMS], left_out: f64) -> [f64; 4] {
    let least = 0.25 * left_out * left_out;
    let counts = |k: &usize| rate[*k].norm_squared() > least;
    let last = (0..RATE_TERMS).rev().find(counts).map_or(0, |k| k + 1);
    let (mut v, mut w) = (V3::zeros(), 1.0);
    // The latest terms, the newest first.
    let mut terms = [(V3::zeros(), 0.0); RATE_TERMS];
    terms[0].1 = 1.0;
    let mut small = 0;
    for n in 1..TURN_TERMS_MAX {
        let (mut term_v, mut term_w) = (V3::zeros(), 0.0);
        for (c, (of_v, of_w)) in rate.iter().zip(&terms).take(n.min(last)) {
            term_v += c * *of_w + c.cross(of_v);
            term_w -= c.dot(of_v);
        }
        let share = 0.5 / n as f64;
        (term_v, term_w) = (term_v * share, term_w * share);
        v += term_v;
        w += term_w;
        small = if term_v.norm_squared() + term_w * term_w > least { 0 } else { small + 1 };
        if n >= last && small == 2 {
            break;
        }
        terms.rotate_right(1);
        terms[0] = (term_v, term_w);
    }
    [v.x, v.y, v.z, w]
}

/// Quaternion (x, y, z, w) of the rotation by |`angle`| about `angle`: the error grows with the angle, about 1e-16 per
/// radian.
pub fn of_rotation_vector(angle: V3) -> [f64; 4] {
    exponential(angle.into(), None, doublings(angle.norm()))
}

/// The same, of a ball that has turned at `omega`, rad/s, since the start. One that does not turn needs no series.
#[inline]
pub fn of_steady_spin(omega: &V3, time: Time) -> [f64; 4] {
    if *omega == V3::zeros() {
        [omega.x, omega.y, omega.z, 1.0]
    } else {
        of_rotation_vector(omega * time.seconds())
    }
}

/// Halvings after which half of `angle` is at most 1/4.
fn doublings(angle: f64) -> u32 {
    let (mut half, mut count) = (0.5 * angle, 0);
    while half > 0.25 && count < 60 {
        half *= 0.5;
        count += 1;
    }
    count
}

/// The same quaternion. The half angle is halved `most` times, or in each lane as often as `doublings` says, to below 1/4
/// where Taylor series are exact to rounding, and the quaternion is squared as often.
#[inline(always)]
pub(super) fn exponential<T: Number>(angle: Triple<T>, doublings: Option<T>, most: u32) -> [T; 4] {
    let of = angle.0[0];
    let mut half = angle * of.like(0.5);
    for count in 0..most {
        half = while_due(count, doublings, half * of.like(0.5), half);
    }
    let x = half.dot(half);
    // sin(s)/s and 1 - cos(s) for s^2 = x <= 1/16; the first terms left out are below 1e-17.
    let mut sinc = of.like(SINC[5]);
    let mut versine = of.like(VERSINE[5]);
    for k in (0..5).rev() {
        sinc = sinc * x + of.like(SINC[k]);
        versine = versine * x + of.like(VERSINE[k]);
    }
    let one = of.like(1.0);
    let mut v = half * (one + sinc * x);
    let mut w = one - versine * x;
    for count in 0..most {
        // (v, w)^2 = (2 w v, w^2 - v^2), brought back to unit length.
        let next = w * w - v.dot(v);
        let twice = v * (w + w);
        let inverse = one / (next * next + twice.dot(twice)).sqrt();
        v = while_due(count, doublings, twice * inverse, v);
        w = while_due(count, doublings, Triple([next * inverse; 3]), Triple([w; 3])).0[0];
    }
    let Triple([x, y, z]) = v;
    [x, y, z, w]
}

/// `next` in the lanes that double more than `count` times, which are all if there is nothing to choose by, else `last`.
#[inline(always)]
fn while_due<T: Number>(count: u32, doublings: Option<T>, next: Triple<T>, last: Triple<T>) -> Triple<T> {
    match doublings {
        Some(doublings) => Triple::where_less(doublings.like(f64::from(count)), doublings, next, last),
        None => next,
    }
}

/// Coefficients of (sin(s)/s - 1)/s^2 in powers of s^2.
const SINC: [f64; 6] =
    [-1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0, 1.0 / 6_227_020_800.0];
/// Coefficients of (1 - cos(s))/s^2 in powers of s^2.
const VERSINE: [f64; 6] =
    [1.0 / 2.0, -1.0 / 24.0, 1.0 / 720.0, -1.0 / 40_320.0, 1.0 / 3_628_800.0, -1.0 / 479_001_600.0];

/// The rotation `after` applied after `before`.
#[inline(always)]
pub fn compose<T: Number>(after: [T; 4], before: [T; 4]) -> [T; 4] {
    let ([ax, ay, az, aw], [bx, by, bz, bw]) = (after, before);
    let (a, b) = (Triple([ax, ay, az]), Triple([bx, by, bz]));
    let Triple([x, y, z]) = b * aw + a * bw + a.cross(b);
    [x, y, z, aw * bw - a.dot(b)]
}

/// A quaternion brought back to unit length.
#[inline(always)]
pub fn unit<T: Number>([x, y, z, w]: [T; 4]) -> [T; 4] {
    let length = (x * x + y * y + z * z + w * w).sqrt();
    let (zero, one) = (x.like(0.0), x.like(1.0));
    let inverse = one / length;
    let of = |part: T, none: T| zero.where_less(length, part * inverse, none);
    [of(x, zero), of(y, zero), of(z, zero), of(w, one)]
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A rate that changes size and direction.
    fn turn(size: f64) -> [V3; TERMS] {
        let terms = [
            [0.0, 0.0, 0.0],
            [1.0, 0.3, 0.0],
            [0.0, 0.8, -0.2],
            [-0.3, 0.1, 0.4],
            [0.1, -0.1, 0.05],
            [0.02, 0.03, -0.04],
            [0.01, 0.0, 0.02],
            [0.0, -0.01, 0.01],
        ];
        terms.map(|c| V3::from(c) * size)
    }

    /// q' = (omega, 0) q / 2 by the classical scheme of Runge and Kutta in many steps.
    fn slowly(turn: &[V3; TERMS], theta: f64) -> [f64; 4] {
        let slope = |t: f64, q: [f64; 4]| {
            let rate = (1..TERMS).rev().fold(V3::zeros(), |sum, k| sum * t + turn[k] * k as f64);
            compose([rate.x, rate.y, rate.z, 0.0], q).map(|x| 0.5 * x)
        };
        let ahead =
            |q: [f64; 4], k: [f64; 4], s: f64| -> [f64; 4] { std::array::from_fn(|i| q[i] + s * k[i]) };
        let h = theta / 8192.0;
        (0..8192).fold([0.0, 0.0, 0.0, 1.0], |q, step| {
            let t = f64::from(step) * h;
            let k1 = slope(t, q);
            let k2 = slope(t + 0.5 * h, ahead(q, k1, 0.5 * h));
            let k3 = slope(t + 0.5 * h, ahead(q, k2, 0.5 * h));
            let k4 = slope(t + h, ahead(q, k3, h));
            std::array::from_fn(|i| q[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
        })
    }

    #[test]
    fn what_a_turn_leaves_out_is_what_it_may() {
        for (size, theta) in [(0.1, 1.0), (1.0, 0.5), (1.0, 1.0), (9.0, 1.0)] {
            let exact = slowly(&turn(size), theta);
            for left_out in [1e-5, 1e-8, 1e-13] {
                let mut turning = Turning::STILL;
                turning.begin(turn(size), left_out);
                let q = turning.at(theta);
                assert_eq!(q, turning.at(theta), "a look changed the next");
                let error = (0..4).map(|i| (q[i] - exact[i]).abs()).fold(0.0, f64::max);
                assert!(error < left_out * (1.0 + 2.0 * size), "{error:e} of {left_out:e}, size {size}");
            }
        }
    }

    /// Smooth rates of every size and bend.
    pub fn turns() -> impl Iterator<Item = [V3; TERMS]> {
        let mut seed = 5_u64;
        let mut random = move || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        (0..2000).map(move |_| {
            let size = 10.0_f64.powf(1.5 * random());
            let shrink = 0.5 * random().abs();
            let bent = if random() > 0.0 { 1.0 } else { 0.01 };
            let mut scale = size;
            std::array::from_fn(|k| {
                if k == 0 {
                    return V3::zeros();
                }
                let across = if k == 1 { 1.0 } else { bent };
                let c = V3::new(random(), across * random(), across * random()) * (scale / k as f64);
                scale *= shrink;
                c
            })
        })
    }

    #[test]
    fn magnus_steps_and_series_leave_out_what_they_may() {
        let mut taken = [0; 2];
        for turn in turns() {
            for allowed in [1e-6, 1e-9, 1e-12] {
                let mut turning = Turning::STILL;
                turning.begin(turn, allowed);
                let quick = turning.at(1.0);
                taken[usize::from(turning.magnus)] += 1;
                let (pieces, magnus) = (turning.pieces, turning.magnus);
                turning.begin(turn, 1e-16);
                turning.magnus = false;
                turning.pieces = Sizes::of(&turn.map(Triple::from)).series_pieces();
                let fine = turning.at(1.0);
                let apart = (0..4).map(|i| (quick[i] - fine[i]).abs()).fold(0.0, f64::max) * 2.0;
                // Each series may leave as much out, and rounding grows with the pieces and the angle.
                let may = allowed * if magnus { 1.0 } else { f64::from(pieces.max(1)) }
                    + 1e-15 * f64::from(pieces + 40);
                assert!(apart <= may, "{apart:e} of {allowed:e} in {pieces} pieces, magnus {magnus}");
            }
        }
        assert!(taken.iter().all(|count| *count > 500), "{taken:?}");
    }

    #[test]
    fn a_turn_agrees_with_sine_and_cosine() {
        for angle in [0.0, 1e-9, 0.2, 1.0, 3.0, 100.0] {
            let [x, y, z, w] = of_rotation_vector(Vector3::new(0.0, angle, 0.0));
            let tolerance = 4e-16 * (1.0 + angle);
            assert_eq!([x, z], [0.0, 0.0]);
            assert!((y - (0.5 * angle).sin()).abs() <= tolerance, "{angle}: {y}");
            assert!((w - (0.5 * angle).cos()).abs() <= tolerance, "{angle}: {w}");
        }
    }

    #[test]
    fn two_quarter_turns_make_a_half_turn() {
        let quarter = of_rotation_vector(Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_2));
        let half = compose(quarter, quarter);
        assert!((half[2] - 1.0).abs() < 1e-15 && half[3].abs() < 1e-15);
    }
}
