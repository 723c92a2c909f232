//! One scene with its balls, prepared for drawing: everything that is shown of a state.

use crate::ball_view::{BallView, Ring};
use crate::chosen::detailed;
use crate::energy_plots::EnergyPlots;
use crate::floor_mesh::Tessellation;
use crate::hit_view::HitView;
use crate::mechanics::Mechanics;
use crate::named_view::{Followed, NamedView, Sights};
use crate::net_view;
use crate::overlay_view::OverlayView;
use crate::recording::Recording;
use crate::scene_view::SceneView;
use crate::surface::NotAFloor;
use crate::trail_view::TrailView;
use protocol::event::Event;
use protocol::scene::Scene;
use protocol::snapshot::{Roster, Snapshot, World};
use rerun::RecordingStreamResult;

/// A border of the room that moved by more than this part of its diagonal needs another eye.
const ANOTHER_ROOM: f64 = 0.1;

/// A scene and a roster being drawn.
pub struct Drawn {
    scene: Scene,
    roster: Roster,
    sights: Sights,
    floor: SceneView,
    balls: BallView,
    overlays: OverlayView,
    trails: TrailView,
    hits: HitView,
    energy: EnergyPlots,
}

impl Drawn {
    /// Prepares a world.
    pub fn of(world: &World, first: &NamedView) -> Result<Self, NotAFloor> {
        let World { scene, roster, snapshot, .. } = world;
        let floor = SceneView::of(scene, roster)?;
        let followed = first.followed(roster).filter(|ball| *ball < snapshot.center_m.len());
        let mechanics = Mechanics::of(scene);
        let detailed = detailed(roster, followed);
        let sight = |ball: usize| Followed {
            name: roster.names[ball].clone(),
            center_m: snapshot.center_m[ball],
            radius_m: roster.radius_m[ball],
        };
        Ok(Self {
            sights: Sights {
                room: floor.extent(),
                net: net_view::extent(floor.surface()),
                followed: followed.map(sight),
            },
            balls: BallView::of(roster, followed),
            trails: TrailView::of(roster),
            hits: HitView::of(roster),
            energy: EnergyPlots::of(mechanics, detailed.clone()),
            overlays: OverlayView::of(mechanics, scene.gravity_m_per_s2, roster, detailed),
            scene: scene.clone(),
            roster: roster.clone(),
            floor,
        })
    }

    /// Whether this is that world's scene and roster.
    pub fn shows(&self, world: &World) -> bool {
        self.scene == world.scene && self.roster == world.roster
    }

    /// What the eyes look at.
    pub const fn sights(&self) -> &Sights {
        &self.sights
    }

    /// Whether eyes and plots made for another one serve here too: an edited floor in the same room does not turn
    /// anybody's head.
    pub fn looks_like(&self, other: &Self) -> bool {
        let borders = |sights: &Sights| [sights.room.lowest, sights.room.highest].concat();
        let most = ANOTHER_ROOM * other.sights.room.diagonal_m();
        let near = |(a, b): (&f64, &f64)| (a - b).abs() <= most;
        let name = |sights: &Sights| sights.followed.as_ref().map(|ball| ball.name.clone());
        self.scene.name == other.scene.name
            && name(&self.sights) == name(&other.sights)
            && borders(&self.sights).iter().zip(&borders(&other.sights)).all(near)
    }

    /// Logs what stands still, and takes away what was drawn of the one before.
    pub fn log(&self, rec: &Recording, before: Option<&Self>) -> RecordingStreamResult<()> {
        let same_floor = before.is_some_and(|before| {
            before.scene.floor == self.scene.floor
                && before.scene.walls == self.scene.walls
                && before.floor.tessellation() == self.floor.tessellation()
        });
        if !same_floor {
            self.floor.log(rec)?;
        }
        if before.is_none_or(|before| before.roster != self.roster) {
            self.balls.log_roster(rec, &self.roster, before.map_or(0, |before| before.balls.groups()))?;
            self.overlays.log_looks(rec)?;
            self.energy.log_names(rec, &self.roster)?;
        }
        Ok(())
    }

    /// How the floor was cut.
    pub const fn tessellation(&self) -> Tessellation {
        self.floor.tessellation()
    }

    /// Forgets tracks and hits, and shows that.
    pub fn clear(&mut self, rec: &Recording) -> RecordingStreamResult<()> {
        self.trails.clear(rec)?;
        self.hits.clear(rec)
    }

    /// Takes a hit in.
    pub fn add(&mut self, hit: &Event) {
        self.hits.add(hit);
    }

    /// Whether a state has an entry for each ball in all that is drawn.
    pub fn fits(&self, state: &Snapshot) -> bool {
        let lengths = [
            state.uv.len(),
            state.center_m.len(),
            state.velocity_m_per_s.len(),
            state.omega_rad_per_s.len(),
            state.orientation_xyzw.len(),
        ];
        lengths == [self.roster.names.len(); 5]
    }

    /// Logs a state that fits.
    pub fn log_state(&mut self, rec: &Recording, state: &Snapshot) -> RecordingStreamResult<()> {
        let floor = &self.floor;
        let ring = |ball: usize| {
            let uv = state.uv[ball];
            Ring { center: floor.above(uv), normal: floor.normal(uv) }
        };
        self.balls.log_state(rec, state, ring)?;
        self.overlays.log_state(rec, floor, &self.roster, state)?;
        self.trails.log_state(rec, state, |uv| floor.above(uv))?;
        self.hits.log_state(rec, state)?;
        self.energy.log_state(rec, floor.surface(), &self.roster, state)
    }
}
