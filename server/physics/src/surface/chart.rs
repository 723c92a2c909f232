//! Fast evaluation of the floor and its first two derivatives: one kernel for each kind of floor.
//!
//! A chart's coordinates q = (q0, q1) are centred: for a height field the metres x - xmid, y - ymid, for a
//! general net u - 1/2, v - 1/2. Centring keeps the exact zeros of a symmetric floor, and its mirror image
//! bit for bit: a sum runs over pairs of terms that the mirror exchanges.

use super::bezier::{BezierPatch, MAX_DEGREE};
use crate::scene::Floor;
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// The floor at one place: what the equations of motion need of it.
pub trait Frame {
    /// The point S, m.
    fn point(&self) -> V3;
    /// Unit normal on the balls' side.
    fn normal(&self) -> V3;
    /// E, F, G of the first fundamental form.
    fn first(&self) -> [f64; 3];
    /// L, M, N of the second: positive where the floor curves towards the ball.
    fn second(&self) -> [f64; 3];
    /// 1 / (EG - F^2).
    fn inverse_area_squared(&self) -> f64;
    /// (`S_u`.w, `S_v`.w).
    fn along(&self, w: &V3) -> [f64; 2];
    /// a `S_u` + b `S_v`.
    fn combine(&self, a: f64, b: f64) -> V3;
}

/// A floor in one chart.
pub trait Chart {
    /// What it gives at a place.
    type Frame: Frame;
    /// The floor at q; extrapolates the polynomial outside the patch.
    fn frame(&self, q: [f64; 2]) -> Self::Frame;
}

/// Which polynomials a kernel's coefficients belong to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Basis {
    /// Powers of q: exact for a floor given as a polynomial.
    Power,
    /// Bernstein polynomials of u = 1/2 + q/width: stable for any net.
    Bernstein,
}

/// The one-dimensional basis with two derivatives, `[order][i]`, zero beyond the degree.
type Jets<const N: usize> = [[f64; N]; 3];

#[derive(Clone, Debug)]
struct Axis {
    basis: Basis,
    degree: usize,
    inverse_width: f64,
    /// Binomials of degree p, p - 1, p - 2.
    binomial: [[f64; MAX_DEGREE + 1]; 3],
}

impl Axis {
    fn new(basis: Basis, degree: usize, width: f64) -> Self {
        let mut binomial = [[0.0; MAX_DEGREE + 1]; 3];
        for (k, row) in binomial.iter_mut().enumerate() {
            let n = degree.saturating_sub(k);
            let mut c = 1.0;
            for (i, entry) in row.iter_mut().enumerate().take(n + 1) {
                *entry = c;
                c = c * (n - i) as f64 / (i + 1) as f64;
            }
        }
        Self { basis, degree, inverse_width: 1.0 / width, binomial }
    }

    #[inline]
    fn jets<const N: usize>(&self, q: f64) -> Jets<N> {
        let mut out = [[0.0; N]; 3];
        let p = self.degree.min(N - 1);
        if self.basis == Basis::Power {
            let mut power = 1.0;
            for i in 0..=p {
                out[0][i] = power;
                if i < p {
                    out[1][i + 1] = (i + 1) as f64 * power;
                }
                if i + 2 <= p {
                    out[2][i + 2] = ((i + 1) * (i + 2)) as f64 * power;
                }
                power *= q;
            }
            return out;
        }
        let s = q * self.inverse_width;
        let (u, w) = (0.5 + s, 0.5 - s);
        let (mut pu, mut pw) = ([1.0; N], [1.0; N]);
        for i in 1..=p {
            pu[i] = pu[i - 1] * u;
            pw[i] = pw[i - 1] * w;
        }
        let [b0, b1, b2] = &self.binomial;
        let d1 = p as f64 * self.inverse_width;
        let d2 = d1 * p.saturating_sub(1) as f64 * self.inverse_width;
        // Basis values of the two lower degrees, shifted by one and two so that differences need no ifs.
        let mut low1 = [0.0; 14];
        let mut low2 = [0.0; 15];
        for i in 0..p {
            low1[i + 1] = b1[i] * (pu[i] * pw[p - 1 - i]);
        }
        if p >= 2 {
            for i in 0..p - 1 {
                low2[i + 2] = b2[i] * (pu[i] * pw[p - 2 - i]);
            }
        }
        for i in 0..=p {
            out[0][i] = b0[i] * (pu[i] * pw[p - i]);
            out[1][i] = d1 * (low1[i] - low1[i + 1]);
            out[2][i] = d2 * ((low2[i] + low2[i + 2]) - 2.0 * low2[i + 1]);
        }
        out
    }
}

/// Sum over i of `a[i] b[i]` for i up to `degree`, in mirror pairs.
#[inline]
fn paired_dot<const N: usize>(a: &[f64; N], b: &[f64; N], degree: usize) -> f64 {
    let mut sum = 0.0;
    for i in 0..N.div_ceil(2) {
        if i > degree / 2 {
            break;
        }
        let k = (degree - i).min(N - 1);
        sum += if i == k { a[i] * b[i] } else { a[i] * b[i] + a[k] * b[k] };
    }
    sum
}

/// Value and derivatives `[f, f_0, f_1, f_00, f_01, f_11]` of sum c[i][j] `X_i` `Y_j`.
#[inline]
fn contract<const N: usize>(c: &[[f64; N]; N], x: &Jets<N>, y: &Jets<N>, degree: [usize; 2]) -> [f64; 6] {
    let mut rows = [[0.0; N]; 3];
    for i in 0..N.div_ceil(2) {
        if i > degree[0] / 2 {
            break;
        }
        let k = (degree[0] - i).min(N - 1);
        if i == k {
            for (row, xs) in rows.iter_mut().zip(x) {
                for j in 0..N {
                    row[j] += xs[i] * c[i][j];
                }
            }
        } else {
            for (row, xs) in rows.iter_mut().zip(x) {
                for j in 0..N {
                    row[j] += xs[i] * c[i][j] + xs[k] * c[k][j];
                }
            }
        }
    }
    let dot = |a: usize, b: usize| paired_dot(&rows[a], &y[b], degree[1]);
    [dot(0, 0), dot(1, 0), dot(0, 1), dot(2, 0), dot(1, 1), dot(0, 2)]
}

// ---------------------------------------------------------------------------------------------------------

/// A height field z(x, y): only z is evaluated.
#[derive(Clone, Debug)]
pub struct HeightChart<const N: usize> {
    middle: [f64; 2],
    axes: [Axis; 2],
    coefficients: Box<[[f64; N]; N]>,
}

/// A height field at one place; the tangents are (1, 0, `z_x`) and (0, 1, `z_y`).
#[derive(Clone, Copy, Debug)]
pub struct HeightFrame {
    point: V3,
    slope: [f64; 2],
    second: [f64; 3],
    /// 1 / sqrt(1 + `z_x`^2 + `z_y`^2).
    cosine: f64,
}

impl<const N: usize> Chart for HeightChart<N> {
    type Frame = HeightFrame;

    #[inline]
    fn frame(&self, q: [f64; 2]) -> HeightFrame {
        let degree = [self.axes[0].degree, self.axes[1].degree];
        let [z, zx, zy, zxx, zxy, zyy] =
            contract(&self.coefficients, &self.axes[0].jets(q[0]), &self.axes[1].jets(q[1]), degree);
        let cosine = 1.0 / (1.0 + (zx * zx + zy * zy)).sqrt();
        HeightFrame {
            point: V3::new(self.middle[0] + q[0], self.middle[1] + q[1], z),
            slope: [zx, zy],
            second: [zxx * cosine, zxy * cosine, zyy * cosine],
            cosine,
        }
    }
}

impl Frame for HeightFrame {
    #[inline]
    fn point(&self) -> V3 {
        self.point
    }
    #[inline]
    fn normal(&self) -> V3 {
        V3::new(-self.slope[0] * self.cosine, -self.slope[1] * self.cosine, self.cosine)
    }
    #[inline]
    fn first(&self) -> [f64; 3] {
        let [a, b] = self.slope;
        [1.0 + a * a, a * b, 1.0 + b * b]
    }
    #[inline]
    fn second(&self) -> [f64; 3] {
        self.second
    }
    #[inline]
    fn inverse_area_squared(&self) -> f64 {
        self.cosine * self.cosine
    }
    #[inline]
    fn along(&self, w: &V3) -> [f64; 2] {
        [w.x + self.slope[0] * w.z, w.y + self.slope[1] * w.z]
    }
    #[inline]
    fn combine(&self, a: f64, b: f64) -> V3 {
        V3::new(a, b, a * self.slope[0] + b * self.slope[1])
    }
}

// ---------------------------------------------------------------------------------------------------------

/// A general net: three components.
#[derive(Clone, Debug)]
pub struct NetChart<const N: usize> {
    axes: [Axis; 2],
    coefficients: Box<[[[f64; N]; N]; 3]>,
    /// +1 where `S_u` x `S_v` points to the balls' side, else -1.
    side: f64,
}

/// A general net at one place.
#[derive(Clone, Copy, Debug)]
pub struct NetFrame {
    point: V3,
    tangents: [V3; 2],
    normal: V3,
    second: [f64; 3],
    inverse_area_squared: f64,
}

impl<const N: usize> Chart for NetChart<N> {
    type Frame = NetFrame;

    #[inline]
    fn frame(&self, q: [f64; 2]) -> NetFrame {
        let degree = [self.axes[0].degree, self.axes[1].degree];
        let (x, y) = (self.axes[0].jets(q[0]), self.axes[1].jets(q[1]));
        let [cx, cy, cz] = &*self.coefficients;
        let (a, b, c) =
            (contract(cx, &x, &y, degree), contract(cy, &x, &y, degree), contract(cz, &x, &y, degree));
        let take = |i: usize| V3::new(a[i], b[i], c[i]);
        let (su, sv) = (take(1), take(2));
        let cross = su.cross(&sv);
        let inverse_area_squared = 1.0 / cross.norm_squared();
        let normal = cross * (self.side * inverse_area_squared.sqrt());
        NetFrame {
            point: take(0),
            tangents: [su, sv],
            normal,
            second: [take(3).dot(&normal), take(4).dot(&normal), take(5).dot(&normal)],
            inverse_area_squared,
        }
    }
}

impl Frame for NetFrame {
    #[inline]
    fn point(&self) -> V3 {
        self.point
    }
    #[inline]
    fn normal(&self) -> V3 {
        self.normal
    }
    #[inline]
    fn first(&self) -> [f64; 3] {
        let [su, sv] = &self.tangents;
        [su.norm_squared(), su.dot(sv), sv.norm_squared()]
    }
    #[inline]
    fn second(&self) -> [f64; 3] {
        self.second
    }
    #[inline]
    fn inverse_area_squared(&self) -> f64 {
        self.inverse_area_squared
    }
    #[inline]
    fn along(&self, w: &V3) -> [f64; 2] {
        [self.tangents[0].dot(w), self.tangents[1].dot(w)]
    }
    #[inline]
    fn combine(&self, a: f64, b: f64) -> V3 {
        self.tangents[0] * a + self.tangents[1] * b
    }
}

// ---------------------------------------------------------------------------------------------------------

/// A plane z = z0 + slope . q: nothing to evaluate, nothing to integrate.
#[derive(Clone, Copy, Debug)]
pub struct FlatChart {
    middle: V3,
    slope: [f64; 2],
    cosine: f64,
}

impl Chart for FlatChart {
    type Frame = HeightFrame;

    #[inline]
    fn frame(&self, q: [f64; 2]) -> HeightFrame {
        let rise = self.slope[0] * q[0] + self.slope[1] * q[1];
        HeightFrame {
            point: self.middle + V3::new(q[0], q[1], rise),
            slope: self.slope,
            second: [0.0; 3],
            cosine: self.cosine,
        }
    }
}

// ---------------------------------------------------------------------------------------------------------

/// A floor of total degree 2: bowls, troughs, saddles. Its second derivatives are constants.
#[derive(Clone, Copy, Debug)]
pub struct QuadricChart {
    middle: V3,
    slope: [f64; 2],
    /// `z_xx`, `z_xy`, `z_yy`.
    curve: [f64; 3],
}

impl Chart for QuadricChart {
    type Frame = HeightFrame;

    #[inline]
    fn frame(&self, q: [f64; 2]) -> HeightFrame {
        let [a, b, c] = self.curve;
        let [sx, sy] = self.slope;
        let (bend_x, bend_y) = (a * q[0] + b * q[1], b * q[0] + c * q[1]);
        let (zx, zy) = (sx + bend_x, sy + bend_y);
        let rise = (sx + 0.5 * bend_x) * q[0] + (sy + 0.5 * bend_y) * q[1];
        let cosine = 1.0 / (1.0 + (zx * zx + zy * zy)).sqrt();
        HeightFrame {
            point: self.middle + V3::new(q[0], q[1], rise),
            slope: [zx, zy],
            second: [a * cosine, b * cosine, c * cosine],
            cosine,
        }
    }
}

// ---------------------------------------------------------------------------------------------------------

/// The kernel of one floor, in the smallest size that holds it.
#[derive(Clone, Debug)]
pub enum Kernel {
    /// A plane.
    Flat(FlatChart),
    /// A height field of total degree 2.
    Quadric(QuadricChart),
    /// A height field of degree up to 2, 3, 6, 10, 12.
    Height2(HeightChart<3>),
    /// See `Height2`.
    Height3(HeightChart<4>),
    /// See `Height2`.
    Height6(HeightChart<7>),
    /// See `Height2`.
    Height10(HeightChart<11>),
    /// See `Height2`.
    Height12(HeightChart<13>),
    /// A general net of degree up to 3, 12.
    Net3(NetChart<4>),
    /// See `Net3`.
    Net12(NetChart<13>),
}

/// Runs an expression with `$chart` bound to the kernel's own type: the choice is made once a call.
macro_rules! with_chart {
    ($kernel:expr, $chart:ident => $body:expr) => {
        match $kernel {
            $crate::surface::chart::Kernel::Flat($chart) => $body,
            $crate::surface::chart::Kernel::Quadric($chart) => $body,
            $crate::surface::chart::Kernel::Height2($chart) => $body,
            $crate::surface::chart::Kernel::Height3($chart) => $body,
            $crate::surface::chart::Kernel::Height6($chart) => $body,
            $crate::surface::chart::Kernel::Height10($chart) => $body,
            $crate::surface::chart::Kernel::Height12($chart) => $body,
            $crate::surface::chart::Kernel::Net3($chart) => $body,
            $crate::surface::chart::Kernel::Net12($chart) => $body,
        }
    };
}
pub(crate) use with_chart;

/// The floor as the engine evaluates it: a kernel, and how its coordinates belong to (u, v).
#[derive(Clone, Debug)]
pub struct Surface {
    /// The kernel.
    pub kernel: Kernel,
    /// Chart coordinates per unit of u and v; of either sign.
    pub width: [f64; 2],
}

impl Surface {
    /// The fastest exact evaluation of `floor`; `patch` is its net and `side` the sign of its normal.
    pub fn new(floor: &Floor, patch: &BezierPatch, side: f64) -> Self {
        match floor {
            Floor::Polynomial { x, y, terms } => Self::polynomial(*x, *y, terms),
            Floor::Bezier(_) if patch.is_height_field() => Self::heights(patch),
            Floor::Bezier(_) => Self::net(patch, side),
        }
    }

    /// (u, v) of chart coordinates.
    pub fn uv(&self, q: [f64; 2]) -> [f64; 2] {
        [0.5 + q[0] / self.width[0], 0.5 + q[1] / self.width[1]]
    }

    /// Chart coordinates of (u, v).
    pub fn chart(&self, uv: [f64; 2]) -> [f64; 2] {
        [(uv[0] - 0.5) * self.width[0], (uv[1] - 0.5) * self.width[1]]
    }

    /// Whether the floor is a plane.
    pub const fn is_flat(&self) -> bool {
        matches!(self.kernel, Kernel::Flat(_))
    }

    fn polynomial(x: [f64; 2], y: [f64; 2], terms: &[Vec<f64>]) -> Self {
        let middle = [0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])];
        let width = [x[1] - x[0], y[1] - y[0]];
        let shifted = shift(terms, middle);
        let degree = [0, 1].map(|axis| {
            let mut highest = 0;
            for (i, row) in shifted.iter().enumerate() {
                for (j, c) in row.iter().enumerate() {
                    if *c != 0.0 {
                        highest = highest.max([i, j][axis]);
                    }
                }
            }
            highest
        });
        let at = |i: usize, j: usize| shifted.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0);
        if degree[0].max(degree[1]) <= 1 && at(1, 1) == 0.0 {
            return Self { kernel: Self::flat(middle, at(0, 0), [at(1, 0), at(0, 1)]), width };
        }
        let quadric = (0..=degree[0]).all(|i| (0..=degree[1]).all(|j| i + j <= 2 || at(i, j) == 0.0));
        if quadric {
            let middle = V3::new(middle[0], middle[1], at(0, 0));
            let curve = [2.0 * at(2, 0), at(1, 1), 2.0 * at(0, 2)];
            let kernel = Kernel::Quadric(QuadricChart { middle, slope: [at(1, 0), at(0, 1)], curve });
            return Self { kernel, width };
        }
        let axes =
            [Axis::new(Basis::Power, degree[0], width[0]), Axis::new(Basis::Power, degree[1], width[1])];
        Self { kernel: height_kernel(middle, axes, at), width }
    }

    fn heights(patch: &BezierPatch) -> Self {
        let [p, q] = patch.degree();
        let (low, high) = (patch.point(0, 0), patch.point(p, q));
        let middle = [0.5 * (low.x + high.x), 0.5 * (low.y + high.y)];
        let width = [high.x - low.x, high.y - low.y];
        if (0..=p).all(|i| (0..=q).all(|j| patch.point(i, j).z == low.z)) {
            return Self { kernel: Self::flat(middle, low.z, [0.0; 2]), width };
        }
        let axes = [Axis::new(Basis::Bernstein, p, width[0]), Axis::new(Basis::Bernstein, q, width[1])];
        let at = |i: usize, j: usize| if i <= p && j <= q { patch.point(i, j).z } else { 0.0 };
        Self { kernel: height_kernel(middle, axes, at), width }
    }

    fn net(patch: &BezierPatch, side: f64) -> Self {
        let [p, q] = patch.degree();
        let axes = [Axis::new(Basis::Bernstein, p, 1.0), Axis::new(Basis::Bernstein, q, 1.0)];
        let kernel = if p.max(q) <= 3 {
            Kernel::Net3(net_chart(patch, axes, side))
        } else {
            Kernel::Net12(net_chart(patch, axes, side))
        };
        Self { kernel, width: [1.0; 2] }
    }

    fn flat(middle: [f64; 2], height: f64, slope: [f64; 2]) -> Kernel {
        let cosine = 1.0 / (1.0 + (slope[0] * slope[0] + slope[1] * slope[1])).sqrt();
        Kernel::Flat(FlatChart { middle: V3::new(middle[0], middle[1], height), slope, cosine })
    }
}

fn net_chart<const N: usize>(patch: &BezierPatch, axes: [Axis; 2], side: f64) -> NetChart<N> {
    let [p, q] = patch.degree();
    let mut coefficients = Box::new([[[0.0; N]; N]; 3]);
    for i in 0..=p {
        for j in 0..=q {
            for axis in 0..3 {
                coefficients[axis][i][j] = patch.point(i, j)[axis];
            }
        }
    }
    NetChart { axes, coefficients, side }
}

fn height_kernel(middle: [f64; 2], axes: [Axis; 2], at: impl Fn(usize, usize) -> f64) -> Kernel {
    fn chart<const N: usize>(
        middle: [f64; 2],
        axes: [Axis; 2],
        at: impl Fn(usize, usize) -> f64,
    ) -> HeightChart<N> {
        let mut coefficients = Box::new([[0.0; N]; N]);
        for (i, row) in coefficients.iter_mut().enumerate() {
            for (j, c) in row.iter_mut().enumerate() {
                *c = at(i, j);
            }
        }
        HeightChart { middle, axes, coefficients }
    }
    match axes[0].degree.max(axes[1].degree) {
        0..=2 => Kernel::Height2(chart(middle, axes, at)),
        3 => Kernel::Height3(chart(middle, axes, at)),
        4..=6 => Kernel::Height6(chart(middle, axes, at)),
        7..=10 => Kernel::Height10(chart(middle, axes, at)),
        _ => Kernel::Height12(chart(middle, axes, at)),
    }
}

/// Coefficients of P(x + middle0, y + middle1); the same numbers when the middle is the origin.
fn shift(terms: &[Vec<f64>], middle: [f64; 2]) -> Vec<Vec<f64>> {
    let rows = terms.len();
    let columns = terms.iter().map(Vec::len).max().unwrap_or(0);
    let mut c: Vec<Vec<f64>> = terms
        .iter()
        .map(|row| row.iter().copied().chain(std::iter::repeat(0.0)).take(columns).collect())
        .collect();
    // Repeated synthetic division, first in x for every column, then in y for every row.
    for k in 0..rows {
        for i in (k..rows.saturating_sub(1)).rev() {
            let (low, high) = c.split_at_mut(i + 1);
            for (a, b) in low[i].iter_mut().zip(&high[0]) {
                *a += middle[0] * b;
            }
        }
    }
    for row in &mut c {
        for k in 0..columns {
            for j in (k..columns.saturating_sub(1)).rev() {
                row[j] += middle[1] * row[j + 1];
            }
        }
    }
    c
}
