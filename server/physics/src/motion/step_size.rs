//! How long the next step is: as long as the error asked for allows, and no more often refused than pays.
//!
//! Lengths have `LENGTH_BITS` significant bits, so that they are exact fractions of a second. Whether a step is kept depends
//! on the step alone, never on those before: a run that was saved takes it again.

use crate::number::of_few_bits;
use crate::tolerance::{GROWTH_MAX, SHRINK_MAX, STEP_MARGIN, STEP_MAX, STEP_MIN};

/// Significant bits of a length: sixteen lengths an octave lose 2 % of a step on average.
const LENGTH_BITS: u32 = 5;

/// Length to try after a step of `h` seconds with an error of `error` where `allowed` would do, kept or not, s.
///
/// The error goes with h^8.5 and what is allowed with h, so that the eighth root of their ratio falls a little short of the
/// change that would use up what is allowed.
pub fn next(h: f64, allowed: f64, error: f64) -> f64 {
    let room = allowed / error;
    // What is no number leaves no room.
    let room = if room.is_nan() { 0.0 } else { room };
    let change = (STEP_MARGIN * eighth_root(room)).clamp(SHRINK_MAX, GROWTH_MAX);
    of_few_bits(h * change, LENGTH_BITS).clamp(STEP_MIN, STEP_MAX)
}

/// Three square roots, each rounded correctly: a power from a library may differ between machines.
fn eighth_root(x: f64) -> f64 {
    x.sqrt().sqrt().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tolerance::{STEP_FIRST, allowed_error};

    #[test]
    fn steps_settle_just_below_the_longest_that_is_allowed() {
        for tolerance in [1e-6, 1e-9, 1e-12] {
            for speed in [0.3_f64, 3.0, 30.0] {
                let error = |h: f64| 1e-3 * (h * speed).powf(8.5);
                let mut h = STEP_FIRST;
                for _ in 0..40 {
                    h = next(h, allowed_error(tolerance, h), error(h));
                }
                assert!(
                    error(h) < allowed_error(tolerance, h) || h == STEP_MIN,
                    "{tolerance:e} {speed}: {h}"
                );
                let longer = h / (STEP_MARGIN * STEP_MARGIN);
                assert!(
                    error(longer) > allowed_error(tolerance, longer) || h == STEP_MAX,
                    "{tolerance:e} {speed}: {h}"
                );
            }
        }
    }

    #[test]
    fn lengths_are_few_bits_long_and_within_their_bounds() {
        for exponent in -30..10 {
            let h = next(0.071, 1e-9, 1e-9 * 10_f64.powi(exponent));
            assert!((STEP_MIN..=STEP_MAX).contains(&h));
            let sixteenths = h / 2_f64.powi(h.log2().floor() as i32 - 4);
            assert_eq!(sixteenths, sixteenths.round());
        }
    }

    #[test]
    fn an_error_that_is_no_number_shrinks_a_step_and_no_error_lengthens_it() {
        assert_eq!(next(0.125, 1e-9, f64::NAN), 0.125 * SHRINK_MAX);
        assert_eq!(next(0.125, 1e-9, f64::INFINITY), 0.125 * SHRINK_MAX);
        assert_eq!(next(0.125, 1e-9, 0.0), of_few_bits(0.125 * GROWTH_MAX, LENGTH_BITS));
    }
}
