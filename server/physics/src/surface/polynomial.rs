//! A polynomial z = P(x, y) over a rectangle as its exact Bezier net.

use super::bezier::{BezierPatch, MAX_DEGREE};

impl BezierPatch {
    /// The net of z = sum over i, j of `terms[i][j]` x^i y^j over a rectangle, of the polynomial's own degree (at least
    /// 1 each way). Exact but for rounding of the control points; where the rectangle is symmetric about 0 the net
    /// of an even (odd) polynomial is exactly symmetric (antisymmetric). None above [`MAX_DEGREE`] or for numbers
    /// that are not finite.
    pub fn from_polynomial(x: [f64; 2], y: [f64; 2], terms: &[Vec<f64>]) -> Option<Self> {
        // Trailing zeros would only raise the degree.
        let used = |row: &Vec<f64>| row.iter().rposition(|c| *c != 0.0);
        let p = terms.iter().rposition(|row| used(row).is_some()).unwrap_or(0).max(1);
        let q = terms.iter().filter_map(used).max().unwrap_or(0).max(1);
        if p > MAX_DEGREE || q > MAX_DEGREE {
            return None;
        }
        let along_x = bernstein_of_powers(x, p);
        let along_y = bernstein_of_powers(y, q);
        let height = |k: usize, l: usize| {
            let mut sum = 0.0;
            for (row, powers_x) in terms.iter().zip(&along_x) {
                let inner: f64 = row.iter().zip(&along_y).map(|(c, powers_y)| c * powers_y[l]).sum();
                sum += inner * powers_x[k];
            }
            sum
        };
        let heights: Vec<Vec<f64>> = (0..=q).map(|l| (0..=p).map(|k| height(k, l)).collect()).collect();
        Self::from_heights(x, y, &heights)
    }
}

/// Row i: the Bernstein coefficients of degree n of x^i, where x = middle + half s runs over `ends` with s in [-1, 1].
fn bernstein_of_powers(ends: [f64; 2], n: usize) -> Vec<Vec<f64>> {
    let middle = 0.5 * (ends[0] + ends[1]);
    let half = 0.5 * (ends[1] - ends[0]);
    let centred = bernstein_of_centred_powers(n);
    // x^i = sum over k of choose(i, k) middle^(i-k) half^k s^k, row by row from x^i = x^(i-1) (middle + half s).
    let mut expansion = vec![0.0; n + 1];
    expansion[0] = 1.0;
    let mut rows = Vec::with_capacity(n + 1);
    for _ in 0..=n {
        let coefficient = |k: usize| expansion.iter().zip(&centred).map(|(e, row)| e * row[k]).sum();
        rows.push((0..=n).map(coefficient).collect());
        for k in (0..=n).rev() {
            let shifted = if k > 0 { half * expansion[k - 1] } else { 0.0 };
            expansion[k] = middle * expansion[k] + shifted;
        }
    }
    rows
}

/// Row i: the Bernstein coefficients of degree n of s^i over s in [-1, 1]. With w = 1 - u they are those of
/// (u - w)^i (u + w)^(n - i): ratios of small integers, so that row i is exactly even or odd.
fn bernstein_of_centred_powers(n: usize) -> Vec<Vec<f64>> {
    let numerators = |minus: usize| {
        let mut row = vec![0_i64; n + 1];
        row[0] = 1;
        for factor in 0..n {
            let sign = if factor < minus { -1 } else { 1 };
            for k in (0..=n).rev() {
                row[k] = sign * row[k] + if k > 0 { row[k - 1] } else { 0 };
            }
        }
        row
    };
    let binomials = numerators(0);
    let ratio = |(a, b): (&i64, &i64)| *a as f64 / *b as f64;
    (0..=n).map(|i| numerators(i).iter().zip(&binomials).map(ratio).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn horner(terms: &[Vec<f64>], x: f64, y: f64) -> f64 {
        terms
            .iter()
            .rev()
            .fold(0.0, |sum, row| sum * x + row.iter().rev().fold(0.0, |inner, c| inner * y + c))
    }

    proptest! {
        #[test]
        fn the_net_is_the_polynomial(
            terms in prop::collection::vec(prop::collection::vec(-1.0..1.0_f64, 1..=7), 1..=7),
            x0 in -2.0..2.0_f64, y0 in -2.0..2.0_f64, dx in 0.1..2.0_f64, dy in 0.1..2.0_f64,
            u in 0.0..1.0_f64, v in 0.0..1.0_f64,
        ) {
            let patch = BezierPatch::from_polynomial([x0, x0 + dx], [y0, y0 + dy], &terms).unwrap();
            let point = patch.jet(u, v).point;
            prop_assert!((point.x - (x0 + dx * u)).abs() < 1e-14);
            prop_assert!((point.y - (y0 + dy * v)).abs() < 1e-14);
            let size = horner(&terms.iter().map(|r| r.iter().map(|c| c.abs()).collect()).collect::<Vec<_>>(),
                point.x.abs().max(4.0), point.y.abs().max(4.0));
            prop_assert!((point.z - horner(&terms, point.x, point.y)).abs() < 1e-14 * size);
        }

        #[test]
        fn an_even_polynomial_has_an_exactly_symmetric_net(
            c in prop::collection::vec(-1.0..1.0_f64, 9), half in 0.3..7.0_f64, degree in 1..=6_usize,
        ) {
            let mut terms = vec![vec![0.0; 5]; 2 * (degree / 2) + 3];
            for (k, c) in c.iter().enumerate() {
                let (i, j) = (2 * (k / 3), 2 * (k % 3));
                if i < terms.len() { terms[i][j] = *c; }
            }
            let patch = BezierPatch::from_polynomial([-half, half], [-half, half], &terms).unwrap();
            let [p, q] = patch.degree();
            for i in 0..=p {
                for j in 0..=q {
                    prop_assert_eq!(patch.point(i, j).z.to_bits(), patch.point(p - i, j).z.to_bits());
                    prop_assert_eq!(patch.point(i, j).z.to_bits(), patch.point(i, q - j).z.to_bits());
                    prop_assert_eq!(patch.point(i, j).x, -patch.point(p - i, j).x);
                    prop_assert_eq!(patch.point(i, j).y, -patch.point(i, q - j).y);
                }
            }
        }
    }

    #[test]
    fn a_plane_is_bilinear_and_exactly_flat() {
        let patch = BezierPatch::from_polynomial([-3.0, 5.0], [-1.0, 1.0], &[]).unwrap();
        assert_eq!(patch.degree(), [1, 1]);
        assert!(patch.net().iter().all(|p| p.z == 0.0));
        assert!(patch.is_height_field());
    }

    #[test]
    fn a_paraboloid_has_the_net_of_the_textbook() {
        let terms = [vec![0.0, 0.0, 0.5], vec![], vec![0.5]];
        let patch = BezierPatch::from_polynomial([-1.0, 1.0], [-1.0, 1.0], &terms).unwrap();
        let heights: Vec<f64> = patch.net().iter().map(|p| p.z).collect();
        assert_eq!(heights, [1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0, 1.0]);
    }

    #[test]
    fn a_degree_above_the_largest_is_refused() {
        let mut terms = vec![vec![0.0]; MAX_DEGREE + 2];
        assert!(
            BezierPatch::from_polynomial([0.0, 1.0], [0.0, 1.0], &terms).is_some(),
            "zeros are no degree"
        );
        terms[MAX_DEGREE + 1][0] = 1.0;
        assert!(BezierPatch::from_polynomial([0.0, 1.0], [0.0, 1.0], &terms).is_none());
        assert!(BezierPatch::from_polynomial([0.0, 1.0], [0.0, 1.0], &[vec![f64::INFINITY]]).is_none());
    }
}
