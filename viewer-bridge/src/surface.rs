//! The floor's surface as drawn: points, exact normals, and a bound on its second derivatives.
//!
//! Every way of writing a floor ends in one control net, so that there is one evaluation. The bridge has its
//! own because a viewer must not need the engine.

use nalgebra::Vector3;
use protocol::scene::{Floor, Term};

type Point = Vector3<f64>;

/// The largest degree in either direction, as in scene files.
pub const MAX_DEGREE: usize = 12;

/// Pieces per direction over which second derivatives are bounded: the bound tightens with the square of this.
const BOUND_PIECES: usize = 24;

/// A tensor-product Bezier patch S(u, v) over the unit square.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// `net[i][j]` belongs to `B_i(u) B_j(v)`.
    net: Vec<Vec<Point>>,
}

/// Why a floor cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotAFloor(&'static str);

impl std::fmt::Display for NotAFloor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the scene's floor cannot be drawn: {}; the server should have refused it", self.0)
    }
}

impl std::error::Error for NotAFloor {}

impl Surface {
    /// The surface of a scene's floor.
    pub fn of(floor: &Floor) -> Result<Self, NotAFloor> {
        let net = match floor {
            Floor::Net { control_points_m: rows } => transposed(rows, |_, _, p| Point::from(*p)),
            Floor::Grid { x_m, y_m, control_heights_m: rows } => {
                let (across, along) = (rows.first().map_or(0, Vec::len), rows.len());
                transposed(rows, |i, j, z| Point::new(evenly(*x_m, i, across), evenly(*y_m, j, along), *z))
            }
            Floor::Polynomial { x_m, y_m, terms } => polynomial_net(*x_m, *y_m, terms)?,
        };
        let columns = net.first().map_or(0, Vec::len);
        if net.len() < 2 || columns < 2 || net.iter().any(|row| row.len() != columns) {
            return Err(NotAFloor("its net needs at least 2 x 2 points in rows of one length"));
        }
        if net.len() > MAX_DEGREE + 1 || columns > MAX_DEGREE + 1 {
            return Err(NotAFloor("its degree is above 12"));
        }
        if net.iter().flatten().any(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(NotAFloor("a number in it is not finite"));
        }
        Ok(Self { net })
    }

    /// The point at (u, v), m.
    pub fn point(&self, u: f64, v: f64) -> Point {
        self.frame(u, v).0
    }

    /// The point at (u, v), m, and the unit normal `S_u x S_v / |S_u x S_v|` there, turned upwards.
    pub fn frame(&self, u: f64, v: f64) -> (Point, Point) {
        self.column(u).frame(v)
    }

    /// The curve of constant u, ready to be evaluated at many v.
    pub fn column(&self, u: f64) -> Column {
        let (points, du) = self.across(u).map(|[point, du, _]| (point, du)).unzip();
        Column { points, du }
    }

    /// The point at (u, v) and the derivatives there up to the second.
    pub fn jet(&self, u: f64, v: f64) -> Jet {
        let mut rows = [const { Vec::new() }; 3];
        for derivatives in self.across(u) {
            rows.iter_mut().zip(derivatives).for_each(|(row, point)| row.push(point));
        }
        let [[point, dv, dvv], [du, duv, _], [duu, ..]] = rows.map(|row| curve(row.into_iter(), v));
        Jet { point, normal: upward_normal(&du, &dv), du, dv, duu, duv, dvv }
    }

    /// The control points, row by row: `[i][j]` belongs to `B_i(u) B_j(v)`.
    pub fn net(&self) -> &[Vec<Point>] {
        &self.net
    }

    /// For each j the point and two derivatives, at u, of the curve along u through the control points `[.][j]`.
    fn across(&self, u: f64) -> impl Iterator<Item = [Point; 3]> {
        (0..self.net[0].len()).map(move |j| curve(self.net.iter().map(move |column| column[j]), u))
    }

    /// Largest and smallest x and y of the control net: the rectangle that holds the floor, m.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        [0, 1].map(|axis| {
            let values = || self.net.iter().flatten().map(move |p| p[axis]);
            [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
        })
    }

    /// Bounds of `|S_uu|`, `|S_uv|` and `|S_vv|` over the whole patch, m.
    ///
    /// A derivative of a Bezier patch is a Bezier patch and lies in the hull of its net; nets of small pieces lie
    /// close to the surface, so the bound is certain and tight.
    pub fn second_derivative_bounds(&self) -> [f64; 3] {
        let du = difference(&self.net);
        let dv = flipped(&difference(&flipped(&self.net)));
        let duv = flipped(&difference(&flipped(&du)));
        [difference(&du), duv, flipped(&difference(&flipped(&dv)))].map(|net| largest_norm(&net))
    }
}

/// A [`Surface`] at one place, m.
#[derive(Clone, Copy, Debug)]
pub struct Jet {
    /// The point.
    pub point: Point,
    /// The unit normal, upwards.
    pub normal: Point,
    /// By u.
    pub du: Point,
    /// By v.
    pub dv: Point,
    /// Twice by u.
    pub duu: Point,
    /// By u and v.
    pub duv: Point,
    /// Twice by v.
    pub dvv: Point,
}

/// A curve of constant u on a [`Surface`], with its derivative across.
pub struct Column {
    points: Vec<Point>,
    du: Vec<Point>,
}

impl Column {
    /// The point at v and the unit normal there, turned upwards.
    pub fn frame(&self, v: f64) -> (Point, Point) {
        let [point, dv, _] = curve(self.points.iter().copied(), v);
        let [du, ..] = curve(self.du.iter().copied(), v);
        (point, upward_normal(&du, &dv))
    }
}

fn upward_normal(du: &Point, dv: &Point) -> Point {
    let normal = du.cross(dv).try_normalize(0.0).unwrap_or_else(Point::z);
    if normal.z < 0.0 { -normal } else { normal }
}

/// Place `index` of `count` evenly over an interval.
fn evenly([from, to]: [f64; 2], index: usize, count: usize) -> f64 {
    let t = index as f64 / (count.max(2) - 1) as f64;
    from * (1.0 - t) + to * t
}

/// Scene files write rows along v; the net is indexed `[i][j]` with i along u.
fn transposed<T>(rows: &[Vec<T>], point: impl Fn(usize, usize, &T) -> Point) -> Vec<Vec<Point>> {
    let across = rows.first().map_or(0, Vec::len);
    let row =
        |i: usize| rows.iter().enumerate().filter_map(|(j, row)| Some(point(i, j, row.get(i)?))).collect();
    (0..across).map(row).collect()
}

/// Point and two derivatives of a Bezier curve by de Casteljau's corner cutting.
fn curve(control: impl Iterator<Item = Point>, t: f64) -> [Point; 3] {
    let mut points = [Point::zeros(); MAX_DEGREE + 1];
    let mut count = 0;
    for point in control.take(MAX_DEGREE + 1) {
        points[count] = point;
        count += 1;
    }
    let [mut first, mut second] = [Point::zeros(); 2];
    for left in (1..count).rev() {
        if left == 2 {
            second = (points[2] - points[1] * 2.0 + points[0]) * ((count - 1) * (count - 2)) as f64;
        } else if left == 1 {
            first = (points[1] - points[0]) * (count - 1) as f64;
        }
        for i in 0..left {
            points[i] = points[i] * (1.0 - t) + points[i + 1] * t;
        }
    }
    [points[0], first, second]
}

/// Net of the derivative in the first direction; a straight one has the net of a single zero.
fn difference(net: &[Vec<Point>]) -> Vec<Vec<Point>> {
    let degree = net.len() - 1;
    if degree == 0 {
        return vec![vec![Point::zeros(); net[0].len()]];
    }
    let pairs = net.windows(2);
    pairs.map(|pair| pair[0].iter().zip(&pair[1]).map(|(a, b)| (b - a) * degree as f64).collect()).collect()
}

fn flipped(net: &[Vec<Point>]) -> Vec<Vec<Point>> {
    (0..net[0].len()).map(|j| net.iter().map(|row| row[j]).collect()).collect()
}

/// Largest norm over the nets of all pieces.
fn largest_norm(net: &[Vec<Point>]) -> f64 {
    let strips = pieces(net);
    let norms = strips.iter().flat_map(|strip| pieces(&flipped(strip))).flatten().flatten().map(|p| p.norm());
    norms.fold(0.0, f64::max)
}

/// The net cut into [`BOUND_PIECES`] along its second index.
fn pieces(net: &[Vec<Point>]) -> Vec<Vec<Vec<Point>>> {
    let cut = |piece: usize| {
        let from = piece as f64 / BOUND_PIECES as f64;
        let to = (piece + 1) as f64 / BOUND_PIECES as f64;
        net.iter().map(|row| restricted(row, from, to)).collect()
    };
    (0..BOUND_PIECES).map(cut).collect()
}

/// Control points of a Bezier curve's part over `[from, to]`: blossom values of `from` and `to`.
fn restricted(points: &[Point], from: f64, to: f64) -> Vec<Point> {
    let mut points = points.to_vec();
    let degree = points.len() - 1;
    // Cut at `to` and keep the left part, then cut that at `from` and keep the right part.
    for level in 1..=degree {
        for i in (level..=degree).rev() {
            points[i] = points[i - 1] * (1.0 - to) + points[i] * to;
        }
    }
    let t = from / to;
    for level in 1..=degree {
        for i in 0..=degree - level {
            points[i] = points[i] * (1.0 - t) + points[i + 1] * t;
        }
    }
    points
}

/// The exact net of z = P(x, y) over a rectangle, of degree at least 1 each way.
fn polynomial_net(x_m: [f64; 2], y_m: [f64; 2], terms: &[Term]) -> Result<Vec<Vec<Point>>, NotAFloor> {
    let degree = |power: fn(&Term) -> u32| terms.iter().map(power).max().unwrap_or(0).max(1) as usize;
    let [p, q] = [degree(|t| t.px), degree(|t| t.py)];
    if p > MAX_DEGREE || q > MAX_DEGREE {
        return Err(NotAFloor("its degree is above 12"));
    }
    let mut net: Vec<Vec<Point>> = (0..=p)
        .map(|i| (0..=q).map(|j| Point::new(evenly(x_m, i, p + 1), evenly(y_m, j, q + 1), 0.0)).collect())
        .collect();
    for term in terms {
        let in_x = monomial(term.px as usize, p, x_m);
        let in_y = monomial(term.py as usize, q, y_m);
        for (row, a) in net.iter_mut().zip(&in_x) {
            for (point, b) in row.iter_mut().zip(&in_y) {
                point.z += term.c * a * b;
            }
        }
    }
    Ok(net)
}

/// Bernstein coefficients of `x^power` at degree `degree` over `[a, b]`.
///
/// The i-th is the blossom of the monomial with i arguments b and the rest a: the elementary symmetric
/// mean of order `power`.
fn monomial(power: usize, degree: usize, [a, b]: [f64; 2]) -> Vec<f64> {
    let blossom = |i: usize| {
        // Coefficients of prod (1 + x_k s): the elementary symmetric sums.
        let mut sums = [0.0; MAX_DEGREE + 1];
        sums[0] = 1.0;
        for k in 0..degree {
            let x = if k < i { b } else { a };
            for order in (1..=degree).rev() {
                sums[order] += x * sums[order - 1];
            }
        }
        sums[power] / choose(degree, power)
    };
    (0..=degree).map(blossom).collect()
}

fn choose(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn original() -> Surface {
        let mut rows = vec![vec![0.0; 11]; 11];
        rows[5][3] = -70.0;
        rows[5][7] = 40.0;
        Surface::of(&Floor::Grid { x_m: [-10.0, 10.0], y_m: [-10.0, 10.0], control_heights_m: rows }).unwrap()
    }

    #[test]
    fn the_original_floor_has_its_known_depth_and_height() {
        let surface = original();
        let heights = || (0..=400).map(|i| surface.point(f64::from(i) / 400.0, 0.5).z);
        assert!((heights().fold(f64::INFINITY, f64::min) + 4.5137).abs() < 1e-3);
        assert!((heights().fold(f64::NEG_INFINITY, f64::max) - 2.4970).abs() < 1e-3);
    }

    #[test]
    fn a_polynomial_floor_is_met_exactly_with_its_normal() {
        let terms = vec![
            Term { px: 2, py: 0, c: 0.1 },
            Term { px: 1, py: 3, c: -0.02 },
            Term { px: 0, py: 0, c: 1.0 },
        ];
        let surface = Surface::of(&Floor::Polynomial { x_m: [-3.0, 5.0], y_m: [1.0, 2.0], terms }).unwrap();
        for (u, v) in [(0.0, 0.0), (0.3, 0.8), (1.0, 1.0)] {
            let (point, normal) = surface.frame(u, v);
            let (x, y) = (-3.0 + 8.0 * u, 1.0 + v);
            let z = 0.1 * x * x - 0.02 * x * y * y * y + 1.0;
            assert!((point - Point::new(x, y, z)).norm() < 1e-12);
            let gradient = Point::new(-(0.2 * x - 0.02 * y * y * y), 0.06 * x * y * y, 1.0);
            assert!((normal - gradient.normalize()).norm() < 1e-12);
        }
    }

    #[test]
    fn derivatives_of_a_polynomial_floor_are_exact() {
        let terms = vec![Term { px: 2, py: 1, c: 0.3 }, Term { px: 0, py: 2, c: -0.2 }];
        let surface = Surface::of(&Floor::Polynomial { x_m: [-3.0, 5.0], y_m: [1.0, 3.0], terms }).unwrap();
        let (u, v) = (0.3, 0.8);
        let (x, y) = (-3.0 + 8.0 * u, 1.0 + 2.0 * v);
        let jet = surface.jet(u, v);
        let expected = [
            (jet.du, Point::new(8.0, 0.0, 8.0 * 0.6 * x * y)),
            (jet.dv, Point::new(0.0, 2.0, 2.0 * (0.3 * x * x - 0.4 * y))),
            (jet.duu, Point::new(0.0, 0.0, 64.0 * 0.6 * y)),
            (jet.duv, Point::new(0.0, 0.0, 16.0 * 0.6 * x)),
            (jet.dvv, Point::new(0.0, 0.0, 4.0 * -0.4)),
        ];
        for (found, expected) in expected {
            assert!((found - expected).norm() < 1e-11, "{found} {expected}");
        }
    }

    #[test]
    fn the_bound_of_second_derivatives_holds_and_is_tight() {
        let surface = original();
        let bounds = surface.second_derivative_bounds();
        let h = 1e-4;
        let mut seen: f64 = 0.0;
        for i in 1..200 {
            let u = f64::from(i) / 200.0;
            let second = surface.point(u + h, 0.5) - surface.point(u, 0.5) * 2.0 + surface.point(u - h, 0.5);
            seen = seen.max(second.norm() / (h * h));
        }
        assert!(seen <= bounds[0] * (1.0 + 1e-6) && bounds[0] < 1.1 * seen, "{seen} {bounds:?}");
    }

    #[test]
    fn a_plane_has_no_second_derivative() {
        let plane =
            Surface::of(&Floor::Polynomial { x_m: [0.0, 1.0], y_m: [0.0, 1.0], terms: vec![] }).unwrap();
        assert_eq!(plane.second_derivative_bounds(), [0.0; 3]);
    }

    #[test]
    fn a_ragged_net_is_refused() {
        let rows = vec![vec![0.0, 0.0], vec![0.0]];
        assert!(
            Surface::of(&Floor::Grid { x_m: [0.0, 1.0], y_m: [0.0, 1.0], control_heights_m: rows }).is_err()
        );
    }
}
