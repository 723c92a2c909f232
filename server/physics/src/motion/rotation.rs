//! Turning a ball, without platform sine and cosine: about an axis that stands still, and along an arc.

use super::step::TERMS;
use crate::tolerance::TURN_PIECES_MAX;
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// The orientation at `theta`, from `start` at 0, where `turn` is the integral of the angular velocity in
/// powers of theta (rad).
///
/// A rate of constant direction is exact. Else Magnus steps of order 6 in pieces of at most `piece_angle` rad
/// (S. Blanes, F. Casas, J. Ros, "Improved high order integrators based on the Magnus expansion", BIT 40,
/// 2000): fast spin costs pieces here, not steps of the motion.
pub fn follow(start: [f64; 4], turn: &[V3; TERMS], theta: f64, piece_angle: f64) -> [f64; 4] {
    if theta == 0.0 || turn.iter().all(|c| *c == V3::zeros()) {
        return start;
    }
    if turn[2..].iter().all(|c| *c == V3::zeros()) {
        return unit(compose(of_rotation_vector(turn[1] * theta), start));
    }
    let mut size = 0.0;
    let mut power = 1.0;
    for c in &turn[1..] {
        power *= theta.abs();
        size += c.norm() * power;
    }
    let pieces = (size / piece_angle).ceil().clamp(1.0, TURN_PIECES_MAX);
    let h = theta / pieces;
    let mut q = start;
    for piece in 0..pieces as u32 {
        q = compose(of_rotation_vector(magnus(turn, (f64::from(piece) + 0.5) * h, h)), q);
    }
    unit(q)
}

/// Rotation vector of the piece of length `h` around `middle`.
fn magnus(turn: &[V3; TERMS], middle: f64, h: f64) -> V3 {
    // The rate and its first four derivatives over factorials at the middle: a Taylor shift.
    let mut rate: [V3; TERMS - 1] = std::array::from_fn(|k| turn[k + 1] * (k + 1) as f64);
    for k in 0..5 {
        for i in (k..TERMS - 2).rev() {
            let higher = rate[i + 1];
            rate[i] += higher * middle;
        }
    }
    let (h2, h3) = (h * h, h * h * h);
    let [a0, a1, a2, a3, a4, ..] = rate;
    // Moments about the middle that reproduce the rate's integrals to order 6.
    let first = a0 * h - a4 * (h3 * h2 * (3.0 / 560.0));
    let second = a1 * h2 + a3 * (h2 * h2 * (3.0 / 20.0));
    let third = a2 * h3 + a4 * (h3 * h2 * (3.0 / 14.0));
    let c1 = first.cross(&second);
    let c2 = first.cross(&(third * 2.0 + c1)) * (-1.0 / 60.0);
    first + third / 12.0 + (first * -20.0 - third + c1).cross(&(second + c2)) / 240.0
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
