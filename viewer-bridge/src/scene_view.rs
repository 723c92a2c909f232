//! What stands still: the floor with lines on it, and the walls.

use crate::floor_mesh::{FloorMesh, Tessellation};
use crate::net_view;
use crate::palette;
use crate::recording::Recording;
use crate::surface::{NotAFloor, Surface};
use nalgebra::{Vector2, Vector3};
use protocol::scene::{Scene, WallPlane};
use protocol::snapshot::Roster;
use rerun::{Boxes3D, FillMode, LineStrips3D, Quaternion, Radius, RecordingStreamResult, ViewCoordinates};

/// Entity of the floor's mesh.
pub const FLOOR: &str = "world/floor";
/// Entity of the lines on the floor.
pub const FLOOR_LINES: &str = "world/floor/lines";
/// Entity of the walls.
pub const WALLS: &str = "world/walls";

/// Points along each line on the floor.
const LINE_POINTS: usize = 120;

/// A scene prepared for drawing.
pub struct SceneView {
    surface: Surface,
    plan: Tessellation,
    walls: Vec<Wall>,
    extent: Extent,
    lift_m: f64,
}

/// The box that holds all that is drawn, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// West, south and lowest.
    pub lowest: [f64; 3],
    /// East, north and highest.
    pub highest: [f64; 3],
}

impl Extent {
    /// Its middle, m.
    pub fn middle(&self) -> [f64; 3] {
        std::array::from_fn(|i| f64::midpoint(self.lowest[i], self.highest[i]))
    }

    /// Its eight corners, m.
    pub fn corners(&self) -> [Vector3<f64>; 8] {
        let sides = [self.lowest, self.highest];
        std::array::from_fn(|k| Vector3::new(sides[k & 1][0], sides[k >> 1 & 1][1], sides[k >> 2][2]))
    }

    /// Its diagonal, m.
    pub fn diagonal_m(&self) -> f64 {
        (Vector3::from(self.highest) - Vector3::from(self.lowest)).norm()
    }
}

/// A thin upright slab.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wall {
    center: Vector3<f64>,
    half_size: Vector3<f64>,
    /// Angle of its length against x, rad.
    heading: f64,
}

impl SceneView {
    /// Prepares a scene's floor for balls of this roster.
    pub fn of(scene: &Scene, roster: &Roster) -> Result<Self, NotAFloor> {
        let surface = Surface::of(&scene.floor)?;
        let [x, y] = surface.bounds();
        let size = (x[1] - x[0]).max(y[1] - y[0]);
        let radii = || roster.radius_m.iter().copied().filter(|r| *r > 0.0);
        let smallest = radii().reduce(f64::min).unwrap_or(0.01 * size);
        let largest = radii().reduce(f64::max).unwrap_or(smallest);
        let plan = Tessellation::of(&surface, crate::floor_mesh::SAGITTA_OF_RADIUS * smallest);

        let rim = rim_heights(&surface);
        let height = scene.walls.drawn_height_m.unwrap_or(2.0 * largest).max(1e-3 * size);
        let standing = [rim[0], rim[1] + height];
        let walls = walls(scene, [x, y], standing);
        let heights = FloorMesh::of(&surface, [64, 64]).heights();
        let extent = Extent {
            lowest: [x[0], y[0], heights[0].min(standing[0])],
            highest: [x[1], y[1], heights[1].max(standing[1])],
        };
        // Lines lie above the triangles, and below notice.
        let lift_m = 2.0 * plan.sagitta_m + 2e-4 * size;
        Ok(Self { surface, plan, walls, extent, lift_m })
    }

    /// The box that holds all that is drawn.
    pub const fn extent(&self) -> Extent {
        self.extent
    }

    /// The floor's surface.
    pub const fn surface(&self) -> &Surface {
        &self.surface
    }

    /// How the floor was cut.
    pub const fn tessellation(&self) -> Tessellation {
        self.plan
    }

    /// A point just above the floor, m: where tracks are drawn.
    pub fn above(&self, [u, v]: [f64; 2]) -> Vector3<f64> {
        let (point, normal) = self.surface.frame(u, v);
        point + normal * self.lift_m
    }

    /// How far above the floor that is, m.
    pub const fn lift_m(&self) -> f64 {
        self.lift_m
    }

    /// The floor's unit normal, upwards.
    pub fn normal(&self, [u, v]: [f64; 2]) -> Vector3<f64> {
        self.surface.frame(u, v).1
    }

    /// Logs the scene for all time.
    pub fn log(&self, rec: &Recording) -> RecordingStreamResult<()> {
        rec.log_static("world", &ViewCoordinates::RIGHT_HAND_Z_UP())?;
        rec.log_static(FLOOR, &FloorMesh::of(&self.surface, self.plan.cells).into_mesh3d())?;
        rec.log_static(FLOOR_LINES, &self.lines())?;
        net_view::log(rec, &self.surface)?;
        rec.log_static(WALLS, &self.boxes())
    }

    /// Lines of constant u and v, a round number of metres apart where the floor's map is even.
    fn lines(&self) -> LineStrips3D {
        let [x, y] = self.surface.bounds();
        let spacing = round_spacing((x[1] - x[0]).max(y[1] - y[0]));
        let count = |[from, to]: [f64; 2]| ((to - from) / spacing).round().clamp(1.0, 64.0) as usize;
        let place = |i: usize, n: usize| i as f64 / n as f64;
        let [across, along] = [count(x), count(y)];
        let line = |at: &dyn Fn(f64) -> [f64; 2]| -> Vec<[f32; 3]> {
            (0..=LINE_POINTS).map(|k| crate::single(self.above(at(place(k, LINE_POINTS))))).collect()
        };
        let along_v = (0..=across).map(|i| line(&|t| [place(i, across), t]));
        let along_u = (0..=along).map(|j| line(&|t| [t, place(j, along)]));
        LineStrips3D::new(along_v.chain(along_u))
            .with_radii([Radius::new_ui_points(0.5)])
            .with_colors([palette::color(palette::GRID)])
    }

    fn boxes(&self) -> Boxes3D {
        let turned = |angle: f64| {
            let half = 0.5 * angle;
            Quaternion::from_xyzw([0.0, 0.0, half.sin() as f32, half.cos() as f32])
        };
        Boxes3D::from_centers_and_half_sizes(
            self.walls.iter().map(|w| crate::single(w.center)),
            self.walls.iter().map(|w| crate::single(w.half_size)),
        )
        .with_quaternions(self.walls.iter().map(|w| turned(w.heading)))
        .with_colors([palette::translucent(palette::WALL)])
        .with_fill_mode(FillMode::Solid)
    }
}

/// Lowest and highest point of the floor's border, m.
fn rim_heights(surface: &Surface) -> [f64; 2] {
    let sides: [fn(f64) -> [f64; 2]; 4] = [|t| [t, 0.0], |t| [t, 1.0], |t| [0.0, t], |t| [1.0, t]];
    let samples = || sides.iter().flat_map(|side| (0..=64).map(|k| side(f64::from(k) / 64.0)));
    let heights = || samples().map(|[u, v]| surface.point(u, v).z);
    [heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max)]
}

/// 1, 2 or 5 times a power of ten, about a twentieth of the size.
fn round_spacing(size: f64) -> f64 {
    let raw = (size / 20.0).max(1e-9);
    let power = 10_f64.powf(raw.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|c| c * power).into_iter().find(|s| *s >= raw * 0.999).unwrap_or(10.0 * power)
}

/// The scene's walls: its box and planes, or the floor's borders when it names none.
fn walls(scene: &Scene, floor: [[f64; 2]; 2], standing: [f64; 2]) -> Vec<Wall> {
    let named = &scene.walls;
    let open = named.bounds.is_none() && named.planes.is_empty();
    let bounds = named.bounds.map(|b| [b.x_m, b.y_m]).or(open.then_some(floor));
    let thickness = 0.004 * (floor[0][1] - floor[0][0]).max(floor[1][1] - floor[1][0]);
    let room = bounds.unwrap_or(floor);
    let [[west, east], [south, north]] = room;
    let sides = [
        ([west, 0.0], [1.0, 0.0]),
        ([east, 0.0], [-1.0, 0.0]),
        ([0.0, south], [0.0, 1.0]),
        ([0.0, north], [0.0, -1.0]),
    ]
    .map(|(point_m, normal)| WallPlane { point_m, normal });
    let sides = sides.into_iter().filter(|_| bounds.is_some());
    sides
        .chain(named.planes.iter().copied())
        .filter_map(|plane| slab(plane, room, standing, thickness))
        .collect()
}

/// The part of a plane inside the room, as a slab whose face is the plane.
fn slab(plane: WallPlane, room: [[f64; 2]; 2], standing: [f64; 2], thickness: f64) -> Option<Wall> {
    let normal = Vector2::from(plane.normal).try_normalize(0.0)?;
    let point = Vector2::from(plane.point_m);
    let along = Vector2::new(-normal.y, normal.x);
    // Clip the line to the room, axis by axis.
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..2 {
        let slack = 1e-9 * (room[axis][1] - room[axis][0]);
        let ends = room[axis].map(|border| (border - point[axis]) / along[axis]);
        if along[axis].abs() > 1e-12 {
            from = from.max(ends[0].min(ends[1]));
            to = to.min(ends[0].max(ends[1]));
        } else if point[axis] < room[axis][0] - slack || point[axis] > room[axis][1] + slack {
            return None;
        }
    }
    if from >= to {
        return None;
    }
    let middle = point + along * f64::midpoint(from, to) - normal * (0.5 * thickness);
    Some(Wall {
        center: Vector3::new(middle.x, middle.y, f64::midpoint(standing[0], standing[1])),
        half_size: Vector3::new(0.5 * (to - from), 0.5 * thickness, 0.5 * (standing[1] - standing[0])),
        heading: along.y.atan2(along.x),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::scene::{WallBox, Walls};

    const ROOM: [[f64; 2]; 2] = [[-10.0, 10.0], [-4.0, 4.0]];

    fn scene(walls: Walls) -> Scene {
        Scene { walls, ..crate::testing::original().scene }
    }

    #[test]
    fn a_floor_without_walls_is_walled_at_its_borders() {
        let walls = walls(&scene(Walls::default()), ROOM, [0.0, 2.0]);
        assert_eq!(walls.len(), 4);
        let faces: Vec<f64> = walls.iter().map(|w| w.center.x.abs().max(w.center.y.abs())).collect();
        assert!(faces.iter().all(|f| *f > 4.0), "slabs stand outside the room: {faces:?}");
    }

    #[test]
    fn a_slanted_plane_spans_the_room_and_no_more() {
        let plane = WallPlane { point_m: [8.0, 4.0], normal: [-3.0, -3.0] };
        let wall = slab(plane, ROOM, [0.0, 1.0], 0.0).unwrap();
        // From (8, 4) down to the east wall at (10, 2).
        assert!((wall.half_size.x - 2.0_f64.sqrt()).abs() < 1e-12);
        assert!((wall.center - Vector3::new(9.0, 3.0, 0.5)).norm() < 1e-12);
    }

    #[test]
    fn a_plane_outside_the_room_is_not_drawn() {
        assert_eq!(
            slab(WallPlane { point_m: [11.0, 0.0], normal: [-1.0, 0.0] }, ROOM, [0.0, 1.0], 0.1),
            None
        );
    }

    #[test]
    fn a_box_takes_the_place_of_the_borders() {
        let bounds = Some(WallBox { x_m: [-1.0, 1.0], y_m: [-1.0, 1.0] });
        let walls = walls(&scene(Walls { bounds, ..Walls::default() }), ROOM, [0.0, 2.0]);
        assert!(walls.len() == 4 && walls.iter().all(|w| w.center.xy().norm() < 1.1));
    }

    #[test]
    fn lines_are_a_round_number_of_metres_apart() {
        assert_eq!([20.0, 1.0, 7.0].map(round_spacing), [1.0, 0.05, 0.5]);
    }
}
