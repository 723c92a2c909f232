//! The floor as triangles, fine enough that no ball is seen to sink in or hover.

use crate::palette;
use crate::surface::Surface;
use rerun::{Color, Mesh3D};

/// The flat triangles leave the surface by less than this part of the smallest radius.
pub const SAGITTA_OF_RADIUS: f64 = 0.01;

/// At most so many triangles are drawn, whatever the radius: 12 MB for each viewer that joins.
pub const MAX_TRIANGLES: usize = 400_000;

/// At least so many cells each way, so that the colours of heights are smooth.
const MIN_CELLS: usize = 32;

/// How a floor is cut into cells of two triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tessellation {
    /// Cells along u and v.
    pub cells: [usize; 2],
    /// Certain bound of the distance between triangles and surface, m.
    pub sagitta_m: f64,
    /// Whether [`MAX_TRIANGLES`] kept the sagitta above what was wanted.
    pub bounded: bool,
}

impl Tessellation {
    /// The fewest cells whose sagitta is at most `wanted_m`, within [`MAX_TRIANGLES`].
    ///
    /// Linear interpolation on a right triangle with legs 1/n and 1/m errs by at most
    /// `(|S_uu|/n^2 + 2 |S_uv|/(n m) + |S_vv|/m^2) / 8` (Filip, Magedson and Markot 1986).
    pub fn of(surface: &Surface, wanted_m: f64) -> Self {
        let [uu, uv, vv] = surface.second_derivative_bounds();
        let sagitta = |[n, m]: [f64; 2]| (uu / (n * n) + 2.0 * uv / (n * m) + vv / (m * m)) / 8.0;
        // Equal shares of the error along both directions need cells in this ratio.
        let ratio = if uu > 0.0 && vv > 0.0 { (uu / vv).sqrt().clamp(1.0 / 16.0, 16.0) } else { 1.0 };
        let along = (sagitta([ratio, 1.0]) / wanted_m).sqrt().max(1.0);
        let most = (MAX_TRIANGLES as f64 / (2.0 * ratio)).sqrt();
        let bounded = along > most;
        let along = along.min(most);
        // Rounding up must not cross the bound, rounding down must not cross the sagitta.
        let round = |x: f64| if bounded { x.floor() as usize } else { x.ceil() as usize }.max(MIN_CELLS);
        let cells = [round(along * ratio), round(along)];
        Self { cells, sagitta_m: sagitta(cells.map(|n| n as f64)), bounded }
    }

    /// Number of triangles.
    pub const fn triangles(&self) -> usize {
        2 * self.cells[0] * self.cells[1]
    }
}

/// Corners, normals and triangles of a floor.
pub struct FloorMesh {
    /// Corners, m.
    pub positions: Vec<[f32; 3]>,
    /// Exact unit normals of the surface at the corners.
    pub normals: Vec<[f32; 3]>,
    /// Corners of each triangle, counter-clockwise seen from above.
    pub triangles: Vec<[u32; 3]>,
}

impl FloorMesh {
    /// Evaluates the surface at the corners of all cells.
    pub fn of(surface: &Surface, [n, m]: [usize; 2]) -> Self {
        let corners = (n + 1) * (m + 1);
        let (mut positions, mut normals) = (Vec::with_capacity(corners), Vec::with_capacity(corners));
        for i in 0..=n {
            let column = surface.column(i as f64 / n as f64);
            for j in 0..=m {
                let (point, normal) = column.frame(j as f64 / m as f64);
                positions.push(crate::single(point));
                normals.push(crate::single(normal));
            }
        }
        let corner = |i: usize, j: usize| (i * (m + 1) + j) as u32;
        let cell = |i: usize, j: usize| {
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        let triangles = (0..n).flat_map(|i| (0..m).flat_map(move |j| cell(i, j))).collect();
        Self { positions, normals, triangles }
    }

    /// Lowest and highest corner, m.
    pub fn heights(&self) -> [f64; 2] {
        let heights = || self.positions.iter().map(|p| f64::from(p[2]));
        [heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max)]
    }

    /// The mesh in Rerun's words, coloured by height.
    pub fn into_mesh3d(self) -> Mesh3D {
        let heights = self.heights();
        let colors: Vec<Color> =
            self.positions.iter().map(|p| palette::of_height(f64::from(p[2]), heights)).collect();
        Mesh3D::new(self.positions)
            .with_vertex_normals(self.normals)
            .with_vertex_colors(colors)
            .with_triangle_indices(self.triangles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use protocol::scene::{Floor, Term};

    fn egg_box() -> Surface {
        let rows = (0..6).map(|j| (0..9).map(|i| f64::from((i * 7 + j * 5) % 4) - 1.5).collect()).collect();
        Surface::of(&Floor::Grid { x_m: [-2.0, 2.0], y_m: [-1.0, 1.0], control_heights_m: rows }).unwrap()
    }

    #[test]
    fn triangles_stay_within_the_stated_sagitta_of_the_exact_surface() {
        let surface = egg_box();
        let plan = Tessellation::of(&surface, 0.002);
        assert!(!plan.bounded && plan.sagitta_m <= 0.002);
        let mesh = FloorMesh::of(&surface, plan.cells);
        assert_eq!(mesh.triangles.len(), plan.triangles());
        let [n, m] = plan.cells;
        let corner = |k: u32| {
            let (i, j) = (k as usize / (m + 1), k as usize % (m + 1));
            (
                i as f64 / n as f64,
                j as f64 / m as f64,
                Vector3::from(mesh.positions[k as usize].map(f64::from)),
            )
        };
        let mut worst: f64 = 0.0;
        for triangle in mesh.triangles.iter().step_by(7) {
            let [a, b, c] = triangle.map(corner);
            for weights in [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.3, 0.3, 0.4]] {
                let mix = |x: f64, y: f64, z: f64| weights[0] * x + weights[1] * y + weights[2] * z;
                let drawn = a.2 * weights[0] + b.2 * weights[1] + c.2 * weights[2];
                worst = worst.max((surface.point(mix(a.0, b.0, c.0), mix(a.1, b.1, c.1)) - drawn).norm());
            }
        }
        // Corners are rounded to f32, below a micrometre here.
        assert!(worst <= plan.sagitta_m + 1e-6, "{worst} {}", plan.sagitta_m);
        assert!(worst > 0.2 * plan.sagitta_m, "the bound is loose: {worst} {}", plan.sagitta_m);
    }

    #[test]
    fn normals_are_unit_and_point_up() {
        let mesh = FloorMesh::of(&egg_box(), [20, 10]);
        assert!(
            mesh.normals
                .iter()
                .all(|n| n[2] > 0.0 && (n.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-5)
        );
    }

    #[test]
    fn the_number_of_triangles_is_bounded_and_the_bound_is_told() {
        let plan = Tessellation::of(&egg_box(), 1e-9);
        assert!(plan.bounded && plan.triangles() <= MAX_TRIANGLES && plan.sagitta_m > 1e-9);
    }

    #[test]
    fn a_saddle_is_cut_for_its_twist() {
        let terms = vec![Term { px: 1, py: 1, c: 1.0 }];
        let surface = Surface::of(&Floor::Polynomial { x_m: [-1.0, 1.0], y_m: [-1.0, 1.0], terms }).unwrap();
        let plan = Tessellation::of(&surface, 1e-4);
        assert!(plan.sagitta_m <= 1e-4 && plan.sagitta_m > 0.0);
    }
}
