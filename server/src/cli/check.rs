//! `check`: whether a scene can be run, and what it holds.

use super::ball_count::BallCount;
use super::dial::Dial;
use ballroom_physics::surface::certify::{Certificate, certify};
use protocol::scene::{Accuracy, Floor, Scene};
use server::LoadedScene;
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
  ballroom check original --error 1e-6
  ballroom check my_scene.toml")]
pub struct Check {
    /// Name of a built-in scene, or a file ending in .toml
    scene: String,
    #[command(flatten)]
    count: BallCount,
    #[command(flatten)]
    dial: Dial,
}

impl Check {
    pub fn run(self) -> anyhow::Result<()> {
        let loaded = Arc::new(self.dial.of(self.count.open(&self.scene)?).load()?);
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
        writeln!(out, "accuracy   {}", accuracy(&loaded))?;
        writeln!(out, "energy     {} J at the start", controller.energy())?;
        let mut radii = roster.radius_m.clone();
        radii.sort_unstable_by(|a, b| b.total_cmp(a));
        radii.dedup();
        // What loading proves is enough for the scene's balls; the brackets themselves take longer.
        let certificate = certify(controller.patch(), &-physics.gravity);
        write!(out, "{}", certified(&certificate, &radii))?;
        writeln!(out, "ok")?;
        Ok(())
    }
}

/// What is proved about the floor, and the room it leaves for balls of these radii, largest first.
fn certified(certificate: &Certificate, radii: &[f64]) -> String {
    let [flattest, steepest] = certificate.steepest_cosine.map(|cosine| cosine.min(1.0).acos().to_degrees());
    let [lo, hi] = certificate.curvature;
    let [least, most] = certificate.reach;
    let [contact, touch] = certificate.reach_at;
    let mut lines = vec![
        format!(
            "regular    its normal points up everywhere; certified in {} boxes and {} pairs of boxes",
            certificate.boxes, certificate.pairs
        ),
        format!("steepest   {steepest:.3} to {flattest:.3} degrees, at {}", certificate.steepest_at),
        format!("curvature  largest concave {lo:.6} to {hi:.6} 1/m, at {}", certificate.curvature_at),
    ];
    lines.push(if least == f64::INFINITY {
        "reach      unbounded: the floor is nowhere concave".to_owned()
    } else if contact == touch {
        format!("reach      {least:.6} to {most:.6} m: balls below touch the floor once; curvature decides")
    } else {
        format!(
            "reach      {least:.6} to {most:.6} m: balls below touch the floor once; a ball of that radius"
        )
    });
    if contact != touch && least < f64::INFINITY {
        lines.push(format!("           that lies at {contact}"));
        lines.push(format!("           touches at {touch} too"));
    }
    // Of many radii the largest speaks for all.
    let listed = if radii.len() > LISTED_RADII { 1 } else { radii.len() };
    for radius in &radii[..listed] {
        let [lo, hi] = [lo * radius, hi * radius];
        let share = 100.0 * radius / least;
        lines.push(format!(
            "radius     {radius} m: times curvature {lo:.6} to {hi:.6}, at most {share:.2} % of the reach"
        ));
    }
    if listed < radii.len() {
        lines.push(format!("           and less for {} smaller radii", radii.len() - listed));
    }
    lines.join("\n") + "\n"
}

fn accuracy(loaded: &LoadedScene) -> String {
    match loaded.scene().accuracy {
        Accuracy::Tolerance { tolerance_m } => {
            let found = loaded.rehearsed().map_or(String::new(), |found| format!(": {found}"));
            format!("{tolerance_m:e} m over 10 s of smooth motion{found}")
        }
        // Scenes are loaded with the tolerance that was found for them.
        Accuracy::Error { error_m } => format!("what keeps an error of {error_m:e} m"),
        Accuracy::Budget { budget_evaluations } => format!("what {budget_evaluations} evaluations pay for"),
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
