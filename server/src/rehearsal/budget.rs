//! A budget instead of a tolerance: a few balls of a scene are run beforehand, and the smallest tolerance is found whose steps
//! fit in.
//!
//! Work is counted, not timed: evaluations of the equations of motion, so that every machine finds the same tolerance.

use super::{Asked, MOST, Rehearsed, SECONDS, evaluations, tolerance};
use crate::scene_file::{LoadedScene, SceneError};
use ballroom_physics::{Accuracy, Controller, Scene, Time};

/// Balls that rehearse at most.
const BALLS: usize = 8;
/// The smallest tolerance that is tried: 1e-13 m.
const LEAST: i32 = -52;
/// How much more exactly the balls are run once more to see how exactly they were run.
const TIGHTER: f64 = 100.0;

/// Finds the tolerance whose work fits in `budget` evaluations per ball and simulated second. Larger tolerances never take more
/// steps worth speaking of, so that halving finds it.
pub fn within(loaded: &LoadedScene, budget: f64) -> Result<Rehearsed, SceneError> {
    // What is refused is refused as a whole: a few balls alone would be named by other numbers.
    loaded.controller()?;
    let (mut least, mut most) = (LEAST, MOST);
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
    let exact = rehearse(loaded, (tolerance_m / TIGHTER).max(tolerance(LEAST)))?;
    let apart = run.balls().zip(exact.balls()).map(|(a, b)| (a.center - b.center).norm());
    Ok(Rehearsed {
        asked: Asked::Evaluations(budget),
        tolerance_m,
        evaluations: evaluations(&run),
        reached_m: apart.fold(0.0, f64::max),
    })
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
}
