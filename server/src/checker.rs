//! Scenes that are asked about, checked on a thread of its own: what runs does not notice.

use crate::scene_file::{SceneError, SceneText};
use crate::simulation::Simulation;
use ballroom_physics::surface::certify::certify;
use protocol::check::{Check, Checked, Floor};
use protocol::command::{Refusal, code};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};

/// Scenes that wait to be checked, of all who ask a process; what comes beyond is refused.
pub const MAX_CHECKS: usize = 8;

/// How a finding reaches whoever asked.
type Tell = Box<dyn FnOnce(Result<Check, Refusal>) + Send>;

/// The way to the thread, which ends when all copies of it are gone.
#[derive(Clone)]
pub struct Checker(SyncSender<(String, Tell)>);

impl Checker {
    /// Starts the thread.
    pub fn start() -> std::io::Result<Self> {
        let (questions, waiting) = sync_channel(MAX_CHECKS);
        std::thread::Builder::new().name("check".into()).spawn(move || work(waiting))?;
        Ok(Self(questions))
    }

    /// Has the text of a scene checked, and `tell` called with what was found or why nobody looked.
    pub fn give(&self, toml: String, tell: Tell) {
        if let Err(TrySendError::Full((_, tell)) | TrySendError::Disconnected((_, tell))) =
            self.0.try_send((toml, tell))
        {
            let why = format!("{MAX_CHECKS} scenes wait to be checked already: send fewer");
            tell(Err(Refusal::new(code::TOO_MANY, why)));
        }
    }
}

fn work(questions: Receiver<(String, Tell)>) {
    for (toml, tell) in questions {
        tell(Ok(check(&SceneText::new("toml", toml)).unwrap_or_else(|error| Check::from(&error))));
    }
}

/// What would be run, set up to its last table, and what is proved about its floor.
fn check(text: &SceneText) -> Result<Check, SceneError> {
    let loaded = Arc::new(text.load()?);
    let simulation = Simulation::new(loaded.clone(), 1, 0)?;
    let start = simulation.world().start();
    let certificate = certify(start.patch(), &-loaded.physics().gravity);
    let [flattest, steepest] = certificate.steepest_cosine.map(|cosine| cosine.min(1.0).acos().to_degrees());
    let roster = simulation.roster();
    let scene = Checked {
        name: loaded.scene().name.clone(),
        description: loaded.scene().description.clone(),
        balls: roster.names.len(),
        players: roster.player.iter().filter(|player| **player).count(),
        walls: loaded.physics().walls.len(),
        degree: start.patch().degree(),
        energy_j: start.energy(),
        certificate: Floor {
            steepest_deg: [steepest, flattest],
            curvature_per_m: certificate.curvature,
            reach_m: certificate.reach[1].is_finite().then_some(certificate.reach),
        },
    };
    Ok(Check { ok: true, fault: None, scene: Some(scene) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checked_scene_is_told_with_its_brackets_and_a_bad_one_with_its_line() {
        let scene = check(&SceneText::open("original").unwrap()).unwrap().scene.unwrap();
        assert_eq!((scene.balls, scene.players), (3, 1));
        let Floor { steepest_deg, curvature_per_m, reach_m } = scene.certificate;
        for [low, high] in [steepest_deg, curvature_per_m, reach_m.unwrap()] {
            assert!(0.0 < low && low <= high, "{low} {high}");
        }
        assert!(
            check(&SceneText::open("plane").unwrap()).unwrap().scene.unwrap().certificate.reach_m.is_none()
        );
        let fault = Check::from(&check(&SceneText::new("toml", "version = 1\n")).unwrap_err()).fault.unwrap();
        assert_eq!(fault.line, Some(1));
        assert!(fault.text.starts_with("toml:1:1"), "{fault:?}");
    }
}
