//! What a lesson points at: where balls touch, how they move, how hard the floor presses, what they are called.
//!
//! Drawn for [`detailed`](crate::chosen::detailed) balls; which views show it says the layout.

use crate::mechanics::Mechanics;
use crate::palette;
use crate::recording::Recording;
use crate::scene_view::SceneView;
use crate::surface::Jet;
use nalgebra::Vector3;
use protocol::snapshot::{Roster, Snapshot};
use rerun::{Arrows3D, Clear, Points3D, Radius, RecordingStreamResult};

/// Parent of all that is drawn here.
pub const OVERLAYS: &str = "world/overlays";
/// Entity of the points where balls touch the floor.
pub const CONTACTS: &str = "world/overlays/contacts";
/// Entity of the velocity arrows.
pub const VELOCITIES: &str = "world/overlays/velocities";
/// Entity of the arrows of the floor's reaction.
pub const REACTIONS: &str = "world/overlays/reactions";
/// Entity of the names of balls that no player steers.
pub const NAMES: &str = "world/overlays/names";

/// A velocity arrow ends where the centre would be after this time, s.
const AHEAD_S: f64 = 0.25;
/// Length of the reaction that equals the weight, in radii: it is seen above the ball.
const WEIGHT_RADII: f64 = 3.0;
/// Longest reaction that is drawn in full, in weights.
const MAX_WEIGHTS: f64 = 8.0;

/// Most names written over balls: in a rack or a crowd they would hide what they name.
const MAX_NAMES: usize = 8;

/// Overlays of the chosen balls.
pub struct OverlayView {
    balls: Vec<usize>,
    unsteered: Vec<(usize, String)>,
    mechanics: Mechanics,
    gravity: f64,
}

impl OverlayView {
    /// Overlays for these balls.
    pub fn of(mechanics: Mechanics, gravity_m_per_s2: [f64; 3], roster: &Roster, balls: Vec<usize>) -> Self {
        let named = |ball: &usize| (*ball, roster.names[*ball].clone());
        let mut unsteered: Vec<_> = balls.iter().filter(|ball| !roster.player[**ball]).map(named).collect();
        if unsteered.len() > MAX_NAMES {
            unsteered.clear();
        }
        Self { balls, unsteered, mechanics, gravity: Vector3::from(gravity_m_per_s2).norm() }
    }

    /// Logs what does not change with the state, and takes away what an earlier roster had.
    pub fn log_looks(&self, rec: &Recording) -> RecordingStreamResult<()> {
        rec.log(OVERLAYS, &Clear::recursive())?;
        let contacts = Points3D::update_fields()
            .with_radii([Radius::new_ui_points(4.0)])
            .with_colors([palette::color(palette::CONTACT)]);
        rec.log_static(CONTACTS, &contacts)?;
        for (path, color) in [(VELOCITIES, palette::VELOCITY), (REACTIONS, palette::REACTION)] {
            let arrows = Arrows3D::update_fields()
                .with_radii([Radius::new_ui_points(1.5)])
                .with_colors([palette::color(color)]);
            rec.log_static(path, &arrows)?;
        }
        let names = Points3D::update_fields()
            .with_labels(self.unsteered.iter().map(|(_, name)| name.as_str()))
            .with_show_labels(true)
            .with_radii([Radius::new_ui_points(0.0)])
            .with_colors([palette::color(palette::NAME)]);
        rec.log_static(NAMES, &names)
    }

    /// Logs the overlays of a state.
    pub fn log_state(
        &self,
        rec: &Recording,
        floor: &SceneView,
        roster: &Roster,
        state: &Snapshot,
    ) -> RecordingStreamResult<()> {
        if self.balls.is_empty() {
            return Ok(());
        }
        let balls = || self.balls.iter().copied();
        let jets: Vec<Jet> =
            balls().map(|ball| floor.surface().jet(state.uv[ball][0], state.uv[ball][1])).collect();
        let touching: Vec<[f32; 3]> =
            jets.iter().map(|jet| crate::single(jet.point + jet.normal * floor.lift_m())).collect();
        rec.log(CONTACTS, &Points3D::update_fields().with_positions(touching.iter().copied()))?;

        let along = balls().map(|ball| crate::single(Vector3::from(state.velocity_m_per_s[ball]) * AHEAD_S));
        let centers = balls().map(|ball| crate::single(state.center_m[ball].into()));
        rec.log(VELOCITIES, &Arrows3D::update_fields().with_vectors(along).with_origins(centers))?;

        let reactions =
            balls().zip(&jets).map(|(ball, jet)| crate::single(self.reaction(jet, roster, state, ball)));
        rec.log(REACTIONS, &Arrows3D::update_fields().with_vectors(reactions).with_origins(touching))?;
        self.log_names(rec, roster, state)
    }

    /// The reaction as an arrow, m.
    fn reaction(&self, jet: &Jet, roster: &Roster, state: &Snapshot, ball: usize) -> Vector3<f64> {
        let force_n = self.mechanics.reaction_n(jet, roster, state, ball);
        let weights = (force_n / (roster.mass_kg[ball] * self.gravity)).clamp(-MAX_WEIGHTS, MAX_WEIGHTS);
        jet.normal * (WEIGHT_RADII * roster.radius_m[ball] * weights)
    }

    fn log_names(&self, rec: &Recording, roster: &Roster, state: &Snapshot) -> RecordingStreamResult<()> {
        if self.unsteered.is_empty() {
            return Ok(());
        }
        let above = |(ball, _): &(usize, String)| {
            let center = Vector3::from(state.center_m[*ball]);
            crate::single(center + Vector3::z() * (1.5 * roster.radius_m[*ball]))
        };
        rec.log(NAMES, &Points3D::update_fields().with_positions(self.unsteered.iter().map(above)))
    }
}
