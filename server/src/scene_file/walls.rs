//! Walls as people write them, or by default on the floor's borders, to the engine's planes.

use super::{SceneError, SceneText};
use ballroom_physics::Wall;
use nalgebra::Vector2;
use protocol::scene::{Floor, Scene, WallBox};

/// How far a border may swerve from a line, over its length, to carry a wall.
const STRAIGHT: f64 = 1e-12;

/// Each wall with the field it comes from: west, east, south, north, then the further planes.
pub fn convert(text: &SceneText, scene: &Scene) -> Result<Vec<(Wall, String)>, SceneError> {
    let walls = &scene.walls;
    let mut out = match (walls.bounds, walls.planes.is_empty(), &scene.floor) {
        (Some(bounds), ..) => box_of(bounds, "walls.box"),
        (None, false, _) => Vec::new(),
        (None, true, Floor::Grid { x_m, y_m, .. } | Floor::Polynomial { x_m, y_m, .. }) => {
            box_of(WallBox { x_m: *x_m, y_m: *y_m }, "floor")
        }
        (None, true, Floor::Net { control_points_m }) => borders_of(text, control_points_m)?,
    };
    for (i, plane) in walls.planes.iter().enumerate() {
        let wall = Wall { point: plane.point_m.into(), normal: Vector2::from(plane.normal).normalize() };
        out.push((wall, format!("walls.plane[{i}]")));
    }
    Ok(out)
}

fn box_of(WallBox { x_m: [west, east], y_m: [south, north] }: WallBox, field: &str) -> Vec<(Wall, String)> {
    let wall =
        |x, y, nx, ny| (Wall { point: Vector2::new(x, y), normal: Vector2::new(nx, ny) }, field.to_owned());
    vec![
        wall(west, south, 1.0, 0.0),
        wall(east, north, -1.0, 0.0),
        wall(west, south, 0.0, 1.0),
        wall(east, north, 0.0, -1.0),
    ]
}

/// A wall along each border of a net, which must be a straight line seen from above.
fn borders_of(text: &SceneText, rows: &[Vec<[f64; 3]>]) -> Result<Vec<(Wall, String)>, SceneError> {
    let flat = |p: &[f64; 3]| Vector2::new(p[0], p[1]);
    let column = |i: usize| rows.iter().map(|row| flat(&row[i])).collect::<Vec<_>>();
    let row = |j: usize| rows[j].iter().map(flat).collect::<Vec<_>>();
    let all = rows.iter().flatten().map(flat);
    let middle = all.sum::<Vector2<f64>>() / (rows.len() * rows[0].len()) as f64;
    let borders = [
        ("u = 0", column(0)),
        ("u = 1", column(rows[0].len() - 1)),
        ("v = 0", row(0)),
        ("v = 1", row(rows.len() - 1)),
    ];
    let mut out = Vec::new();
    for (name, points) in borders {
        let start = points[0];
        let along = points[points.len() - 1] - start;
        let across = Vector2::new(-along.y, along.x).try_normalize(0.0).unwrap_or_default();
        let swerve = points.iter().map(|p| across.dot(&(p - start)).abs()).fold(0.0, f64::max);
        let inward = across.dot(&(middle - start));
        if inward == 0.0 || swerve > STRAIGHT * along.norm() {
            let message = format!(
                "its border {name} is no straight line from above: give the walls yourself in [walls]"
            );
            return Err(text.error("floor.net", message));
        }
        out.push((Wall { point: start, normal: across * inward.signum() }, "floor".to_owned()));
    }
    Ok(out)
}
