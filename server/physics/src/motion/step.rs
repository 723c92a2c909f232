//! What one integration step leaves behind, whatever the scheme.

use crate::number::{Number, Triple};

/// Coefficients of a polynomial of degree 7 in theta = (t - start)/h.
pub const TERMS: usize = 8;

/// A step from 0 to h with its dense output, of one ball or of several side by side.
#[derive(Clone, Copy, Debug)]
pub struct Step<T, const D: usize> {
    /// State at the end.
    pub end: [T; D],
    /// The state within the step, `dense[power][component]`.
    pub dense: [[T; D]; TERMS],
    /// The centre within the step, `center[power]`; exact at both ends.
    pub center: [Triple<T>; TERMS],
    /// Angle turned within the step (the integral of the angular velocity, rad), `turn[power]`; zero when sliding.
    pub turn: [Triple<T>; TERMS],
    /// Floor reaction per mass at `REACTION_AT`, m/s^2.
    pub reaction: [T; 3],
}

/// Where within the step the reaction is taken.
pub const REACTION_AT: [f64; 3] = [0.0, 7.0 / 9.0, 1.0];

/// y + h sum of `weight * slope` over the stages that are used.
#[inline(always)]
pub fn combine<T: Number, const D: usize>(
    y: &[T; D],
    h: T,
    weights: &[f64],
    slopes: &[[T; D]],
    used: &[usize],
) -> [T; D] {
    let sum = weigh(weights, slopes, used);
    let mut out = *y;
    for i in 0..D {
        out[i] = y[i] + h * sum[i];
    }
    out
}

/// Sum of `weight * slope` over the stages that are used, of which there is at least one.
#[inline(always)]
pub fn weigh<T: Number, const D: usize>(weights: &[f64], slopes: &[[T; D]], used: &[usize]) -> [T; D] {
    let mut sum = slopes[used[0]];
    for i in 0..D {
        sum[i] = sum[i] * weights[used[0]];
    }
    for stage in &used[1..] {
        for i in 0..D {
            sum[i] = sum[i] + slopes[*stage][i] * weights[*stage];
        }
    }
    sum
}

/// The polynomial of degree 5 that has the given position, velocity and acceleration at both ends, in powers
/// of theta; its error is of order h^6.
pub fn quintic_hermite(
    h: f64,
    position: [Triple<f64>; 2],
    velocity: [Triple<f64>; 2],
    acceleration: [Triple<f64>; 2],
) -> [Triple<f64>; TERMS] {
    let (v0, v1) = (velocity[0] * h, velocity[1] * h);
    let (a0, a1) = (acceleration[0] * (h * h), acceleration[1] * (h * h));
    let rise = position[1] - position[0];
    let mut c = [Triple([0.0; 3]); TERMS];
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
