//! Height fields z(x, y): only z is evaluated.

use super::basis::{Axis, contract, horner};
use super::chart::{Chart, Frame};
use crate::number::{Number, Triple, row};

/// A height field at one place; the tangents are (1, 0, `z_x`) and (0, 1, `z_y`).
#[derive(Clone, Copy, Debug)]
pub struct HeightFrame<T> {
    point: Triple<T>,
    slope: [T; 2],
    second: [T; 3],
    /// 1 / sqrt(1 + `z_x`^2 + `z_y`^2).
    cosine: T,
}

impl<T: Number> HeightFrame<T> {
    /// From the jet of z at q around `middle`.
    #[inline(always)]
    fn new(middle: [f64; 2], q: [T; 2], [z, zx, zy, zxx, zxy, zyy]: [T; 6]) -> Self {
        let one = z.like(1.0);
        let cosine = one / (one + (zx * zx + zy * zy)).sqrt();
        Self {
            point: Triple([z.like(middle[0]) + q[0], z.like(middle[1]) + q[1], z]),
            slope: [zx, zy],
            second: [zxx * cosine, zxy * cosine, zyy * cosine],
            cosine,
        }
    }
}

impl<T: Number> Frame<T> for HeightFrame<T> {
    #[inline(always)]
    fn point(&self) -> Triple<T> {
        self.point
    }
    #[inline(always)]
    fn normal(&self) -> Triple<T> {
        Triple([-self.slope[0] * self.cosine, -self.slope[1] * self.cosine, self.cosine])
    }
    #[inline(always)]
    fn first(&self) -> [T; 3] {
        let [a, b] = self.slope;
        let one = a.like(1.0);
        [one + a * a, a * b, one + b * b]
    }
    #[inline(always)]
    fn second(&self) -> [T; 3] {
        self.second
    }
    #[inline(always)]
    fn inverse_area_squared(&self) -> T {
        self.cosine * self.cosine
    }
    #[inline(always)]
    fn along(&self, w: Triple<T>) -> [T; 2] {
        let [x, y, z] = w.0;
        [x + self.slope[0] * z, y + self.slope[1] * z]
    }
    #[inline(always)]
    fn combine(&self, a: T, b: T) -> Triple<T> {
        Triple([a, b, a * self.slope[0] + b * self.slope[1]])
    }
}

/// A height field of low degree, in centred powers.
#[derive(Clone, Debug)]
pub struct PowerChart<const N: usize> {
    pub(super) middle: [f64; 2],
    pub(super) coefficients: Box<[[f64; N]; N]>,
}

impl<const N: usize> Chart for PowerChart<N> {
    type Frame<T: Number> = HeightFrame<T>;

    #[inline(always)]
    fn frame<T: Number>(&self, q: [T; 2]) -> HeightFrame<T> {
        HeightFrame::new(self.middle, q, horner(&self.coefficients, q))
    }
}

/// A height field of any degree.
#[derive(Clone, Debug)]
pub struct HeightChart<const N: usize> {
    pub(super) middle: [f64; 2],
    pub(super) axes: [Axis; 2],
    pub(super) coefficients: Box<[[f64; N]; N]>,
}

impl<const N: usize> Chart for HeightChart<N> {
    const SIDE_BY_SIDE: bool = false;
    type Frame<T: Number> = HeightFrame<T>;

    #[inline(always)]
    fn frame<T: Number>(&self, q: [T; 2]) -> HeightFrame<T> {
        let [jet] = contract([&*self.coefficients], &self.axes, q);
        HeightFrame::new(self.middle, q, jet)
    }
}

/// A plane z = z0 + slope . q: nothing to evaluate, nothing to integrate.
#[derive(Clone, Copy, Debug)]
pub struct FlatChart {
    pub(super) middle: [f64; 3],
    pub(super) slope: [f64; 2],
    pub(super) cosine: f64,
}

impl Chart for FlatChart {
    const SIDE_BY_SIDE: bool = false;
    type Frame<T: Number> = HeightFrame<T>;

    #[inline(always)]
    fn frame<T: Number>(&self, q: [T; 2]) -> HeightFrame<T> {
        let rise = q[0] * self.slope[0] + q[1] * self.slope[1];
        HeightFrame {
            point: Triple(row(rise, &self.middle)) + Triple([q[0], q[1], rise]),
            slope: row(rise, &self.slope),
            second: [rise.like(0.0); 3],
            cosine: rise.like(self.cosine),
        }
    }
}

/// A floor of total degree 2: bowls, troughs, saddles. Its second derivatives are constants.
#[derive(Clone, Copy, Debug)]
pub struct QuadricChart {
    pub(super) middle: [f64; 3],
    pub(super) slope: [f64; 2],
    /// `z_xx`, `z_xy`, `z_yy`.
    pub(super) curve: [f64; 3],
}

impl Chart for QuadricChart {
    type Frame<T: Number> = HeightFrame<T>;

    #[inline(always)]
    fn frame<T: Number>(&self, q: [T; 2]) -> HeightFrame<T> {
        let [a, b, c] = self.curve;
        let [x, y] = q;
        let [sx, sy] = row(x, &self.slope);
        let (bend_x, bend_y) = (x * a + y * b, x * b + y * c);
        let rise = (sx + bend_x * 0.5) * x + (sy + bend_y * 0.5) * y;
        let z = x.like(self.middle[2]) + rise;
        let jet = [z, sx + bend_x, sy + bend_y, x.like(a), x.like(b), x.like(c)];
        HeightFrame::new([self.middle[0], self.middle[1]], q, jet)
    }
}
