//! The steepest slope and the largest curvature, over single places.

use super::search::{Maximum, Part, maximise};
use crate::surface::affine::{Affine, cross, dot};
use crate::surface::derivative_nets::{DerivativeNets, Derivatives, Rectangle};
use crate::tolerance::{BRACKET_BOXES_MAX, BRACKET_WIDTH};
use nalgebra::Vector3;

/// What is known of a function on a box.
#[derive(Clone, Copy, Debug)]
struct Bound {
    /// It is nowhere above.
    upper: f64,
    /// On a box that is a point: it is not below.
    lower: f64,
    /// The corner at which it is probably largest.
    corner: [f64; 2],
}

impl Bound {
    const UNKNOWN: Self = Self { upper: f64::INFINITY, lower: f64::NEG_INFINITY, corner: [-1.0; 2] };
}

/// Bracket of the largest -n . up, the steepest slope: below 0 where every normal points up.
pub fn steepest(nets: &DerivativeNets, orientation: f64, up: &Vector3<f64>) -> Maximum<Rectangle, [f64; 2]> {
    let up: [Affine; 3] = std::array::from_fn(|k| Affine::number(up[k], 0.0));
    let cosine = |d: &Derivatives<Affine>| {
        let Some(normal) = unit_normal(&d.u, &d.v) else { return Bound::UNKNOWN };
        let against = dot(&normal, &up).scaled(-orientation);
        let [lower, upper] = against.range();
        Bound { upper, lower, corner: steepest_corner(&CORNERS, |s| against.at(s)) }
    };
    over_patch(nets, cosine, |lower, upper| {
        // Once some slope is proved vertical nothing more is asked.
        lower >= 0.0 || (upper < 0.0 && upper - lower <= BRACKET_WIDTH * lower.abs())
    })
}

/// Bracket of the largest principal curvature towards one side (+1 or -1) of `S_u x S_v`, 1/m, to within `flat`.
pub fn largest_curvature(nets: &DerivativeNets, side: f64, flat: f64) -> Maximum<Rectangle, [f64; 2]> {
    let bound = |d: &Derivatives<Affine>| {
        let shape = unit_normal(&d.u, &d.v).and_then(|n| {
            let normal = n.map(|component| component.scaled(side));
            ShapeOperator::new([&d.u, &d.v], [&d.uu, &d.uv, &d.vv], &normal)
        });
        shape.map_or(Bound::UNKNOWN, |shape| {
            let (upper, corner) = shape.largest(&CORNERS);
            Bound { upper, lower: shape.least(), corner }
        })
    };
    over_patch(nets, bound, |lower, upper| {
        upper < f64::INFINITY && upper - lower.max(0.0) <= (BRACKET_WIDTH * upper).max(flat)
    })
}

/// `S_u x S_v / |S_u x S_v|`; None where the chart may be singular.
pub fn unit_normal(du: &[Affine; 3], dv: &[Affine; 3]) -> Option<[Affine; 3]> {
    let normal = cross(du, dv);
    let inverse = dot(&normal, &normal).sqrt()?.recip()?;
    Some(normal.map(|component| component * inverse))
}

/// The corners of a box.
pub const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];

/// The corner where a function is largest.
pub fn steepest_corner<const N: usize>(corners: &[[f64; N]], value: impl Fn([f64; N]) -> f64) -> [f64; N] {
    corners.iter().copied().max_by(|a, b| value(*a).total_cmp(&value(*b))).unwrap_or([-1.0; N])
}

/// In the orthonormal frame that begins with `S_u` the shape operator is the symmetric matrix [a b; b d] with, for
/// J = |`S_u x S_v`| and f = F/E: a = L/E, b = (M - f L)/J, d = (N - 2 f M + f^2 L) E/J^2.
pub struct ShapeOperator<const N: usize>([Affine<N>; 3]);

impl<const N: usize> ShapeOperator<N> {
    /// From `S_u`, `S_v`, from `S_uu`, `S_uv`, `S_vv` and from the unit normal; None where the chart may be singular.
    pub fn new(
        first: [&[Affine<N>; 3]; 2],
        second: [&[Affine<N>; 3]; 3],
        normal: &[Affine<N>; 3],
    ) -> Option<Self> {
        let area = cross(first[0], first[1]);
        let e = dot(first[0], first[0]);
        let inverse_e = e.recip()?;
        let inverse_j = dot(&area, &area).sqrt()?.recip()?;
        let f = dot(first[0], first[1]) * inverse_e;
        let [l, m, n] = second.map(|second| dot(second, normal));
        let sheared = m - f * l;
        Some(Self([
            l * inverse_e,
            sheared * inverse_j,
            (n - f * (m + sheared)) * (e * inverse_j) * inverse_j,
        ]))
    }

    /// Bound of its larger eigenvalue, the corner where it is probably largest, and its affine part there. The larger
    /// eigenvalue is convex in the matrix, so its affine part is largest at a corner; the rest moves it by no more
    /// than the norm of the matrix of radii. It also rises with a, d and |b|: what is far below 0 does no harm.
    pub fn largest(&self, corners: &[[f64; N]]) -> (f64, [f64; N]) {
        let at = |corner| larger_eigenvalue(self.0.map(|entry| entry.at(corner)));
        let corner = steepest_corner(corners, at);
        let by_norm = at(corner) + larger_eigenvalue(self.0.map(|entry| entry.radius));
        let [a, b, d] = self.0.map(|entry| entry.range());
        let by_entry = larger_eigenvalue([a[1], b[1].max(-b[0]), d[1]]);
        let upper = by_norm.min(by_entry) + self.rounding(corner);
        (if upper.is_finite() { upper } else { f64::INFINITY }, corner)
    }

    fn rounding(&self, corner: [f64; N]) -> f64 {
        let size = |entry: &Affine<N>| entry.center.abs() + entry.at(corner).abs();
        1e-14 * self.0.iter().map(size).sum::<f64>()
    }
}

impl ShapeOperator<2> {
    /// On a box that is a point: the larger eigenvalue is not below.
    fn least(&self) -> f64 {
        let middle = [0.0; 2];
        let value = larger_eigenvalue(self.0.map(|entry| entry.center));
        let radius = larger_eigenvalue(self.0.map(|entry| entry.radius));
        let lower = value - radius - self.rounding(middle);
        if lower.is_finite() { lower } else { f64::NEG_INFINITY }
    }
}

fn larger_eigenvalue([a, b, d]: [f64; 3]) -> f64 {
    let half = 0.5 * (a - d);
    0.5 * (a + d) + (half * half + b * b).sqrt()
}

fn over_patch(
    nets: &DerivativeNets,
    bound: impl Fn(&Derivatives<Affine>) -> Bound,
    enough: impl Fn(f64, f64) -> bool,
) -> Maximum<Rectangle, [f64; 2]> {
    let split = |place: &Rectangle, _| {
        let halves = nets.halves(place)?;
        let parts = halves.into_iter().map(|(place, derivatives)| {
            let here = bound(&derivatives.enclosures());
            let sample = bound(&derivatives.corner(here.corner));
            Part { place, upper: here.upper, sample: Some((sample.lower, place.corner(here.corner))) }
        });
        Some(parts.collect())
    };
    maximise([Rectangle::WHOLE], f64::NEG_INFINITY, BRACKET_BOXES_MAX, split, enough)
}
