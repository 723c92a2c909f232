//! What a lesson points at: where balls touch, how they move, how hard the floor presses, what they are called.
//!
//! Drawn for [`detailed`](crate::chosen::detailed) balls; which views show it says the layout.

use crate::mechanics::Mechanics;
use crate::palette;
use crate::recording::Recording;
use crate::scene_view::SceneView;
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
        let unsteered = balls.iter().filter(|ball| !roster.player[**ball]).map(named).collect();
        Self { balls, unsteered, mechanics, gravity: Vector3::from(gravity_m_per_s2).norm() }
    }

    /// Takes away what an earlier roster had.
    pub fn clear(rec: &Recording) -> RecordingStreamResult<()> {
        rec.log(OVERLAYS, &Clear::recursive())
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
        let touching: Vec<[f32; 3]> =
            balls().map(|ball| crate::single(floor.above(state.uv[ball]))).collect();
        let contacts = Points3D::new(touching.iter().copied())
            .with_radii([Radius::new_ui_points(4.0)])
            .with_colors([palette::color(palette::CONTACT)]);
        rec.log(CONTACTS, &contacts)?;

        let along = balls().map(|ball| crate::single(Vector3::from(state.velocity_m_per_s[ball]) * AHEAD_S));
        let velocities = Arrows3D::from_vectors(along)
            .with_origins(balls().map(|ball| crate::single(state.center_m[ball].into())))
            .with_radii([Radius::new_ui_points(1.5)])
            .with_colors([palette::color(palette::VELOCITY)]);
        rec.log(VELOCITIES, &velocities)?;

        let reactions = balls().map(|ball| crate::single(self.reaction(floor, roster, state, ball)));
        let reactions = Arrows3D::from_vectors(reactions)
            .with_origins(touching)
            .with_radii([Radius::new_ui_points(1.5)])
            .with_colors([palette::color(palette::REACTION)]);
        rec.log(REACTIONS, &reactions)?;
        self.log_names(rec, roster, state)
    }

    /// The reaction as an arrow, m.
    fn reaction(&self, floor: &SceneView, roster: &Roster, state: &Snapshot, ball: usize) -> Vector3<f64> {
        let force_n = self.mechanics.reaction_n(floor.surface(), roster, state, ball);
        let weights = (force_n / (roster.mass_kg[ball] * self.gravity)).clamp(-MAX_WEIGHTS, MAX_WEIGHTS);
        floor.normal(state.uv[ball]) * (WEIGHT_RADII * roster.radius_m[ball] * weights)
    }

    fn log_names(&self, rec: &Recording, roster: &Roster, state: &Snapshot) -> RecordingStreamResult<()> {
        if self.unsteered.is_empty() {
            return Ok(());
        }
        let above = |(ball, _): &(usize, String)| {
            let center = Vector3::from(state.center_m[*ball]);
            crate::single(center + Vector3::z() * (1.5 * roster.radius_m[*ball]))
        };
        let names = Points3D::new(self.unsteered.iter().map(above))
            .with_labels(self.unsteered.iter().map(|(_, name)| name.as_str()))
            .with_show_labels(true)
            .with_radii([Radius::new_ui_points(0.0)])
            .with_colors([palette::color(palette::NAME)]);
        rec.log(NAMES, &names)
    }
}
