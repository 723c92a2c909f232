//! What the kernels compute with: one number, or several balls' numbers side by side.
//!
//! A kernel written over [`Number`] does the same operations in the same order for either, and every one of them is
//! correctly rounded: a lane's bits are those of the ball alone. Nothing fuses a product and a sum.

use nalgebra::Vector3;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number, or a row of numbers, with the operations that IEEE 754 rounds correctly.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// `x` in every lane.
    #[must_use]
    fn like(self, x: f64) -> Self;
    /// The square root.
    #[must_use]
    fn sqrt(self) -> Self;
    /// `then` in the lanes where this is less than `than`, else `other`.
    #[must_use]
    fn where_less(self, than: Self, then: Self, other: Self) -> Self;
    /// Gives `put` every lane and its part of four rows, in no particular order.
    fn turn_over(rows: [Self; 4], put: impl FnMut(usize, &[f64; 4]));
}

impl Number for f64 {
    #[inline(always)]
    fn like(self, x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn where_less(self, than: Self, then: Self, other: Self) -> Self {
        if self < than { then } else { other }
    }
    #[inline(always)]
    fn turn_over(rows: [Self; 4], mut put: impl FnMut(usize, &[f64; 4])) {
        put(0, &rows);
    }
}

/// The largest number of so many significant `bits` that is not larger than one that is not negative, infinity included:
/// lengths of time that are exact fractions of a second.
#[inline]
pub fn of_few_bits(x: f64, bits: u32) -> f64 {
    f64::from_bits(x.to_bits() & (u64::MAX << (f64::MANTISSA_DIGITS - bits)))
}

/// A row of the same number in every lane. Plain loops fill rows: a closure may become a call, which a kernel compiled
/// for wide vectors cannot afford.
#[inline(always)]
pub fn row<T: Number, const N: usize>(like: T, x: &[f64; N]) -> [T; N] {
    let mut out = [like; N];
    for i in 0..N {
        out[i] = like.like(x[i]);
    }
    out
}

/// Three numbers in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triple<T>(pub [T; 3]);

impl<T: Number> Triple<T> {
    /// `then` in the lanes where `a` is less than `b`, else `other`.
    #[inline(always)]
    pub fn where_less(a: T, b: T, then: Self, other: Self) -> Self {
        let ([x, y, z], [u, v, w]) = (then.0, other.0);
        Self([a.where_less(b, x, u), a.where_less(b, y, v), a.where_less(b, z, w)])
    }

    /// The inner product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> T {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        a * x + b * y + c * z
    }

    /// The length.
    #[inline(always)]
    pub fn norm(self) -> T {
        self.dot(self).sqrt()
    }

    /// The cross product.
    #[inline(always)]
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }
}

impl<T: Number> Add for Triple<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a + x, b + y, c + z])
    }
}

impl<T: Number> Sub for Triple<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a - x, b - y, c - z])
    }
}

impl<T: Number> Mul<T> for Triple<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        let [a, b, c] = self.0;
        Self([a * factor, b * factor, c * factor])
    }
}

impl<T: Number> Neg for Triple<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let [a, b, c] = self.0;
        Self([-a, -b, -c])
    }
}

impl From<Triple<f64>> for Vector3<f64> {
    #[inline(always)]
    fn from(v: Triple<f64>) -> Self {
        v.0.into()
    }
}

impl From<Vector3<f64>> for Triple<f64> {
    #[inline(always)]
    fn from(v: Vector3<f64>) -> Self {
        Self(v.into())
    }
}
