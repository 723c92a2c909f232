//! Affine forms: what a function does on a box, to first order, with everything else bounded.
//!
//! Plain intervals forget that two quantities rise together, so their excess shrinks like the box; an affine
//! form keeps the two slopes, and its excess shrinks like the box squared. That is the difference between
//! thousands of boxes and millions when a maximum is to be bracketed to three digits.

use std::ops::{Add, Mul, Neg, Sub};

/// For every (s, t) in [-1, 1]^2 the function lies within `radius` of `center + slope[0] s + slope[1] t`.
/// Every operation adds its own rounding to the radius. Numbers that overflow make the form not finite, and
/// [`Affine::range`] then the whole line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Affine {
    /// Value of the affine part in the middle.
    pub center: f64,
    /// Its slopes along s and t.
    pub slope: [f64; 2],
    /// Bound on everything else.
    pub radius: f64,
}

/// Rounding of one operation, relative to the sum of its operands' sizes: at most seven roundings of 2^-53 meet
/// in one component, four components are rounded; 2^-48 is all of them.
const ROUNDING: f64 = 1.0 / (1_u64 << 48) as f64;

impl Affine {
    /// A number known to within `radius`.
    pub fn number(center: f64, radius: f64) -> Self {
        Self { center, slope: [0.0; 2], radius }
    }

    /// Largest possible absolute value.
    fn size(&self) -> f64 {
        self.center.abs() + self.slope[0].abs() + self.slope[1].abs() + self.radius
    }

    /// Smallest and largest possible value.
    pub fn range(&self) -> [f64; 2] {
        let reach = self.slope[0].abs() + self.slope[1].abs() + self.radius + ROUNDING * self.size();
        let [low, high] = [self.center - reach, self.center + reach];
        if low.is_finite() && high.is_finite() { [low, high] } else { [f64::NEG_INFINITY, f64::INFINITY] }
    }

    /// The affine part at one corner of the box; `signs` are -1 or +1.
    pub fn at(&self, signs: [f64; 2]) -> f64 {
        self.center + self.slope[0] * signs[0] + self.slope[1] * signs[1]
    }

    /// Exact multiple by a power of two or by -1.
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            center: self.center * factor,
            slope: self.slope.map(|slope| slope * factor),
            radius: self.radius * factor.abs(),
        }
    }

    /// `slope * self + offset` for an offset anywhere between two numbers.
    fn along(self, slope: f64, offset: [f64; 2], rounding: f64) -> Self {
        Self {
            center: slope * self.center + 0.5 * (offset[0] + offset[1]),
            slope: self.slope.map(|own| slope * own),
            radius: slope.abs() * self.radius + 0.5 * (offset[1] - offset[0]) + rounding,
        }
    }

    /// 1 / self, where self is certainly positive. Against its secant, 1/x is farthest at the ends and at their
    /// geometric mean.
    pub fn recip(self) -> Option<Self> {
        let [low, high] = self.range();
        let secant = -1.0 / (low * high);
        let offset = [2.0 / (low * high).sqrt(), 1.0 / low + 1.0 / high];
        (low > 0.0 && high.is_finite() && secant.is_finite() && offset[0].is_finite())
            .then(|| self.along(secant, offset, 4.0 * ROUNDING / low))
    }

    /// The square root, where self is certainly positive. Against its secant, the root is farthest at the ends and where
    /// its slope is the secant's.
    pub fn sqrt(self) -> Option<Self> {
        let [low, high] = self.range();
        let secant = 1.0 / (low.sqrt() + high.sqrt());
        let offset = [low.sqrt() * high.sqrt() * secant, 0.25 / secant];
        (low > 0.0 && high.is_finite()).then(|| self.along(secant, offset, 4.0 * ROUNDING * high.sqrt()))
    }
}

impl Add for Affine {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            center: self.center + other.center,
            slope: [self.slope[0] + other.slope[0], self.slope[1] + other.slope[1]],
            radius: self.radius + other.radius + ROUNDING * (self.size() + other.size()),
        }
    }
}

impl Neg for Affine {
    type Output = Self;
    fn neg(self) -> Self {
        self.scaled(-1.0)
    }
}

impl Sub for Affine {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Affine {
    type Output = Self;
    /// The squares s^2 and t^2 lie in [0, 1], so half of their factors goes to the middle and half to the radius.
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.slope, other.slope);
        let squares = [a[0] * b[0], a[1] * b[1]];
        let mixed = a[0] * b[1] + a[1] * b[0];
        let (size, other_size) = (self.size(), other.size());
        Self {
            center: self.center * other.center + 0.5 * (squares[0] + squares[1]),
            slope: [self.center * b[0] + other.center * a[0], self.center * b[1] + other.center * a[1]],
            radius: 0.5 * (squares[0].abs() + squares[1].abs())
                + mixed.abs()
                + size * other.radius
                + other_size * self.radius
                + ROUNDING * size * other_size,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn form() -> impl Strategy<Value = Affine> {
        (-3.0..3.0_f64, -1.0..1.0_f64, -1.0..1.0_f64, 0.0..0.5_f64)
            .prop_map(|(center, s, t, radius)| Affine { center, slope: [s, t], radius })
    }

    proptest! {
        #[test]
        fn operations_enclose_what_they_stand_for(
            a in form(), b in form(), s in -1.0..1.0_f64, t in -1.0..1.0_f64, x in -1.0..1.0_f64, y in -1.0..1.0_f64
        ) {
            let value = |f: Affine, e: f64| f.center + f.slope[0] * s + f.slope[1] * t + e * f.radius;
            let holds = |f: Affine, exact: f64| (value(f, 0.0) - exact).abs() <= f.radius * (1.0 + 1e-9);
            let (p, q) = (value(a, x), value(b, y));
            prop_assert!(holds(a + b, p + q));
            prop_assert!(holds(a - b, p - q));
            prop_assert!(holds(a * b, p * q));
            if let Some(inverse) = a.recip() {
                prop_assert!(holds(inverse, 1.0 / p));
            }
            if let Some(root) = a.sqrt() {
                prop_assert!(holds(root, p.sqrt()));
            }
        }

        #[test]
        fn excess_shrinks_like_the_box_squared(center in 0.5..3.0_f64, s in -1.0..1.0_f64, t in -1.0..1.0_f64) {
            let radius = |h: f64| {
                let x = Affine { center, slope: [s * h, t * h], radius: 0.0 };
                (x * x).sqrt().unwrap().recip().unwrap().radius
            };
            prop_assert!(radius(1e-3) <= 1.1e-2 * radius(1e-2) + 1e-13);
        }
    }

    #[test]
    fn what_may_be_zero_has_no_reciprocal() {
        assert!(Affine { center: 1.0, slope: [0.5, 0.5], radius: 0.0 }.recip().is_none());
        assert!(Affine::number(f64::NAN, 0.0).recip().is_none());
        assert!(Affine::number(-1.0, 0.0).sqrt().is_none());
        assert_eq!(Affine::number(f64::NAN, 0.0).range(), [f64::NEG_INFINITY, f64::INFINITY]);
    }
}
