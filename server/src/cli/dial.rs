//! A scene with another accuracy than it says.

use server::rehearsal::{EVALUATIONS_PER_STEP, within};
use server::{SceneError, SceneText};

/// How exactly a scene shall be run.
#[derive(clap::Args)]
pub struct Dial {
    /// Position error wanted over 10 s of smooth motion, 1e-13 to 1e-2 m, in place of the scene's accuracy
    #[arg(long, value_name = "METRES", value_parser = metres)]
    tolerance: Option<f64>,
    /// Work a ball and simulated second may take, in evaluations of the equations of motion: a few balls are run beforehand,
    /// and the smallest tolerance is taken that fits in; what it reached goes to the log
    #[arg(long, value_name = "EVALUATIONS", conflicts_with = "tolerance", value_parser = evaluations)]
    budget: Option<f64>,
}

impl Dial {
    /// The scene with what was asked for.
    pub fn of(&self, scene: SceneText) -> Result<SceneText, SceneError> {
        let Some(budget) = self.budget else { return Ok(scene.with_tolerance(self.tolerance)) };
        let found = within(&scene.load()?, budget)?;
        tracing::info!(
            "a budget of {budget} evaluations gives a tolerance of {:e} m: it took {:.0} per ball and second ({:.1} steps) and \
             reached {:.1e} m after 10 s",
            found.tolerance_m,
            found.evaluations,
            found.evaluations / EVALUATIONS_PER_STEP,
            found.reached_m
        );
        Ok(scene.with_tolerance(Some(found.tolerance_m)))
    }
}

fn metres(text: &str) -> Result<f64, String> {
    within_range(text, 1e-13, 1e-2, "1e-13 to 1e-2 metres")
}

fn evaluations(text: &str) -> Result<f64, String> {
    within_range(text, 1.0, 1e9, "1 to 1e9 evaluations per ball and simulated second")
}

fn within_range(text: &str, least: f64, most: f64, what: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|fault| format!("{fault}"))?;
    if (least..=most).contains(&number) { Ok(number) } else { Err(format!("use {what}")) }
}
