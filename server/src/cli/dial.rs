//! A scene with another accuracy than it says.

use protocol::scene::Accuracy;
use server::SceneText;

/// How exactly a scene shall be run.
#[derive(clap::Args)]
pub struct Dial {
    /// Position error wanted over 10 s of smooth motion, 1e-13 to 1e-2 m, in place of the scene's accuracy
    #[arg(long, value_name = "METRES", value_parser = metres)]
    tolerance: Option<f64>,
    /// Position error wanted at every tick of 10 s of the whole scene, walls, hits and hills included, 1e-11 to 1e-2 m: it is
    /// run beforehand to find the largest tolerance that keeps it
    #[arg(long, value_name = "METRES", conflicts_with = "tolerance", value_parser = error_metres)]
    error: Option<f64>,
    /// Work a ball and simulated second may take, in evaluations of the equations of motion: a few balls are run beforehand,
    /// and the smallest tolerance is taken that fits in; what it reached goes to the log
    #[arg(long, value_name = "EVALUATIONS", conflicts_with_all = ["tolerance", "error"], value_parser = evaluations)]
    budget: Option<f64>,
}

impl Dial {
    /// The scene with what was asked for.
    pub fn of(&self, scene: SceneText) -> SceneText {
        let tolerance = self.tolerance.map(|tolerance_m| Accuracy::Tolerance { tolerance_m });
        let error = self.error.map(|error_m| Accuracy::Error { error_m });
        let budget = self.budget.map(|budget_evaluations| Accuracy::Budget { budget_evaluations });
        scene.with_accuracy(tolerance.or(error).or(budget))
    }
}

fn metres(text: &str) -> Result<f64, String> {
    within_range(text, 1e-13, 1e-2, "1e-13 to 1e-2 metres")
}

fn error_metres(text: &str) -> Result<f64, String> {
    within_range(text, 1e-11, 1e-2, "1e-11 to 1e-2 metres")
}

fn evaluations(text: &str) -> Result<f64, String> {
    within_range(text, 1.0, 1e9, "1 to 1e9 evaluations per ball and simulated second")
}

fn within_range(text: &str, least: f64, most: f64, what: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|fault| format!("{fault}"))?;
    if (least..=most).contains(&number) { Ok(number) } else { Err(format!("use {what}")) }
}
