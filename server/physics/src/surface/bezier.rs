//! A tensor-product Bezier patch.

use nalgebra::Vector3;

/// Control net of a tensor-product Bezier patch S(u, v) over the unit square.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierPatch {
    degree: [usize; 2],
    net: Vec<Vector3<f64>>,
}

/// Largest degree in either direction.
pub const MAX_DEGREE: usize = 12;

impl BezierPatch {
    /// A patch of degree `degree = [p, q]` in u and v; `net[i * (q + 1) + j]` belongs to `B_i^p(u) B_j^q(v)`.
    /// None unless both degrees lie in 1 to [`MAX_DEGREE`], the length fits and every number is finite.
    pub fn new(degree: [usize; 2], net: Vec<Vector3<f64>>) -> Option<Self> {
        let fits = degree.iter().all(|d| (1..=MAX_DEGREE).contains(d))
            && net.len() == (degree[0] + 1) * (degree[1] + 1)
            && net.iter().all(|p| p.iter().all(|x| x.is_finite()));
        fits.then_some(Self { degree, net })
    }

    /// Degrees in u and v.
    pub const fn degree(&self) -> [usize; 2] {
        self.degree
    }

    /// The control point of `B_i^p(u) B_j^q(v)`.
    pub fn point(&self, i: usize, j: usize) -> Vector3<f64> {
        self.net[i * (self.degree[1] + 1) + j]
    }
}
