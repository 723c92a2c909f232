//! Several balls' numbers in one machine word, as wide as the machine at hand has them.
//!
//! Every operation is the one that a single `f64` has, lane by lane, and correctly rounded: how many lanes there are
//! changes no bit of a result. There is no fused product and sum here, and there must be none.

use crate::number::Number;
use pulp::Simd;
use pulp::bytemuck::cast_slice;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Most lanes of any machine.
pub const LANES_MAX: usize = 8;

/// One number for each lane.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<S: Simd> {
    simd: S,
    values: S::f64s,
}

impl<S: Simd> Lanes<S> {
    /// The number `of` each lane.
    #[inline(always)]
    pub fn new(simd: S, mut of: impl FnMut(usize) -> f64) -> Self {
        const { assert!(S::F64_LANES <= LANES_MAX) };
        let mut values = simd.splat_f64s(0.0);
        let row: &mut [f64] = pulp::bytemuck::cast_slice_mut(std::slice::from_mut(&mut values));
        for (lane, value) in row.iter_mut().enumerate() {
            *value = of(lane);
        }
        Self { simd, values }
    }

    /// The number of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> f64 {
        cast_slice::<S::f64s, f64>(std::slice::from_ref(&self.values))[lane]
    }
}

impl<S: Simd> Number for Lanes<S> {
    #[inline(always)]
    fn like(self, x: f64) -> Self {
        Self { simd: self.simd, values: self.simd.splat_f64s(x) }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self { simd: self.simd, values: self.simd.sqrt_f64s(self.values) }
    }
    #[inline(always)]
    fn where_less(self, than: Self, then: Self, other: Self) -> Self {
        let less = self.simd.less_than_f64s(self.values, than.values);
        Self { simd: self.simd, values: self.simd.select_f64s(less, then.values, other.values) }
    }
    #[inline(always)]
    fn turn_over([a, b, c, d]: [Self; 4], mut put: impl FnMut(usize, &[f64; 4])) {
        let simd = a.simd;
        // The library chooses the order: what becomes of the lanes' own numbers tells it.
        let number = Self::new(simd, |lane| lane as f64).values;
        let order = simd.interleave_shfl_f64s([number; 4]);
        let turned = simd.interleave_shfl_f64s([a.values, b.values, c.values, d.values]);
        let order: &[[f64; 4]] = cast_slice(cast_slice::<S::f64s, f64>(&order));
        let turned: &[[f64; 4]] = cast_slice(cast_slice::<S::f64s, f64>(&turned));
        for (lane, four) in order.iter().zip(turned) {
            put(lane[0] as usize, four);
        }
    }
}

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { simd: self.simd, values: self.simd.add_f64s(self.values, other.values) }
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { simd: self.simd, values: self.simd.sub_f64s(self.values, other.values) }
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { simd: self.simd, values: self.simd.mul_f64s(self.values, other.values) }
    }
}

impl<S: Simd> Mul<f64> for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self * self.like(factor)
    }
}

impl<S: Simd> Div for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self { simd: self.simd, values: self.simd.div_f64s(self.values, other.values) }
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // Exact, and unlike the library's own it is no call.
        self * -1.0
    }
}
