//! `check`: whether a scene can be run, and what it holds.

use super::ball_count::BallCount;
use protocol::scene::{Accuracy, Floor, Scene};
use server::simulation::Simulation;
use std::io::Write;
use std::sync::Arc;

/// How many radii are listed one by one.
const LISTED_RADII: usize = 8;

/// Check a scene and print what it holds
#[derive(clap::Args)]
#[command(after_help = "\
What is wrong is named by file, line, column and field, and the exit code is 5.

Examples:
  ballroom check thousand
  ballroom check gas --balls 100000
  ballroom check my_scene.toml")]
pub struct Check {
    /// Name of a built-in scene, or a file ending in .toml
    scene: String,
    #[command(flatten)]
    count: BallCount,
}

impl Check {
    pub fn run(self) -> anyhow::Result<()> {
        let loaded = Arc::new(self.count.open(&self.scene)?.load()?);
        let controller = loaded.controller()?;
        // Sets up what `serve` would, to its last table.
        let roster = Simulation::new(loaded.clone(), 60, 0)?.roster().clone();
        let scene = loaded.scene();
        let mut out = std::io::stdout().lock();
        writeln!(out, "scene      {}: {}", scene.name, scene.description)?;
        writeln!(out, "floor      {}", floor(scene, controller.patch().degree()))?;
        writeln!(out, "walls      {}", loaded.physics().walls.len())?;
        let players = roster.player.iter().filter(|player| **player).count();
        writeln!(out, "balls      {}, {players} of them for players", roster.names.len())?;
        let physics = loaded.physics();
        let motion = format!("{:?}", physics.motion).to_lowercase();
        writeln!(out, "motion     {motion}, restitution {}", physics.restitution)?;
        writeln!(out, "accuracy   {}", accuracy(scene.accuracy))?;
        writeln!(out, "energy     {} J at the start", controller.energy())?;
        let [lo, hi] = controller.curvature_bracket();
        writeln!(out, "curvature  largest concave {lo:.6} to {hi:.6} 1/m, certified over the whole floor")?;
        let mut radii = roster.radius_m.clone();
        radii.sort_unstable_by(|a, b| b.total_cmp(a));
        radii.dedup();
        // Of many radii the largest speaks for all.
        let listed = if radii.len() > LISTED_RADII { 1 } else { radii.len() };
        for radius in &radii[..listed] {
            let [lo, hi] = [lo * radius, hi * radius];
            writeln!(out, "           times radius {radius} m: {lo:.6} to {hi:.6}, must stay below 1")?;
        }
        if listed < radii.len() {
            writeln!(out, "           and less for {} smaller radii", radii.len() - listed)?;
        }
        writeln!(out, "ok")?;
        Ok(())
    }
}

fn accuracy(accuracy: Accuracy) -> String {
    match accuracy {
        Accuracy::Tolerance { tolerance_m } => format!("{tolerance_m:e} m over 10 s of smooth motion"),
        Accuracy::Fixed { integrator, step_s } => format!("{integrator:?} with steps of {step_s} s"),
    }
}

fn floor(scene: &Scene, [p, q]: [usize; 2]) -> String {
    let kind = match scene.floor {
        Floor::Grid { .. } => "heights over a grid",
        Floor::Net { .. } => "a net of control points",
        Floor::Polynomial { .. } => "a polynomial",
    };
    format!("{kind}, degree {p} x {q}")
}
