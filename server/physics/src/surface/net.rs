//! General nets: three components, in any chart.

use super::basis::{Axis, contract, horner};
use super::chart::{Chart, Frame};
use crate::number::{Number, Triple};

/// A general net at one place.
#[derive(Clone, Copy, Debug)]
pub struct NetFrame<T> {
    point: Triple<T>,
    tangents: [Triple<T>; 2],
    normal: Triple<T>,
    second: [T; 3],
    inverse_area_squared: T,
}

impl<T: Number> NetFrame<T> {
    /// From the jets of x, y and z; `side` is +1 where `S_u` x `S_v` points to the balls' side, else -1.
    #[inline(always)]
    fn new(side: f64, [x, y, z]: [[T; 6]; 3]) -> Self {
        let (su, sv) = (Triple([x[1], y[1], z[1]]), Triple([x[2], y[2], z[2]]));
        let cross = su.cross(sv);
        let inverse_area_squared = z[0].like(1.0) / cross.dot(cross);
        let normal = cross * (inverse_area_squared.sqrt() * side);
        Self {
            point: Triple([x[0], y[0], z[0]]),
            tangents: [su, sv],
            normal,
            second: [
                Triple([x[3], y[3], z[3]]).dot(normal),
                Triple([x[4], y[4], z[4]]).dot(normal),
                Triple([x[5], y[5], z[5]]).dot(normal),
            ],
            inverse_area_squared,
        }
    }
}

impl<T: Number> Frame<T> for NetFrame<T> {
    #[inline(always)]
    fn point(&self) -> Triple<T> {
        self.point
    }
    #[inline(always)]
    fn normal(&self) -> Triple<T> {
        self.normal
    }
    #[inline(always)]
    fn first(&self) -> [T; 3] {
        let [su, sv] = self.tangents;
        [su.dot(su), su.dot(sv), sv.dot(sv)]
    }
    #[inline(always)]
    fn second(&self) -> [T; 3] {
        self.second
    }
    #[inline(always)]
    fn inverse_area_squared(&self) -> T {
        self.inverse_area_squared
    }
    #[inline(always)]
    fn along(&self, w: Triple<T>) -> [T; 2] {
        [self.tangents[0].dot(w), self.tangents[1].dot(w)]
    }
    #[inline(always)]
    fn combine(&self, a: T, b: T) -> Triple<T> {
        self.tangents[0] * a + self.tangents[1] * b
    }
}

/// A net of low degree, in centred powers.
#[derive(Clone, Debug)]
pub struct PowerNet<const N: usize> {
    pub(super) coefficients: [Box<[[f64; N]; N]>; 3],
    pub(super) side: f64,
}

impl<const N: usize> Chart for PowerNet<N> {
    type Frame<T: Number> = NetFrame<T>;

    #[inline(always)]
    fn frame<T: Number>(&self, q: [T; 2]) -> NetFrame<T> {
        let [x, y, z] = &self.coefficients;
        NetFrame::new(self.side, [horner(x, q), horner(y, q), horner(z, q)])
    }
}

/// A net of any degree.
#[derive(Clone, Debug)]
pub struct NetChart<const N: usize> {
    pub(super) axes: [Axis; 2],
    pub(super) coefficients: [Box<[[f64; N]; N]>; 3],
    pub(super) side: f64,
}

impl<const N: usize> Chart for NetChart<N> {
    const SIDE_BY_SIDE: bool = false;
    type Frame<T: Number> = NetFrame<T>;

    #[inline(always)]
    fn frame<T: Number>(&self, q: [T; 2]) -> NetFrame<T> {
        let [x, y, z] = &self.coefficients;
        NetFrame::new(self.side, contract([&**x, &**y, &**z], &self.axes, q))
    }
}
