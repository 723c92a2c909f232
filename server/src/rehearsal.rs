//! A budget instead of a tolerance: a few balls of a scene are run beforehand, and the smallest tolerance is found whose steps
//! fit in.
//!
//! Work is counted, not timed: evaluations of the equations of motion, so that every machine finds the same tolerance.

use crate::scene_file::{LoadedScene, SceneError};
use ballroom_physics::{Accuracy, Controller, Scene, Time};

/// Evaluations that a kept step takes; a refused one takes four fewer.
const EVALUATIONS_PER_STEP: f64 = 16.0;
/// Balls that rehearse at most.
const BALLS: usize = 8;
/// How long they do, simulated s: what a tolerance is about.
const SECONDS: f64 = 10.0;
/// Tolerances that are tried, m, as powers of ten to the quarter: from 1e-13 to 1e-2.
const QUARTER_DECADES: std::ops::RangeInclusive<i32> = -52..=-8;
/// How much more exactly the balls are run once more to see how exactly they were run.
const TIGHTER: f64 = 100.0;
/// The most exact that there is, m.
const TIGHTEST_M: f64 = 1e-13;
/// The least exact, m.
pub const LARGEST_M: f64 = 1e-2;

/// What a rehearsal found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rehearsed {
    /// Evaluations per ball and simulated second that were allowed.
    pub budget: f64,
    /// The smallest tolerance within the budget, or the largest there is.
    pub tolerance_m: f64,
    /// Evaluations that the balls took with it, per ball and simulated second.
    pub evaluations: f64,
    /// Largest distance of a ball after 10 s from the same run a hundred times more exactly.
    pub reached_m: f64,
}

impl std::fmt::Display for Rehearsed {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { budget, tolerance_m, evaluations, reached_m } = self;
        let steps = evaluations / EVALUATIONS_PER_STEP;
        write!(
            out,
            "a budget of {budget} evaluations gives a tolerance of {tolerance_m:e} m: it took {evaluations:.0} per ball and \
             second ({steps:.1} steps) and reached {reached_m:.1e} m after 10 s"
        )
    }
}

/// Finds the tolerance whose work fits in `budget` evaluations per ball and simulated second. Larger tolerances never take more
/// steps worth speaking of, so that halving finds it.
pub fn within(loaded: &LoadedScene, budget: f64) -> Result<Rehearsed, SceneError> {
    // What is refused is refused as a whole: a few balls alone would be named by other numbers.
    loaded.controller()?;
    let (mut least, mut most) = QUARTER_DECADES.into_inner();
    while least < most {
        let middle = (least + most).div_euclid(2);
        if evaluations(&rehearse(loaded, tolerance(middle))?) <= budget {
            most = middle;
        } else {
            least = middle + 1;
        }
    }
    let tolerance_m = tolerance(most);
    let run = rehearse(loaded, tolerance_m)?;
    let exact = rehearse(loaded, (tolerance_m / TIGHTER).max(TIGHTEST_M))?;
    let apart = run.balls().zip(exact.balls()).map(|(a, b)| (a.center - b.center).norm());
    Ok(Rehearsed {
        budget,
        tolerance_m,
        evaluations: evaluations(&run),
        reached_m: apart.fold(0.0, f64::max),
    })
}

/// Ten to a quarter of `quarters`, rounded to two digits: what people would write.
fn tolerance(quarters: i32) -> f64 {
    let digits = [1.0, 1.8, 3.2, 5.6][quarters.rem_euclid(4) as usize];
    format!("{digits}e{}", quarters.div_euclid(4)).parse().expect("digits and an exponent")
}

/// The scene with a few of its balls, evenly spread over its list, ten seconds on.
fn rehearse(loaded: &LoadedScene, tolerance_m: f64) -> Result<Controller, SceneError> {
    let all = &loaded.physics().balls;
    let count = all.len().min(BALLS);
    let balls = (0..count).map(|place| all[place * all.len() / count].clone()).collect();
    let scene = Scene { balls, accuracy: Accuracy::Tolerance(tolerance_m), ..loaded.physics().clone() };
    let mut engine = Controller::new(&scene).map_err(|fault| loaded.refused(&fault))?;
    engine.advance_to(Time::of_seconds(SECONDS));
    Ok(engine)
}

fn evaluations(run: &Controller) -> f64 {
    let balls = run.balls().len().max(1) as f64;
    run.report().steps as f64 * EVALUATIONS_PER_STEP / (balls * SECONDS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file::SceneText;

    #[test]
    fn a_larger_budget_is_used_for_a_smaller_error() {
        let loaded = SceneText::open("bicubic").unwrap().load().unwrap();
        let found: Vec<Rehearsed> =
            [60.0, 120.0, 240.0].map(|budget| within(&loaded, budget).unwrap()).into();
        for (budget, found) in [60.0, 120.0, 240.0].into_iter().zip(&found) {
            assert!(found.evaluations <= budget && found.evaluations > 0.7 * budget, "{budget}: {found:?}");
            assert!(found.reached_m < found.tolerance_m, "{budget}: {found:?}");
        }
        for pair in found.windows(2) {
            assert!(pair[1].reached_m < 0.1 * pair[0].reached_m, "{found:?}");
        }
    }

    #[test]
    fn a_budget_that_nothing_fits_in_gives_the_largest_tolerance() {
        let loaded = SceneText::open("bicubic").unwrap().load().unwrap();
        assert_eq!(within(&loaded, 1.0).unwrap().tolerance_m, 1e-2);
    }

    #[test]
    fn tolerances_are_those_that_scenes_may_ask_for() {
        assert_eq!([-52, -9, -8].map(tolerance), [1e-13, 5.6e-3, 1e-2]);
    }
}
