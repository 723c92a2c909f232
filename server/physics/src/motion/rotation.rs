//! Turning a ball, without platform sine and cosine: about an axis that stands still, and along an arc.

use super::step::TERMS;
use crate::tolerance::{TURN_BRACKET, TURN_PIECES_MAX, TURN_REMAINDER};
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// An orientation that follows an angular velocity, given as its integral `turn` in powers of theta (rad).
///
/// A rate of constant direction is exact. Else Magnus steps of order 6 (S. Blanes, F. Casas, J. Ros, "Improved high
/// order integrators based on the Magnus expansion", BIT 40, 2000) in pieces that divide theta from 0 to 1 evenly: fast
/// spin costs pieces here, not steps of the motion. What was followed is kept, so that later looks go on from there; since
/// the pieces stand fixed, a look never changes another.
#[derive(Clone, Copy, Debug)]
pub struct Turning {
    /// Integral of the angular velocity in powers of theta, rad; zero when sliding.
    pub turn: [V3; TERMS],
    /// Orientation at theta = 0, ball to world: x, y, z, w.
    pub start: [f64; 4],
    /// Pieces from theta = 0 to 1; 0 if the rate keeps its direction.
    pub pieces: u32,
    /// How many pieces have been followed, and the orientation there.
    pub followed: (u32, [f64; 4]),
}

impl Turning {
    /// Not turning at all.
    pub const STILL: Self = Self {
        turn: [V3::new(0.0, 0.0, 0.0); TERMS],
        start: [0.0, 0.0, 0.0, 1.0],
        pieces: 0,
        followed: (0, [0.0, 0.0, 0.0, 1.0]),
    };

    /// From the orientation `start` with another rate, to be followed with an error of at most `allowed` rad by
    /// theta = 1.
    pub fn begin(&mut self, turn: [V3; TERMS], allowed: f64) {
        self.turn = turn;
        self.pieces = pieces(&turn, allowed);
        self.followed = (0, self.start);
    }

    /// The orientation at `theta`.
    pub fn at(&mut self, theta: f64) -> [f64; 4] {
        if theta == 0.0 || self.turn[1..].iter().all(|c| *c == V3::zeros()) {
            return self.start;
        }
        if self.pieces == 0 {
            return unit(compose(of_rotation_vector(along(&self.turn, theta)), self.start));
        }
        let h = 1.0 / f64::from(self.pieces);
        let whole = (theta / h) as u32;
        if whole < self.followed.0 {
            self.followed = (0, self.start);
        }
        let (done, mut q) = self.followed;
        for piece in done..whole {
            q = compose(of_rotation_vector(magnus(&self.turn, (f64::from(piece) + 0.5) * h, h)), q);
        }
        self.followed = (whole, q);
        let rest = theta - f64::from(whole) * h;
        if rest > 0.0 {
            q = compose(of_rotation_vector(magnus(&self.turn, theta - 0.5 * rest, rest)), q);
        }
        unit(q)
    }
}

/// The angle turned by `theta`.
fn along(turn: &[V3; TERMS], theta: f64) -> V3 {
    turn[1..].iter().rev().fold(V3::zeros(), |sum, c| (sum + c) * theta)
}

/// Pieces after which the error at theta = 1 is at most `allowed` rad; 0 if the rate keeps its direction.
///
/// The terms that a step of order 6 leaves out are brackets of seven orders of h in all. Each holds a term of the rate,
/// across the rate's first direction, and other terms for the rest of the orders; each bracket more has a smaller weight.
fn pieces(turn: &[V3; TERMS], allowed: f64) -> u32 {
    let axis = turn[1] / turn[1].norm().max(f64::MIN_POSITIVE);
    let across = turn.map(|c| c.cross(&axis).norm());
    if across[2..].iter().all(|x| *x == 0.0) {
        return 0;
    }
    let [_, a, b, c, d, e, ..] = turn.map(|c| TURN_BRACKET * c.norm());
    let rest = [
        a,
        a * a + b,
        a * a * a + a * b + c,
        a * a * a * a + a * a * b + b * b + a * c + d,
        a * a * a * a * a + a * a * a * b + a * b * b + a * a * c + b * c + a * d + e,
    ];
    let left_out = TURN_REMAINDER * (2..7).map(|k| across[k] * rest[6 - k]).sum::<f64>();
    let mut pieces: u32 = 1;
    while pieces < TURN_PIECES_MAX && left_out > allowed * f64::from(pieces).powi(6) {
        pieces += pieces.div_ceil(4);
    }
    pieces
}

/// Rotation vector of the piece of length `h` around `middle`.
fn magnus(turn: &[V3; TERMS], middle: f64, h: f64) -> V3 {
    // The rate and its derivatives over factorials at the middle: a Taylor shift.
    let mut rate: [V3; TERMS - 1] = std::array::from_fn(|k| turn[k + 1] * (k + 1) as f64);
    for k in 0..TERMS - 2 {
        for i in (k..TERMS - 2).rev() {
            let higher = rate[i + 1];
            rate[i] += higher * middle;
        }
    }
    let (h2, h3) = (h * h, h * h * h);
    let [a0, a1, a2, a3, a4, _, a6] = rate;
    // Moments about the middle that reproduce the rate's integrals to order 6.
    let first = a0 * h - a4 * (h3 * h2 * (3.0 / 560.0));
    let second = a1 * h2 + a3 * (h2 * h2 * (3.0 / 20.0));
    let third = a2 * h3 + a4 * (h3 * h2 * (3.0 / 14.0));
    let c1 = first.cross(&second);
    let c2 = first.cross(&(third * 2.0 + c1)) * (-1.0 / 60.0);
    // The part that commutes is the angle turned, whatever its order.
    let turned = (a0 + (a2 * (1.0 / 12.0) + (a4 * (1.0 / 80.0) + a6 * (h2 / 448.0)) * h2) * h2) * h;
    turned + (first * -20.0 - third + c1).cross(&(second + c2)) / 240.0
}

/// Quaternion (x, y, z, w) of the rotation by |`angle`| about `angle`.
///
/// The half angle is halved until below 1/4, where Taylor series are exact to rounding, and the quaternion is
/// squared as often: the error grows with the angle, about 1e-16 per radian.
pub fn of_rotation_vector(angle: V3) -> [f64; 4] {
    let mut half = angle * 0.5;
    let mut doublings = 0;
    while half.norm_squared() > 1.0 / 16.0 && doublings < 60 {
        half *= 0.5;
        doublings += 1;
    }
    let x = half.norm_squared();
    // sin(s)/s and 1 - cos(s) for s^2 = x <= 1/16; the first terms left out are below 1e-17.
    let sinc = 1.0
        - x / 6.0
            * (1.0 - x / 20.0 * (1.0 - x / 42.0 * (1.0 - x / 72.0 * (1.0 - x / 110.0 * (1.0 - x / 156.0)))));
    let versine = x / 2.0
        * (1.0 - x / 12.0 * (1.0 - x / 30.0 * (1.0 - x / 56.0 * (1.0 - x / 90.0 * (1.0 - x / 132.0)))));
    let mut v = half * sinc;
    let mut w = 1.0 - versine;
    for _ in 0..doublings {
        // (v, w)^2 = (2 w v, w^2 - v^2), brought back to unit length.
        let next = w * w - v.norm_squared();
        v *= 2.0 * w;
        let length = (next * next + v.norm_squared()).sqrt();
        v /= length;
        w = next / length;
    }
    [v.x, v.y, v.z, w]
}

/// The rotation `after` applied after `before`.
pub fn compose(after: [f64; 4], before: [f64; 4]) -> [f64; 4] {
    let (a, b) = (Vector3::new(after[0], after[1], after[2]), Vector3::new(before[0], before[1], before[2]));
    let v = b * after[3] + a * before[3] + a.cross(&b);
    [v.x, v.y, v.z, after[3] * before[3] - a.dot(&b)]
}

/// A quaternion brought back to unit length.
pub fn unit(q: [f64; 4]) -> [f64; 4] {
    let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    if length > 0.0 { q.map(|x| x / length) } else { [0.0, 0.0, 0.0, 1.0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_of_a_turn_converge_with_order_six() {
        // A rate that changes size and direction, turning some 2 rad.
        let turn = [
            V3::zeros(),
            V3::new(1.0, 0.3, 0.0),
            V3::new(0.0, 0.8, -0.2),
            V3::new(-0.3, 0.1, 0.4),
            V3::new(0.1, -0.1, 0.05),
            V3::new(0.02, 0.03, -0.04),
            V3::zeros(),
            V3::zeros(),
        ];
        let by = |pieces: u32| {
            let h = 1.0 / f64::from(pieces);
            (0..pieces).fold([0.0, 0.0, 0.0, 1.0], |q, i| {
                compose(of_rotation_vector(magnus(&turn, (f64::from(i) + 0.5) * h, h)), q)
            })
        };
        let exact = by(512);
        let error = |pieces| {
            let q = by(pieces);
            (0..4).map(|i| (q[i] - exact[i]).abs()).fold(0.0, f64::max)
        };
        assert!(error(8) < 1e-8, "{:e}", error(8));
        let order = (error(8) / error(16)).log2();
        assert!(order > 5.7, "observed order {order}");
    }

    /// Rates of every size and bend.
    fn turns() -> impl Iterator<Item = [V3; TERMS]> {
        let mut seed = 5_u64;
        let mut random = move || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        (0..2000).map(move |_| {
            let size = 10.0_f64.powf(1.5 * random());
            let shrink = 0.5 * random().abs();
            let flat = if random() > 0.0 { 1.0 } else { 0.01 };
            let mut scale = size;
            std::array::from_fn(|k| {
                if k == 0 {
                    return V3::zeros();
                }
                let bent = if k == 1 { 1.0 } else { flat };
                let c = V3::new(random(), bent * random(), bent * random()) * (scale / k as f64);
                scale *= shrink;
                c
            })
        })
    }

    #[test]
    fn the_error_of_a_turn_is_the_one_allowed() {
        let mut worst = [0.0_f64; 3];
        for turn in turns() {
            for (allowed, worst) in [1e-6, 1e-9, 1e-12].into_iter().zip(&mut worst) {
                let mut turning = Turning::STILL;
                turning.begin(turn, allowed);
                let quick = turning.at(1.0);
                let chosen = turning.pieces;
                turning.pieces = (chosen * 8).max(64);
                turning.followed = (0, turning.start);
                let fine = turning.at(1.0);
                let apart = (0..4).map(|i| (quick[i] - fine[i]).abs()).fold(0.0, f64::max) * 2.0;
                // Rounding grows with the angle.
                *worst = worst.max((apart - 4e-14).max(0.0) / allowed);
            }
        }
        assert!(worst.iter().all(|share| *share <= 1.0), "error over allowed: {worst:?}");
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
