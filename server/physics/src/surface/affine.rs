//! Affine forms: what a function does on a box, to first order, with everything else bounded.
//!
//! Plain intervals forget that two quantities rise together, so their excess shrinks like the box; an affine
//! form keeps the two slopes, and its excess shrinks like the box squared. That is the difference between
//! thousands of boxes and millions when a maximum is to be bracketed to three digits.

use std::ops::{Add, Mul, Neg, Sub};

/// For every s in [-1, 1]^N the function lies within `radius` of `center + slope . s`. Two variables are a place
/// in a box, four are a pair of places. Every operation adds its own rounding to the radius. Numbers that overflow
/// make the form not finite, and [`Affine::range`] then the whole line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine<const N: usize = 2> {
    /// Value of the affine part in the middle.
    pub center: f64,
    /// Its slope along each variable.
    pub slope: [f64; N],
    /// Bound on everything else.
    pub radius: f64,
}

/// Rounding of one operation, relative to the sum of its operands' sizes (of a product: to their product). The longest
/// is the product in four variables: 6 roundings of 2^-53 meet in the centre, 3 in the slopes, fewer than 20 in the
/// radius; 2^-48 is more than all of them.
const ROUNDING: f64 = 1.0 / (1_u64 << 48) as f64;

impl Affine<2> {
    /// The same function of the first two of four variables (`second` = 0) or of the last two (1).
    pub fn joint(self, second: usize) -> Affine<4> {
        let mut slope = [0.0; 4];
        slope[2 * second..2 * second + 2].copy_from_slice(&self.slope);
        Affine { center: self.center, slope, radius: self.radius }
    }

    /// The function at the place (s, t) that depends on four variables.
    pub fn composed(self, place: &[Affine<4>; 2]) -> Affine<4> {
        let part = |k: usize| place[k] * Affine::number(self.slope[k], 0.0);
        part(0) + part(1) + Affine::number(self.center, self.radius)
    }
}

impl<const N: usize> Affine<N> {
    /// A number known to within `radius`.
    pub const fn number(center: f64, radius: f64) -> Self {
        Self { center, slope: [0.0; N], radius }
    }

    /// Largest absolute value of the part without center and radius.
    fn swing(&self) -> f64 {
        self.slope.iter().map(|slope| slope.abs()).sum()
    }

    /// Largest possible absolute value.
    fn size(&self) -> f64 {
        self.center.abs() + self.swing() + self.radius
    }

    /// Smallest and largest possible value.
    pub fn range(&self) -> [f64; 2] {
        let reach = self.swing() + self.radius + ROUNDING * self.size();
        let [low, high] = [self.center - reach, self.center + reach];
        if low.is_finite() && high.is_finite() { [low, high] } else { [f64::NEG_INFINITY, f64::INFINITY] }
    }

    /// The affine part at one corner of the box; `signs` are -1 or +1.
    pub fn at(&self, signs: [f64; N]) -> f64 {
        self.slope.iter().zip(signs).fold(self.center, |sum, (slope, sign)| sum + slope * sign)
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

impl<const N: usize> Add for Affine<N> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            center: self.center + other.center,
            slope: std::array::from_fn(|k| self.slope[k] + other.slope[k]),
            radius: self.radius + other.radius + ROUNDING * (self.size() + other.size()),
        }
    }
}

impl<const N: usize> Neg for Affine<N> {
    type Output = Self;
    fn neg(self) -> Self {
        self.scaled(-1.0)
    }
}

impl<const N: usize> Sub for Affine<N> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<const N: usize> Mul for Affine<N> {
    type Output = Self;
    /// Squares of variables lie in [0, 1], so half of their factors goes to the middle and half to the radius;
    /// products of two variables lie in [-1, 1] and go to the radius.
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.slope, other.slope);
        let (size, other_size) = (self.size(), other.size());
        let mut center = 0.0;
        let mut radius = 0.0;
        for i in 0..N {
            let square = 0.5 * (a[i] * b[i]);
            center += square;
            radius += square.abs();
            for j in 0..i {
                radius += (a[i] * b[j] + a[j] * b[i]).abs();
            }
        }
        Self {
            center: self.center * other.center + center,
            slope: std::array::from_fn(|k| self.center * b[k] + other.center * a[k]),
            radius: radius + size * other.radius + other_size * self.radius + ROUNDING * size * other_size,
        }
    }
}

/// A vector of forms times another.
pub(super) fn dot<const N: usize>(a: &[Affine<N>; 3], b: &[Affine<N>; 3]) -> Affine<N> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The cross product.
pub(super) fn cross<const N: usize>(a: &[Affine<N>; 3], b: &[Affine<N>; 3]) -> [Affine<N>; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
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
        fn products_of_four_variables_enclose_what_they_stand_for(
            a in prop::array::uniform5(-1.0..1.0_f64), b in prop::array::uniform5(-1.0..1.0_f64),
            s in prop::array::uniform4(-1.0..1.0_f64),
        ) {
            let form = |a: [f64; 5]| Affine { center: a[0], slope: [a[1], a[2], a[3], a[4]], radius: 0.0 };
            let product = form(a) * form(b);
            prop_assert!((product.at(s) - form(a).at(s) * form(b).at(s)).abs() <= product.radius);
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
        assert!(Affine::<2>::number(f64::NAN, 0.0).recip().is_none());
        assert!(Affine::<2>::number(-1.0, 0.0).sqrt().is_none());
        assert_eq!(Affine::<2>::number(f64::NAN, 0.0).range(), [f64::NEG_INFINITY, f64::INFINITY]);
    }
}
