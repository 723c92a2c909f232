//! A tensor-product Bezier patch.

use super::jet::Jet;
use nalgebra::Vector3;

/// Control net of a tensor-product Bezier patch S(u, v) over the unit square.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierPatch {
    degree: [usize; 2],
    net: Vec<Vector3<f64>>,
}

/// Largest degree in either direction.
pub const MAX_DEGREE: usize = 12;

/// A parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// The first.
    U,
    /// The second.
    V,
}

impl BezierPatch {
    /// A patch of degree `degree = [p, q]` in u and v; `net[i * (q + 1) + j]` belongs to `B_i^p(u) B_j^q(v)`.
    /// None unless both degrees lie in 1 to [`MAX_DEGREE`], the length fits and every number is finite.
    pub fn new(degree: [usize; 2], net: Vec<Vector3<f64>>) -> Option<Self> {
        let fits = degree.iter().all(|d| (1..=MAX_DEGREE).contains(d))
            && net.len() == (degree[0] + 1) * (degree[1] + 1)
            && net.iter().all(|p| p.iter().all(|x| x.is_finite()));
        fits.then_some(Self { degree, net })
    }

    /// The patch z = h(x, y) over a rectangle whose control heights stand on a regular grid: `heights[j][i]`, row j
    /// along v (y, south to north), column i along u (x, west to east). None unless the rows are equally long, the
    /// degrees lie in 1 to [`MAX_DEGREE`] and every number is finite.
    pub fn from_heights(x: [f64; 2], y: [f64; 2], heights: &[Vec<f64>]) -> Option<Self> {
        let columns = heights.first()?.len();
        if heights.iter().any(|row| row.len() != columns) {
            return None;
        }
        let [p, q] = [columns.checked_sub(1)?, heights.len() - 1];
        let net = (0..=p)
            .flat_map(|i| (0..=q).map(move |j| (i, j)))
            .map(|(i, j)| Vector3::new(affine_ordinate(x, i, p), affine_ordinate(y, j, q), heights[j][i]))
            .collect();
        Self::new([p, q], net)
    }

    /// Degrees in u and v.
    pub const fn degree(&self) -> [usize; 2] {
        self.degree
    }

    /// The control point of `B_i^p(u) B_j^q(v)`.
    pub fn point(&self, i: usize, j: usize) -> Vector3<f64> {
        self.net[i * (self.degree[1] + 1) + j]
    }

    /// The control points; `net()[i * (q + 1) + j]` belongs to `B_i^p(u) B_j^q(v)`.
    pub fn net(&self) -> &[Vector3<f64>] {
        &self.net
    }

    /// S and its derivatives to second order at (u, v), by de Casteljau: the form whose error stays at a few ulp of
    /// the net for every degree. Slow; meant for checks and loading, not for stepping.
    pub fn jet(&self, u: f64, v: f64) -> Jet {
        let [p, q] = self.degree;
        let mut across = [[Vector3::zeros(); MAX_DEGREE + 1]; 3];
        for (i, row) in self.net.chunks_exact(q + 1).enumerate() {
            for (order, value) in curve_jet(row, v).into_iter().enumerate() {
                across[order][i] = value;
            }
        }
        let [point, du, duu] = curve_jet(&across[0][..=p], u);
        let [dv, duv, _] = curve_jet(&across[1][..=p], u);
        let [dvv, _, _] = curve_jet(&across[2][..=p], u);
        Jet { point, du, dv, duu, duv, dvv }
    }

    /// +1 where `S_u x S_v` points along `up` at the patch's middle, else -1. A floor keeps this sign everywhere,
    /// which [`certify`](super::certify::certify) proves.
    pub fn orientation(&self, up: &Vector3<f64>) -> f64 {
        let jet = self.jet(0.5, 0.5);
        if jet.du.cross(&jet.dv).dot(up) < 0.0 { -1.0 } else { 1.0 }
    }

    /// The net of dS/du or dS/dv, with its degrees (one of which may be 0).
    pub fn derivative_net(&self, parameter: Parameter) -> ([usize; 2], Vec<Vector3<f64>>) {
        let [p, q] = self.degree;
        match parameter {
            Parameter::U => {
                let step = |k: usize| (self.net[k + q + 1] - self.net[k]) * p as f64;
                ([p - 1, q], (0..p * (q + 1)).map(step).collect())
            }
            Parameter::V => {
                let step = |(i, j)| (self.point(i, j + 1) - self.point(i, j)) * q as f64;
                let places = (0..=p).flat_map(|i| (0..q).map(move |j| (i, j)));
                ([p, q - 1], places.map(step).collect())
            }
        }
    }

    /// The borders [x at u = 0, x at u = 1], [y at v = 0, y at v = 1] if the patch is a height field: x affine in u
    /// alone and y affine in v alone, both as exactly as f64 can write them. Borders may run backwards.
    pub fn rectangle(&self) -> Option<[[f64; 2]; 2]> {
        let [p, q] = self.degree;
        let x = [self.point(0, 0).x, self.point(p, 0).x];
        let y = [self.point(0, 0).y, self.point(0, q).y];
        let on_grid = |i, j| {
            let point = self.point(i, j);
            point.x == affine_ordinate(x, i, p) && point.y == affine_ordinate(y, j, q)
        };
        let regular = (0..=p).all(|i| (0..=q).all(|j| on_grid(i, j)));
        (regular && x[0] != x[1] && y[0] != y[1]).then_some([x, y])
    }

    /// Whether only z needs evaluating; see [`Self::rectangle`].
    pub fn is_height_field(&self) -> bool {
        self.rectangle().is_some()
    }
}

/// Ordinate k of n of the affine function with these end values. Written around the middle, so that a range that is
/// symmetric about 0 gives exactly symmetric ordinates.
pub(super) fn affine_ordinate(ends: [f64; 2], k: usize, n: usize) -> f64 {
    if k == 0 {
        return ends[0];
    }
    if k == n {
        return ends[1];
    }
    let middle = 0.5 * (ends[0] + ends[1]);
    let half = 0.5 * (ends[1] - ends[0]);
    middle + half * (2.0 * k as f64 - n as f64) / n as f64
}

/// Value, first and second derivative of a Bezier curve at `t`.
fn curve_jet(points: &[Vector3<f64>], t: f64) -> [Vector3<f64>; 3] {
    let degree = points.len() - 1;
    let mut work = [Vector3::zeros(); MAX_DEGREE + 1];
    work[..=degree].copy_from_slice(points);
    let mut jet = [Vector3::zeros(); 3];
    for remaining in (0..=degree).rev() {
        match remaining {
            2 => jet[2] = (work[2] - work[1] * 2.0 + work[0]) * (degree * (degree - 1)) as f64,
            1 => jet[1] = (work[1] - work[0]) * degree as f64,
            0 => jet[0] = work[0],
            _ => {}
        }
        for i in 0..remaining {
            work[i] = work[i] * (1.0 - t) + work[i + 1] * t;
        }
    }
    jet
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_patch() -> impl Strategy<Value = BezierPatch> {
        (1..=6_usize, 1..=6_usize).prop_flat_map(|(p, q)| {
            prop::collection::vec([-1.0..1.0, -1.0..1.0, -1.0..1.0_f64], (p + 1) * (q + 1)).prop_map(
                move |net| BezierPatch::new([p, q], net.into_iter().map(Vector3::from).collect()).unwrap(),
            )
        })
    }

    /// S by the definition, a sum over the net.
    fn by_definition(patch: &BezierPatch, u: f64, v: f64) -> Vector3<f64> {
        let [p, q] = patch.degree();
        let basis = |n: usize, k: usize, t: f64| {
            let choose = (0..k).fold(1.0, |c, m| c * (n - m) as f64 / (m + 1) as f64);
            let power = |x: f64, exponent: usize| (0..exponent).fold(1.0, |product, _| product * x);
            choose * power(t, k) * power(1.0 - t, n - k)
        };
        let mut sum = Vector3::zeros();
        for i in 0..=p {
            for j in 0..=q {
                sum += patch.point(i, j) * basis(p, i, u) * basis(q, j, v);
            }
        }
        sum
    }

    proptest! {
        #[test]
        fn a_jet_is_the_definition_and_its_difference_quotients(
            patch in any_patch(), u in 0.05..0.95_f64, v in 0.05..0.95_f64
        ) {
            let jet = patch.jet(u, v);
            let h = 1e-4;
            let at = |a, b| by_definition(&patch, u + a * h, v + b * h);
            prop_assert!((jet.point - at(0.0, 0.0)).norm() < 1e-13);
            prop_assert!((jet.du - (at(1.0, 0.0) - at(-1.0, 0.0)) / (2.0 * h)).norm() < 1e-4);
            prop_assert!((jet.dv - (at(0.0, 1.0) - at(0.0, -1.0)) / (2.0 * h)).norm() < 1e-4);
            let mixed = at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0);
            prop_assert!((jet.duv - mixed / (4.0 * h * h)).norm() < 1e-3);
            let second = |a, b| (at(a, b) - 2.0 * at(0.0, 0.0) + at(-a, -b)) / (h * h);
            prop_assert!((jet.duu - second(1.0, 0.0)).norm() < 1e-3);
            prop_assert!((jet.dvv - second(0.0, 1.0)).norm() < 1e-3);
        }

        #[test]
        fn derivative_nets_begin_and_end_with_the_corner_derivatives(patch in any_patch()) {
            let (_, du) = patch.derivative_net(Parameter::U);
            let (_, dv) = patch.derivative_net(Parameter::V);
            prop_assert!((du[0] - patch.jet(0.0, 0.0).du).norm() < 1e-13);
            prop_assert!((du[du.len() - 1] - patch.jet(1.0, 1.0).du).norm() < 1e-13);
            prop_assert!((dv[0] - patch.jet(0.0, 0.0).dv).norm() < 1e-13);
            prop_assert!((dv[dv.len() - 1] - patch.jet(1.0, 1.0).dv).norm() < 1e-13);
        }
    }

    #[test]
    fn a_net_that_does_not_fit_its_degree_is_refused() {
        let net = vec![Vector3::zeros(); 4];
        assert!(BezierPatch::new([1, 1], net.clone()).is_some());
        assert!(BezierPatch::new([1, 2], net.clone()).is_none());
        assert!(BezierPatch::new([0, 3], net).is_none());
        assert!(BezierPatch::new([1, 1], vec![Vector3::new(f64::NAN, 0.0, 0.0); 4]).is_none());
        assert!(BezierPatch::from_heights([0.0, 1.0], [0.0, 1.0], &[vec![0.0, 0.0], vec![0.0]]).is_none());
        assert!(BezierPatch::from_heights([0.0, 1.0], [0.0, 1.0], &[vec![], vec![]]).is_none());
        assert!(BezierPatch::from_heights([0.0, 1.0], [0.0, 1.0], &[]).is_none());
    }

    #[test]
    fn heights_run_with_u_along_x_and_v_along_y() {
        let patch =
            BezierPatch::from_heights([-1.0, 3.0], [5.0, 6.0], &[vec![0.0, 1.0], vec![2.0, 4.0]]).unwrap();
        assert_eq!(patch.jet(1.0, 0.0).point, Vector3::new(3.0, 5.0, 1.0));
        assert_eq!(patch.jet(0.0, 1.0).point, Vector3::new(-1.0, 6.0, 2.0));
        assert_eq!(patch.rectangle(), Some([[-1.0, 3.0], [5.0, 6.0]]));
    }

    #[test]
    fn a_mirrored_height_field_is_one_whose_normal_turns() {
        let heights = vec![vec![0.1, 0.7, -0.3], vec![0.5, 0.2, 0.9]];
        let patch = BezierPatch::from_heights([-1.0, 2.0], [0.0, 1.0], &heights).unwrap();
        let net = patch.net().iter().map(|p| Vector3::new(-p.x, p.y, p.z)).collect();
        let mirrored = BezierPatch::new(patch.degree(), net).unwrap();
        assert!(mirrored.is_height_field());
        let up = Vector3::z();
        assert_eq!([patch.orientation(&up), mirrored.orientation(&up)], [1.0, -1.0]);
        let n = patch.jet(0.3, 0.6).normal(1.0).unwrap();
        let m = mirrored.jet(0.3, 0.6).normal(-1.0).unwrap();
        assert_eq!(m, Vector3::new(-n.x, n.y, n.z));
    }

    #[test]
    fn a_moved_column_is_not_a_height_field() {
        let patch = BezierPatch::from_heights([-1.0, 1.0], [-1.0, 1.0], &vec![vec![0.0; 4]; 3]).unwrap();
        let mut net = patch.net().to_vec();
        net[5].x += 1e-15;
        assert!(!BezierPatch::new(patch.degree(), net).unwrap().is_height_field());
    }
}
