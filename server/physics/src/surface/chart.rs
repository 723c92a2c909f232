//! Fast evaluation of the floor and its first two derivatives: one kernel for each kind of floor.
//!
//! A chart's coordinates q = (q0, q1) are centred: for a height field the metres x - xmid, y - ymid, for a
//! general net u - 1/2, v - 1/2. Centring keeps the exact zeros of a symmetric floor, and its mirror image
//! bit for bit: see `basis`.

use super::basis::{Axis, Basis, POWER_DEGREE_MAX, centred_powers};
use super::bezier::BezierPatch;
pub use super::height::FlatChart;
use super::height::{HeightChart, PowerChart, QuadricChart};
use super::net::{NetChart, PowerNet};
use crate::number::{Number, Triple};
use crate::scene::Floor;

/// The floor at one place: what the equations of motion need of it.
pub trait Frame<T> {
    /// The point S, m.
    fn point(&self) -> Triple<T>;
    /// Unit normal on the balls' side.
    fn normal(&self) -> Triple<T>;
    /// E, F, G of the first fundamental form.
    fn first(&self) -> [T; 3];
    /// L, M, N of the second: positive where the floor curves towards the ball.
    fn second(&self) -> [T; 3];
    /// 1 / (EG - F^2).
    fn inverse_area_squared(&self) -> T;
    /// (`S_u`.w, `S_v`.w).
    fn along(&self, w: Triple<T>) -> [T; 2];
    /// a `S_u` + b `S_v`.
    fn combine(&self, a: T, b: T) -> Triple<T>;
}

/// A floor in one chart.
pub trait Chart {
    /// Whether several balls are worth a kernel of their own here: its size and the time to build it must pay.
    const SIDE_BY_SIDE: bool = true;
    /// What it gives at a place.
    type Frame<T: Number>: Frame<T>;
    /// The floor at q; extrapolates the polynomial outside the patch.
    fn frame<T: Number>(&self, q: [T; 2]) -> Self::Frame<T>;
}

/// The kernel of one floor, in the smallest size that holds it.
#[derive(Clone, Debug)]
pub enum Kernel {
    /// A plane.
    Flat(FlatChart),
    /// A height field of total degree 2.
    Quadric(QuadricChart),
    /// A height field of degree up to 2, 3, 4, 5, in powers.
    Height2(PowerChart<3>),
    /// See `Height2`.
    Height3(PowerChart<4>),
    /// See `Height2`.
    Height4(PowerChart<5>),
    /// See `Height2`.
    Height5(PowerChart<6>),
    /// A height field of degree up to 6, 10, 12.
    Height6(HeightChart<7>),
    /// See `Height6`.
    Height10(HeightChart<11>),
    /// See `Height6`.
    Height12(HeightChart<13>),
    /// A general net of degree up to 3, 5, in powers.
    Net3(PowerNet<4>),
    /// See `Net3`.
    Net5(PowerNet<6>),
    /// A general net of degree up to 12.
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
            $crate::surface::chart::Kernel::Height4($chart) => $body,
            $crate::surface::chart::Kernel::Height5($chart) => $body,
            $crate::surface::chart::Kernel::Height6($chart) => $body,
            $crate::surface::chart::Kernel::Height10($chart) => $body,
            $crate::surface::chart::Kernel::Height12($chart) => $body,
            $crate::surface::chart::Kernel::Net3($chart) => $body,
            $crate::surface::chart::Kernel::Net5($chart) => $body,
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
            let middle = [middle[0], middle[1], at(0, 0)];
            let curve = [2.0 * at(2, 0), at(1, 1), 2.0 * at(0, 2)];
            let kernel = Kernel::Quadric(QuadricChart { middle, slope: [at(1, 0), at(0, 1)], curve });
            return Self { kernel, width };
        }
        let axes = [0, 1].map(|k| Axis::new(Basis::Power, degree[k], width[k]));
        Self { kernel: height_kernel(middle, width, axes, at), width }
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
        Self { kernel: height_kernel(middle, width, axes, at), width }
    }

    fn net(patch: &BezierPatch, side: f64) -> Self {
        let kernel = match patch.degree().into_iter().max().unwrap_or(0) {
            0..=3 => Kernel::Net3(power_net(patch, side)),
            4..=POWER_DEGREE_MAX => Kernel::Net5(power_net(patch, side)),
            _ => Kernel::Net12(net_chart(patch, side)),
        };
        Self { kernel, width: [1.0; 2] }
    }

    fn flat(middle: [f64; 2], height: f64, slope: [f64; 2]) -> Kernel {
        let cosine = 1.0 / (1.0 + (slope[0] * slope[0] + slope[1] * slope[1])).sqrt();
        Kernel::Flat(FlatChart { middle: [middle[0], middle[1], height], slope, cosine })
    }
}

fn power_net<const N: usize>(patch: &BezierPatch, side: f64) -> PowerNet<N> {
    let powers = |axis: usize| centred_powers(patch.degree(), [1.0; 2], |i, j| patch.point(i, j)[axis]);
    PowerNet { coefficients: [0, 1, 2].map(|axis| Box::new(powers(axis))), side }
}

fn net_chart<const N: usize>(patch: &BezierPatch, side: f64) -> NetChart<N> {
    let [p, q] = patch.degree();
    let at = |axis: usize| square(|i, j| if i <= p && j <= q { patch.point(i, j)[axis] } else { 0.0 });
    let axes = [Axis::new(Basis::Bernstein, p, 1.0), Axis::new(Basis::Bernstein, q, 1.0)];
    NetChart { axes, coefficients: [0, 1, 2].map(|axis| Box::new(at(axis))), side }
}

fn square<const N: usize>(at: impl Fn(usize, usize) -> f64) -> [[f64; N]; N] {
    std::array::from_fn(|i| std::array::from_fn(|j| at(i, j)))
}

fn height_kernel(
    middle: [f64; 2],
    width: [f64; 2],
    axes: [Axis; 2],
    at: impl Fn(usize, usize) -> f64,
) -> Kernel {
    /// Coefficients that are powers already stay as they are.
    fn power<const N: usize>(
        (middle, width): ([f64; 2], [f64; 2]),
        axes: &[Axis; 2],
        at: impl Fn(usize, usize) -> f64,
    ) -> PowerChart<N> {
        let degree = [axes[0].degree, axes[1].degree];
        let coefficients = match axes[0].basis {
            Basis::Power => square(at),
            Basis::Bernstein => centred_powers(degree, width, at),
        };
        PowerChart { middle, coefficients: Box::new(coefficients) }
    }
    let placed = (middle, width);
    match axes[0].degree.max(axes[1].degree) {
        0..=2 => Kernel::Height2(power(placed, &axes, at)),
        3 => Kernel::Height3(power(placed, &axes, at)),
        4 => Kernel::Height4(power(placed, &axes, at)),
        5 => Kernel::Height5(power(placed, &axes, at)),
        6 => Kernel::Height6(HeightChart { middle, axes, coefficients: Box::new(square(at)) }),
        7..=10 => Kernel::Height10(HeightChart { middle, axes, coefficients: Box::new(square(at)) }),
        _ => Kernel::Height12(HeightChart { middle, axes, coefficients: Box::new(square(at)) }),
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
