//! Turning a ball about an axis that stands still, without platform sine and cosine.

use nalgebra::Vector3;

/// Quaternion (x, y, z, w) of the rotation by |`angle`| about `angle`.
///
/// The half angle is halved until below 1/8, where Taylor series are exact to rounding, and the quaternion is
/// squared as often: the error grows with the angle, about 1e-16 per radian.
pub fn of_rotation_vector(angle: Vector3<f64>) -> [f64; 4] {
    let mut half = angle * 0.5;
    let mut doublings = 0;
    while half.norm_squared() > 1.0 / 64.0 && doublings < 60 {
        half *= 0.5;
        doublings += 1;
    }
    let x = half.norm_squared();
    // sin(s)/s and 1 - cos(s) for s^2 = x <= 1/64; the first terms left out are below 1e-17.
    let sinc = 1.0 - x / 6.0 * (1.0 - x / 20.0 * (1.0 - x / 42.0 * (1.0 - x / 72.0 * (1.0 - x / 110.0))));
    let versine = x / 2.0 * (1.0 - x / 12.0 * (1.0 - x / 30.0 * (1.0 - x / 56.0 * (1.0 - x / 90.0))));
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
