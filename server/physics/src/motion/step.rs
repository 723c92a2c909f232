//! What one integration step leaves behind, whatever the scheme.

use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// Coefficients of a polynomial of degree 7 in theta = (t - start)/h.
pub const TERMS: usize = 8;

/// A step from 0 to h with its dense output.
#[derive(Clone, Copy, Debug)]
pub struct Step<const D: usize> {
    /// State at the end.
    pub end: [f64; D],
    /// Estimated error of position, m; 0 for a scheme of fixed step.
    pub error: f64,
    /// The state within the step, `dense[power][component]`.
    pub dense: [[f64; D]; TERMS],
    /// The centre within the step, `center[power]`; exact at both ends.
    pub center: [V3; TERMS],
    /// Angle turned within the step (the integral of the angular velocity, rad), `turn[power]`; zero when sliding.
    pub turn: [V3; TERMS],
    /// Floor reaction per mass at `REACTION_AT`, m/s^2.
    pub reaction: [f64; 3],
}

/// Where within the step the reaction is taken.
pub const REACTION_AT: [f64; 3] = [0.0, 7.0 / 9.0, 1.0];

/// y + h sum of `weight * slope`.
#[inline]
pub fn combine<const D: usize, const M: usize>(
    y: &[f64; D],
    h: f64,
    terms: [(f64, &[f64; D]); M],
) -> [f64; D] {
    let mut sum = [0.0; D];
    for (weight, slope) in terms {
        for i in 0..D {
            sum[i] += weight * slope[i];
        }
    }
    let mut out = *y;
    for i in 0..D {
        out[i] += h * sum[i];
    }
    out
}

/// The polynomial of degree 5 that has the given position, velocity and acceleration at both ends, in powers
/// of theta; its error is of order h^6.
pub fn quintic_hermite(h: f64, position: [V3; 2], velocity: [V3; 2], acceleration: [V3; 2]) -> [V3; TERMS] {
    let (v0, v1) = (velocity[0] * h, velocity[1] * h);
    let (a0, a1) = (acceleration[0] * (h * h), acceleration[1] * (h * h));
    let rise = position[1] - position[0];
    let mut c = [V3::zeros(); TERMS];
    c[0] = position[0];
    c[1] = v0;
    c[2] = a0 * 0.5;
    c[3] = rise * 10.0 - v0 * 6.0 - v1 * 4.0 - a0 * 1.5 + a1 * 0.5;
    c[4] = rise * -15.0 + v0 * 8.0 + v1 * 7.0 + a0 * 1.5 - a1;
    c[5] = rise * 6.0 - (v0 + v1) * 3.0 - a0 * 0.5 + a1 * 0.5;
    c
}

/// The cubic through states and slopes at both ends, in powers of theta; its error is of order h^4.
pub fn cubic_hermite<const D: usize>(h: f64, y: [&[f64; D]; 2], slope: [&[f64; D]; 2]) -> [[f64; D]; TERMS] {
    let mut c = [[0.0; D]; TERMS];
    for i in 0..D {
        let rise = y[1][i] - y[0][i];
        let (s0, s1) = (h * slope[0][i], h * slope[1][i]);
        c[0][i] = y[0][i];
        c[1][i] = s0;
        c[2][i] = 3.0 * rise - 2.0 * s0 - s1;
        c[3][i] = s0 + s1 - 2.0 * rise;
    }
    c
}
