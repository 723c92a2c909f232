//! The first time a polynomial turns negative, by its Bernstein coefficients: no root is ever missed.
//!
//! A polynomial lies in the convex hull of its Bernstein coefficients, so that coefficients without a sign
//! change mean no root, one change means one root, and more mean: halve and look again.

use crate::tolerance::{ROOT_DEPTH_MAX, ROOT_INTERVALS_MAX, ROOT_STEPS_MAX};

/// Where in [0, 1] the polynomial with Bernstein coefficients `b` first turns negative, as a bracket
/// (not negative at its left, negative at its right). `b[0] >= 0` is the caller's promise; a zero that is
/// only touched is no crossing.
pub fn first_descent<const N: usize>(b: &[f64; N]) -> Option<[f64; 2]> {
    if b.iter().all(|x| *x >= 0.0) || !b.iter().all(|x| x.is_finite()) {
        return None;
    }
    // Depth-first, left half first: at most one right half waits at each depth.
    let mut waiting = [([0.0; N], 0.0_f64, 0.0_f64); ROOT_DEPTH_MAX as usize + 1];
    let mut count = 1;
    waiting[0] = (*b, 0.0, 1.0);
    let mut looked_at = 0;
    while count > 0 {
        count -= 1;
        let (c, left, width) = waiting[count];
        looked_at += 1;
        if looked_at > ROOT_INTERVALS_MAX {
            // Rounding noise around zero: a contact without a crossing. If they approach, the next window sees it.
            return None;
        }
        if c.iter().all(|x| *x >= 0.0) {
            continue;
        }
        if c[0] < 0.0 {
            return Some([left, left]);
        }
        let depth = ROOT_DEPTH_MAX as usize;
        if sign_changes(&c) == 1 && c[N - 1] < 0.0 {
            return Some([left, left + width]);
        }
        if count + 2 > depth || width < f64::EPSILON {
            // Too small to tell from a touch.
            if c[N - 1] < 0.0 {
                return Some([left, left + width]);
            }
            continue;
        }
        let (low, high) = halve(&c);
        waiting[count] = (high, left + 0.5 * width, 0.5 * width);
        waiting[count + 1] = (low, left, 0.5 * width);
        count += 2;
    }
    None
}

/// The root in `bracket`, where `f` gives value and derivative and turns from not negative to negative:
/// Newton, kept in the bracket by bisection. Returns the last point known not to be negative.
pub fn refine(mut bracket: [f64; 2], f: impl Fn(f64) -> (f64, f64)) -> f64 {
    let [left, right] = &mut bracket;
    let mut x = 0.5 * (*left + *right);
    for _ in 0..ROOT_STEPS_MAX {
        if *right - *left <= 2.0 * f64::EPSILON {
            break;
        }
        let (value, slope) = f(x);
        if value >= 0.0 {
            *left = x;
        } else {
            *right = x;
        }
        let newton = x - value / slope;
        let next = if newton > *left && newton < *right { newton } else { 0.5 * (*left + *right) };
        if (next - x).abs() <= f64::EPSILON {
            return next;
        }
        x = next;
    }
    x
}

fn sign_changes<const N: usize>(c: &[f64; N]) -> u32 {
    let mut changes = 0;
    let mut last = true;
    for x in c {
        // A zero takes its neighbour's sign.
        if *x != 0.0 && (*x > 0.0) != last {
            changes += 1;
            last = !last;
        }
    }
    changes
}

/// De Casteljau at 1/2.
fn halve<const N: usize>(c: &[f64; N]) -> ([f64; N], [f64; N]) {
    let mut row = *c;
    let (mut low, mut high) = ([0.0; N], [0.0; N]);
    for k in 0..N {
        low[k] = row[0];
        high[N - 1 - k] = row[N - 1 - k];
        for i in 0..N - 1 - k {
            row[i] = 0.5 * (row[i] + row[i + 1]);
        }
    }
    (low, high)
}

/// Bernstein coefficients of f/x from those of f with f(0) = 0: what a contact just left is searched with.
/// The degree falls by one; the last coefficient is repeated by raising the degree again.
pub fn divide_by_x<const N: usize>(b: &[f64; N]) -> [f64; N] {
    let n = (N - 1) as f64;
    let mut low = [0.0; N];
    for i in 0..N - 1 {
        low[i] = b[i + 1] * n / (i + 1) as f64;
    }
    // Raise the degree from N - 2 to N - 1.
    let mut out = [0.0; N];
    for (i, o) in out.iter_mut().enumerate() {
        let share = i as f64 / n;
        let before = if i > 0 { low[i - 1] } else { 0.0 };
        let here = if i < N - 1 { low[i] } else { 0.0 };
        *o = share * before + (1.0 - share) * here;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bernstein coefficients of degree 4 of the polynomial with powers `a`.
    fn bernstein(a: [f64; 5]) -> [f64; 5] {
        let binomial = [
            [1.0, 0.0, 0.0, 0.0, 0.0],
            [1.0, 1.0, 0.0, 0.0, 0.0],
            [1.0, 2.0, 1.0, 0.0, 0.0],
            [1.0, 3.0, 3.0, 1.0, 0.0],
            [1.0, 4.0, 6.0, 4.0, 1.0],
        ];
        std::array::from_fn(|i| (0..=i).map(|k| binomial[i][k] / binomial[4][k] * a[k]).sum())
    }

    #[test]
    fn the_first_of_two_close_roots_is_found() {
        for gap in [0.3, 1e-3, 1e-6] {
            // (x - 0.4)(x - 0.4 - gap), positive at 0, negative in between.
            let (a, b) = (0.4, 0.4 + gap);
            let f = |x: f64| ((x - a) * (x - b), 2.0 * x - a - b);
            let bracket = first_descent(&bernstein([a * b, -a - b, 1.0, 0.0, 0.0])).expect("a descent");
            assert!((refine(bracket, f) - a).abs() < 1e-9 * (1.0 + 1e-7 / gap), "gap {gap}");
        }
    }

    #[test]
    fn a_polynomial_that_stays_above_zero_has_no_descent() {
        assert_eq!(first_descent(&bernstein([0.16 + 1e-9, -0.8, 1.0, 0.0, 0.0])), None);
        assert_eq!(first_descent(&bernstein([1.0, 0.0, 0.0, 0.0, 0.0])), None);
    }

    #[test]
    fn a_contact_just_left_is_not_found_again() {
        // x (0.5 - x): zero at the start, rising, negative after 0.5.
        let f = bernstein([0.0, 0.5, -1.0, 0.0, 0.0]);
        let bracket = first_descent(&divide_by_x(&f)).expect("a descent");
        let root = refine(bracket, |x| (0.5 - x, -1.0));
        assert!((root - 0.5).abs() < 1e-15);
    }
}
