//! A scene is run beforehand, to find the tolerance that gives what is asked for.
//!
//! | asked for | file |
//! |---|---|
//! | work that a ball may take | `budget` |
//! | an error that the whole scene keeps | `error` |
//!
//! Nothing is timed, so that every machine finds the same tolerance and computes the same run.

mod budget;
mod error;

use crate::scene_file::{LoadedScene, SceneError};
use ballroom_physics::Controller;
use protocol::scene::Accuracy;

/// Evaluations that a kept step takes; a refused one takes four fewer.
const EVALUATIONS_PER_STEP: f64 = 16.0;
/// How long a scene is run, simulated s: what a tolerance is about.
const SECONDS: f64 = 10.0;
/// Tolerances are tried in quarters of a decade, the largest 1e-2 m.
const MOST: i32 = -8;
/// The least exact tolerance that there is, m.
pub const LARGEST_M: f64 = 1e-2;

/// What a scene asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Asked {
    /// Evaluations per ball and simulated second that were allowed.
    Evaluations(f64),
    /// The largest position error, m.
    Error(f64),
}

/// What a rehearsal found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rehearsed {
    /// What was asked for.
    pub asked: Asked,
    /// The smallest tolerance within a budget or the largest that keeps an error, in quarters of a decade; at most 1e-2 m.
    pub tolerance_m: f64,
    /// Evaluations that the balls took with it, per ball and simulated second.
    pub evaluations: f64,
    /// Largest distance of a ball from the same run more exactly: of a few alone after 10 s for a budget, of all at any tick
    /// of 10 s for an error.
    pub reached_m: f64,
}

impl std::fmt::Display for Rehearsed {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { asked, tolerance_m, evaluations, reached_m } = self;
        let steps = evaluations / EVALUATIONS_PER_STEP;
        let when = match asked {
            Asked::Evaluations(budget) => {
                write!(out, "a budget of {budget} evaluations")?;
                "after 10 s"
            }
            Asked::Error(error_m) => {
                write!(out, "an error of {error_m:e} m")?;
                "within 10 s"
            }
        };
        write!(
            out,
            " gives a tolerance of {tolerance_m:e} m: it took {evaluations:.0} per ball and second ({steps:.1} steps) and \
             reached {reached_m:.1e} m {when}"
        )
    }
}

/// The tolerance for what a scene asks, if it does not name one.
pub fn rehearse(loaded: &LoadedScene) -> Result<Option<Rehearsed>, SceneError> {
    match loaded.scene().accuracy {
        Accuracy::Budget { budget_evaluations } => budget::within(loaded, budget_evaluations).map(Some),
        Accuracy::Error { error_m } => error::kept(loaded, error_m).map(Some),
        Accuracy::Tolerance { .. } | Accuracy::Fixed { .. } => Ok(None),
    }
}

/// Ten to a quarter of `quarters`, rounded to two digits: what people would write.
fn tolerance(quarters: i32) -> f64 {
    let digits = [1.0, 1.8, 3.2, 5.6][quarters.rem_euclid(4) as usize];
    format!("{digits}e{}", quarters.div_euclid(4)).parse().expect("digits and an exponent")
}

fn evaluations(run: &Controller) -> f64 {
    let balls = run.balls().len().max(1) as f64;
    run.report().steps as f64 * EVALUATIONS_PER_STEP / (balls * SECONDS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_are_those_that_scenes_may_ask_for() {
        assert_eq!([-52, -9, MOST].map(tolerance), [1e-13, 5.6e-3, LARGEST_M]);
    }
}
