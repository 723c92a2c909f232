//! The balls: few as striped meshes whose rolling is seen, many as points.

use crate::recording::Recording;
use crate::{ball_mesh, palette};
use nalgebra::Vector3;
use protocol::snapshot::{Roster, Snapshot};
use rerun::components::RotationQuat;
use rerun::{
    Clear, InstancePoses3D, LineStrips3D, Mesh3D, Points3D, Quaternion, Radius, RecordingStreamResult,
};
use std::f64::consts::TAU;

/// Up to so many balls are meshes; a viewer on a laptop without a graphics card still turns these.
pub const MAX_MESHES: usize = 2_000;

/// Colours that get a mesh of their own; further ones share the nearest.
pub const MAX_COLORS: usize = 12;

/// Parent of all balls.
pub const BALLS: &str = "world/balls";
/// Entity of the balls drawn as points.
pub const POINTS: &str = "world/balls/points";
/// Entity of the ring and the name that mark players' balls.
pub const PLAYERS: &str = "world/players";

/// Entity of the ring round the ball that is followed; its middle is the ball's.
pub const FOLLOWED: &str = "world/followed";

/// Points of the ring round a player's ball.
const RING_POINTS: usize = 48;
/// Height of the ring over the floor, in parts of its radius: a flat ring cuts into a floor that is hollow there.
const RING_LIFT: f32 = 0.1;
/// How much of what is round a followed ball is shown, in radii to each side.
const FOLLOWED_RADII: f32 = 4.0;

/// Balls of one roster, sorted into what is logged together.
pub struct BallView {
    groups: Vec<Group>,
    points: Vec<usize>,
    players: Vec<usize>,
    names: Vec<String>,
    radii: Vec<f32>,
    followed: Option<usize>,
}

/// Balls that share a mesh.
#[derive(Debug, PartialEq, Eq)]
struct Group {
    color: [u8; 3],
    player: bool,
    members: Vec<usize>,
}

impl BallView {
    /// Chooses how to draw a roster. Players' balls are meshes whatever the number of the others.
    pub fn of(roster: &Roster, followed: Option<usize>) -> Self {
        let (players, others): (Vec<usize>, Vec<usize>) =
            (0..roster.names.len()).partition(|ball| roster.player[*ball]);
        let few = roster.names.len() <= MAX_MESHES;
        let (meshes, points) = if few { (others, vec![]) } else { (vec![], others) };
        let mut groups = grouped(&meshes, roster, false);
        let players: Vec<usize> = players.into_iter().take(MAX_MESHES).collect();
        groups.extend(grouped(&players, roster, true));
        let names = players.iter().map(|ball| roster.names[*ball].clone()).collect();
        let radii = roster.radius_m.iter().map(|r| *r as f32).collect();
        Self { groups, points, players, names, radii, followed }
    }

    /// How many entities [`Self::log_roster`] fills with meshes.
    pub const fn groups(&self) -> usize {
        self.groups.len()
    }

    /// Logs what does not change with the state. `stale` is the number of groups of the roster before this one.
    pub fn log_roster(&self, rec: &Recording, roster: &Roster, stale: usize) -> RecordingStreamResult<()> {
        rec.log(BALLS, &Clear::recursive())?;
        rec.log(PLAYERS, &Clear::recursive())?;
        rec.log(FOLLOWED, &Clear::flat())?;
        let detail = ball_mesh::detail(roster.names.len());
        for (place, group) in self.groups.iter().enumerate() {
            rec.log_static(path(place), &ball_mesh::mesh(group.color, group.player, detail))?;
        }
        for place in self.groups.len()..stale {
            // A static mesh cannot be cleared, and without poses it would be drawn once: replace it by nothing.
            rec.log_static(path(place), &Mesh3D::new(Vec::<[f32; 3]>::new()))?;
        }
        if !self.points.is_empty() {
            let looks = Points3D::update_fields()
                .with_radii(self.points.iter().map(|ball| self.radii[*ball]))
                .with_colors(self.points.iter().map(|ball| palette::color(roster.color_rgb[*ball])));
            rec.log_static(POINTS, &looks)?;
        }
        Ok(())
    }

    /// Logs where all balls are; `ring` tells where the ring of a player's ball lies.
    pub fn log_state(
        &self,
        rec: &Recording,
        state: &Snapshot,
        ring: impl Fn(usize) -> Ring,
    ) -> RecordingStreamResult<()> {
        for (place, group) in self.groups.iter().enumerate() {
            rec.log(path(place), &self.poses(group, state))?;
        }
        if !self.points.is_empty() {
            let centers = self.points.iter().map(|ball| state.center_m[*ball].map(|x| x as f32));
            rec.log(POINTS, &Points3D::update_fields().with_positions(centers))?;
        }
        self.log_followed(rec, state)?;
        self.log_players(rec, state, ring)
    }

    /// A thin level ring, and two corners that cannot be seen: an eye that follows an entity looks at the middle of the box
    /// round it, from as far as shows all of it.
    fn log_followed(&self, rec: &Recording, state: &Snapshot) -> RecordingStreamResult<()> {
        let Some(ball) = self.followed else { return Ok(()) };
        let ring = Ring { center: state.center_m[ball].into(), normal: Vector3::z() };
        let radius = self.radii[ball];
        let corner = |side: f32| {
            let corner = ring.center + Vector3::repeat(f64::from(side * FOLLOWED_RADII * radius));
            vec![crate::single(corner); 2]
        };
        let mark = LineStrips3D::new([ring.points(1.02 * radius, 0.0), corner(-1.0), corner(1.0)])
            .with_radii([1.0, 0.0, 0.0].map(Radius::new_ui_points))
            .with_colors([palette::color(palette::NAME)]);
        rec.log(FOLLOWED, &mark)
    }

    /// Scales are logged with every pose: static ones are ignored beside poses that move.
    fn poses(&self, group: &Group, state: &Snapshot) -> InstancePoses3D {
        let members = || group.members.iter().copied();
        let quaternion = |ball: usize| {
            RotationQuat::from(Quaternion::from_xyzw(state.orientation_xyzw[ball].map(|x| x as f32)))
        };
        InstancePoses3D::new()
            .with_translations(members().map(|ball| state.center_m[ball].map(|x| x as f32)))
            .with_quaternions(members().map(quaternion))
            .with_scales(members().map(|ball| [self.radii[ball]; 3]))
    }

    fn log_players(
        &self,
        rec: &Recording,
        state: &Snapshot,
        ring: impl Fn(usize) -> Ring,
    ) -> RecordingStreamResult<()> {
        if self.players.is_empty() {
            return Ok(());
        }
        let rings = self.players.iter().map(|ball| ring(*ball).points(1.25 * self.radii[*ball], RING_LIFT));
        let marks = LineStrips3D::new(rings)
            .with_radii([Radius::new_ui_points(1.5)])
            .with_colors([palette::color(palette::PLAYER)]);
        rec.log(PLAYERS, &marks)?;
        let above = self.players.iter().map(|ball| {
            let [x, y, z] = state.center_m[*ball].map(|x| x as f32);
            [x, y, z + 1.9 * self.radii[*ball]]
        });
        let names = Points3D::new(above)
            .with_labels(self.names.iter().map(String::as_str))
            .with_show_labels(true)
            .with_radii([Radius::new_ui_points(0.0)])
            .with_colors([palette::color(palette::PLAYER)]);
        rec.log(format!("{PLAYERS}/name"), &names)
    }
}

/// Where a ring lies: a point just above the floor and the floor's normal there.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    /// Its middle, m.
    pub center: Vector3<f64>,
    /// Unit normal of its plane.
    pub normal: Vector3<f64>,
}

impl Ring {
    /// A closed line round it, `lift` radii above its plane.
    fn points(self, radius: f32, lift: f32) -> Vec<[f32; 3]> {
        // Any two directions in the plane; a normal along x leaves y.
        let across = self.normal.cross(&Vector3::x()).try_normalize(1e-6).unwrap_or_else(Vector3::y);
        let along = across.cross(&self.normal);
        let at = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / RING_POINTS as f64).sin_cos();
            let arm = (along * cos + across * sin) * f64::from(radius);
            crate::single(self.center + arm + self.normal * f64::from(lift * radius))
        };
        (0..=RING_POINTS).map(at).collect()
    }
}

fn path(place: usize) -> String {
    format!("{BALLS}/{place}")
}

/// Balls by colour; once there are [`MAX_COLORS`] groups, further balls join the nearest.
fn grouped(balls: &[usize], roster: &Roster, player: bool) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for ball in balls {
        let color = roster.color_rgb[*ball];
        let full = groups.len() >= MAX_COLORS;
        match groups.iter_mut().min_by_key(|group| distance(group.color, color)) {
            Some(group) if full || group.color == color => group.members.push(*ball),
            _ => groups.push(Group { color, player, members: vec![*ball] }),
        }
    }
    groups
}

fn distance(a: [u8; 3], b: [u8; 3]) -> u32 {
    a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Moment;
    use crate::testing;
    use rerun::log::{Chunk, LogMsg};

    fn roster(count: usize) -> Roster {
        Roster {
            names: (0..count).map(|i| format!("b{i:05}")).collect(),
            radius_m: vec![0.1; count],
            mass_kg: vec![1.0; count],
            inertia_factor: vec![0.4; count],
            color_rgb: (0..count).map(|i| [(i % 40) as u8 * 6, 100, 50]).collect(),
            player: (0..count).map(|i| i == 3).collect(),
            ..Roster::default()
        }
    }

    #[test]
    fn up_to_the_limit_every_ball_is_in_exactly_one_mesh_group() {
        let view = BallView::of(&roster(MAX_MESHES), None);
        assert!(view.points.is_empty() && view.groups() == MAX_COLORS + 1);
        let mut members: Vec<usize> = view.groups.iter().flat_map(|g| g.members.clone()).collect();
        members.sort_unstable();
        assert!(members.into_iter().eq(0..MAX_MESHES));
    }

    #[test]
    fn above_the_limit_all_but_the_player_are_points() {
        let view = BallView::of(&roster(MAX_MESHES + 1), None);
        assert_eq!((view.points.len(), view.groups()), (MAX_MESHES, 1));
        assert_eq!(view.groups[0].members, [3]);
    }

    #[test]
    fn points_keep_their_looks_and_move_with_every_state() {
        let count = MAX_MESHES + 1;
        let roster = roster(count);
        let view = BallView::of(&roster, None);
        let (rec, storage) = testing::recording();
        view.log_roster(&rec, &roster, 0).unwrap();
        let state = Snapshot {
            center_m: vec![[0.0; 3]; count],
            orientation_xyzw: vec![[0.0, 0.0, 0.0, 1.0]; count],
            ..Snapshot::default()
        };
        for tick in 0..10 {
            rec.at(Moment { tick, ..Moment::default() });
            view.log_state(&rec, &state, |_| Ring { center: Vector3::zeros(), normal: Vector3::z() })
                .unwrap();
        }
        rec.stream().flush_blocking().unwrap();
        let (mut looks, mut moves) = (0, 0);
        for message in storage.take() {
            let LogMsg::ArrowMsg(_, arrow) = message else { continue };
            let chunk = Chunk::from_arrow_msg(&arrow).unwrap();
            if chunk.entity_path().to_string() == format!("/{POINTS}") {
                *(if chunk.is_static() { &mut looks } else { &mut moves }) += chunk.num_rows();
            }
        }
        assert_eq!((looks, moves), (1, 10));
    }

    #[test]
    fn a_ring_lies_in_the_floors_plane_around_its_middle() {
        let normal = Vector3::new(0.6, 0.0, 0.8);
        for normal in [normal, Vector3::x(), Vector3::z()] {
            let ring = Ring { center: Vector3::new(1.0, 2.0, 3.0), normal };
            for point in ring.points(0.5, RING_LIFT) {
                let arm = Vector3::from(point.map(f64::from)) - ring.center;
                let lift = f64::from(RING_LIFT) * 0.5;
                assert!((arm.dot(&normal) - lift).abs() < 1e-6);
                assert!(((arm - normal * lift).norm() - 0.5).abs() < 1e-6);
            }
        }
    }
}
