//! Polynomials in two variables with their first and second derivatives: by nested multiplication where powers are
//! stable, by a table of Bernstein polynomials elsewhere.

use super::bezier::MAX_DEGREE;
use crate::number::{Number, row};

/// Value and derivatives `[f, f_0, f_1, f_00, f_01, f_11]` at one place.
pub(super) type Jet2<T> = [T; 6];

// ---------------------------------------------------------------------------------------------------------

/// Largest degree of a net that is evaluated in powers: they may lose 2^degree ulp of the net at its border, Bernstein
/// polynomials a few at any degree.
pub(super) const POWER_DEGREE_MAX: usize = 5;

/// The net `at(i, j)` of degree `degree` in powers of q = (q0, q1), centred in a patch of the given widths.
///
/// Mirror images have mirrored coefficients to the last bit: a sum runs over pairs that the mirror exchanges.
pub(super) fn centred_powers<const N: usize>(
    degree: [usize; 2],
    width: [f64; 2],
    at: impl Fn(usize, usize) -> f64,
) -> [[f64; N]; N] {
    let mut net = [[0.0; N]; N];
    for i in 0..=degree[0] {
        let row: [f64; N] = std::array::from_fn(|j| if j <= degree[1] { at(i, j) } else { 0.0 });
        net[i] = in_powers(&row, degree[1], width[1]);
    }
    for j in 0..N {
        let column: [f64; N] = std::array::from_fn(|i| net[i][j]);
        for (row, c) in net.iter_mut().zip(in_powers(&column, degree[0], width[0])) {
            row[j] = c;
        }
    }
    net
}

/// Bernstein coefficients of degree n over [-width/2, width/2] in powers of q.
fn in_powers<const N: usize>(net: &[f64; N], n: usize, width: f64) -> [f64; N] {
    let mut out = [0.0; N];
    let mut scale = 1.0 / f64::from(1_u32 << n);
    for (k, c) in out.iter_mut().enumerate().take(n + 1) {
        let mut sum = 0.0;
        for i in 0..=n / 2 {
            let weight = power_weight(n, i, k);
            let twin = net[n - i];
            sum += match (i == n - i, k % 2) {
                (true, _) => weight * net[i],
                (false, 0) => weight * (net[i] + twin),
                _ => weight * (net[i] - twin),
            };
        }
        *c = sum * scale;
        scale *= 2.0 / width;
    }
    out
}

/// The coefficient of s^k in choose(n, i) (1 + s)^i (1 - s)^(n - i): an integer.
fn power_weight(n: usize, i: usize, k: usize) -> f64 {
    let mut row = [0.0; MAX_DEGREE + 1];
    row[0] = 1.0;
    for factor in 0..n {
        let sign = if factor < i { 1.0 } else { -1.0 };
        for m in (1..=n).rev() {
            row[m] += sign * row[m - 1];
        }
    }
    let choose = (0..i).fold(1.0, |c, m| c * (n - m) as f64 / (m + 1) as f64);
    choose * row[k]
}

/// The jet of sum c[i][j] x^i y^j by repeated division: derivatives take no coefficients of their own, and a mirror
/// changes signs only.
#[inline(always)]
pub(super) fn horner<T: Number, const N: usize>(c: &[[f64; N]; N], [x, y]: [T; 2]) -> Jet2<T> {
    const { assert!(N >= 3) };
    let mut value = row(x, &c[N - 1]);
    let mut first = value;
    value = times_plus(&value, x, &row(x, &c[N - 2]));
    let mut half_second = first;
    first = times_plus(&first, x, &value);
    value = times_plus(&value, x, &row(x, &c[N - 3]));
    for i in (0..N - 3).rev() {
        half_second = times_plus(&half_second, x, &first);
        first = times_plus(&first, x, &value);
        value = times_plus(&value, x, &row(x, &c[i]));
    }
    let [f, fy, half_fyy] = along(&value, y);
    let [fx, fxy, _] = along(&first, y);
    let [half_fxx, ..] = along(&half_second, y);
    [f, fx, fy, half_fxx * 2.0, fxy, half_fyy * 2.0]
}

#[inline(always)]
fn times_plus<T: Number, const N: usize>(a: &[T; N], x: T, b: &[T; N]) -> [T; N] {
    let mut out = *b;
    for j in 0..N {
        out[j] = a[j] * x + b[j];
    }
    out
}

/// Value, first and half the second derivative of sum c[j] y^j.
#[inline(always)]
fn along<T: Number, const N: usize>(c: &[T; N], y: T) -> [T; 3] {
    let mut first = c[N - 1];
    let mut value = first * y + c[N - 2];
    let mut half_second = first;
    first = first * y + value;
    value = value * y + c[N - 3];
    for j in (0..N - 3).rev() {
        half_second = half_second * y + first;
        first = first * y + value;
        value = value * y + c[j];
    }
    [value, first, half_second]
}

// ---------------------------------------------------------------------------------------------------------

/// Which polynomials a table's coefficients belong to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Basis {
    /// Powers of q: exact for a floor given as a polynomial.
    Power,
    /// Bernstein polynomials of u = 1/2 + q/width: stable for any net.
    Bernstein,
}

/// The one-dimensional basis with two derivatives, `[order][i]`, zero beyond the degree.
type Table<T, const N: usize> = [[T; N]; 3];

/// One of the two variables of a table.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub basis: Basis,
    pub degree: usize,
    inverse_width: f64,
    /// Binomials of degree p, p - 1, p - 2.
    binomial: [[f64; MAX_DEGREE + 1]; 3],
}

impl Axis {
    pub fn new(basis: Basis, degree: usize, width: f64) -> Self {
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

    #[inline(always)]
    fn table<T: Number, const N: usize>(&self, q: T) -> Table<T, N> {
        let zero = q.like(0.0);
        let one = q.like(1.0);
        let mut out = [[zero; N]; 3];
        let p = self.degree.min(N - 1);
        if self.basis == Basis::Power {
            let mut power = one;
            for i in 0..=p {
                out[0][i] = power;
                if i < p {
                    out[1][i + 1] = power * (i + 1) as f64;
                }
                if i + 2 <= p {
                    out[2][i + 2] = power * ((i + 1) * (i + 2)) as f64;
                }
                power = power * q;
            }
            return out;
        }
        let s = q * self.inverse_width;
        let half = q.like(0.5);
        let (u, w) = (half + s, half - s);
        let (mut pu, mut pw) = ([one; N], [one; N]);
        for i in 1..=p {
            pu[i] = pu[i - 1] * u;
            pw[i] = pw[i - 1] * w;
        }
        let [b0, b1, b2] = &self.binomial;
        let d1 = p as f64 * self.inverse_width;
        let d2 = d1 * p.saturating_sub(1) as f64 * self.inverse_width;
        // Basis values of the two lower degrees, shifted by one and two so that differences need no ifs.
        let mut low1 = [zero; MAX_DEGREE + 2];
        let mut low2 = [zero; MAX_DEGREE + 3];
        for i in 0..p {
            low1[i + 1] = (pu[i] * pw[p - 1 - i]) * b1[i];
        }
        if p >= 2 {
            for i in 0..p - 1 {
                low2[i + 2] = (pu[i] * pw[p - 2 - i]) * b2[i];
            }
        }
        for i in 0..=p {
            out[0][i] = (pu[i] * pw[p - i]) * b0[i];
            out[1][i] = (low1[i] - low1[i + 1]) * d1;
            out[2][i] = ((low2[i] + low2[i + 2]) - low2[i + 1] * 2.0) * d2;
        }
        out
    }
}

/// Sum over i of `a[i] b[i]` for i up to `degree`, in mirror pairs.
#[inline(always)]
fn paired_dot<T: Number, const N: usize>(a: &[T; N], b: &[T; N], degree: usize) -> T {
    let mut sum = a[0].like(0.0);
    for i in 0..N.div_ceil(2) {
        if i > degree / 2 {
            break;
        }
        let k = (degree - i).min(N - 1);
        sum = sum + if i == k { a[i] * b[i] } else { a[i] * b[i] + a[k] * b[k] };
    }
    sum
}

/// The jets of several sums c[i][j] `X_i` `Y_j` that share a place.
#[inline(always)]
pub(super) fn contract<T: Number, const N: usize, const M: usize>(
    coefficients: [&[[f64; N]; N]; M],
    axes: &[Axis; 2],
    q: [T; 2],
) -> [Jet2<T>; M] {
    let degree = [axes[0].degree, axes[1].degree];
    let (x, y) = (axes[0].table::<T, N>(q[0]), axes[1].table::<T, N>(q[1]));
    let mut jets = [[q[0].like(0.0); 6]; M];
    for m in 0..M {
        jets[m] = contract_one(coefficients[m], &x, &y, degree);
    }
    jets
}

#[inline(always)]
fn contract_one<T: Number, const N: usize>(
    c: &[[f64; N]; N],
    x: &Table<T, N>,
    y: &Table<T, N>,
    degree: [usize; 2],
) -> Jet2<T> {
    let mut rows = [[x[0][0].like(0.0); N]; 3];
    for i in 0..N.div_ceil(2) {
        if i > degree[0] / 2 {
            break;
        }
        let k = (degree[0] - i).min(N - 1);
        for order in 0..3 {
            for j in 0..N {
                let term = x[order][i] * c[i][j];
                let term = if i == k { term } else { term + x[order][k] * c[k][j] };
                rows[order][j] = rows[order][j] + term;
            }
        }
    }
    let [value, first, second] = &rows;
    [
        paired_dot(value, &y[0], degree[1]),
        paired_dot(first, &y[0], degree[1]),
        paired_dot(value, &y[1], degree[1]),
        paired_dot(second, &y[0], degree[1]),
        paired_dot(first, &y[1], degree[1]),
        paired_dot(value, &y[2], degree[1]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn powers_are_the_bernstein_table(
            net in prop::array::uniform6(prop::array::uniform6(-1.0..1.0_f64)),
            p in 1..=5_usize, q in 1..=5_usize, x in -1.0..1.0_f64, y in -1.5..1.5_f64,
        ) {
            let at = |i: usize, j: usize| if i <= p && j <= q { net[i][j] } else { 0.0 };
            let powers = centred_powers::<6>([p, q], [2.0, 3.0], at);
            let table: [[f64; 6]; 6] = std::array::from_fn(|i| std::array::from_fn(|j| at(i, j)));
            let axes = [Axis::new(Basis::Bernstein, p, 2.0), Axis::new(Basis::Bernstein, q, 3.0)];
            let [want] = contract([&table], &axes, [x, y]);
            for (a, b) in horner(&powers, [x, y]).into_iter().zip(want) {
                prop_assert!((a - b).abs() < 2e-14, "{a} is not {b}");
            }
        }

        #[test]
        fn a_mirrored_net_has_mirrored_powers_to_the_last_bit(
            net in prop::array::uniform6(prop::array::uniform6(-1.0..1.0_f64)),
            p in 1..=5_usize, q in 1..=5_usize, x in -1.0..1.0_f64, y in -1.5..1.5_f64,
        ) {
            let powers = centred_powers::<6>([p, q], [2.0, 3.0], |i, j| net[i][j]);
            let image = centred_powers::<6>([p, q], [2.0, 3.0], |i, j| net[p - i][j]);
            let [f, fx, fy, fxx, fxy, fyy] = horner(&powers, [x, y]);
            prop_assert_eq!(horner(&image, [-x, y]), [f, -fx, fy, fxx, -fxy, fyy]);
            let image = centred_powers::<6>([p, q], [2.0, 3.0], |i, j| net[i][q - j]);
            prop_assert_eq!(horner(&image, [x, -y]), [f, fx, -fy, fxx, -fxy, fyy]);
        }
    }
}
