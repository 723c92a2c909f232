//! One surface in several charts: the same points, other parameters.

use ballroom_physics::surface::bezier::BezierPatch;
use nalgebra::Vector3;

/// A polynomial in s and t over [-1, 1]^2: `terms[a][b]` belongs to s^a t^b.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial(Vec<Vec<f64>>);

impl Polynomial {
    /// From its terms.
    pub fn new(terms: &[(usize, usize, f64)]) -> Self {
        let size = |axis: fn(&(usize, usize, f64)) -> usize| terms.iter().map(axis).max().unwrap_or(0) + 1;
        let mut table = vec![vec![0.0; size(|t| t.1)]; size(|t| t.0)];
        for (a, b, c) in terms {
            table[*a][*b] += c;
        }
        Self(table)
    }

    fn degree(&self) -> [usize; 2] {
        [self.0.len() - 1, self.0[0].len() - 1]
    }

    fn times(&self, other: &Self) -> Self {
        let ([p, q], [m, n]) = (self.degree(), other.degree());
        let mut out = vec![vec![0.0; q + n + 1]; p + m + 1];
        for (a, row) in self.0.iter().enumerate() {
            for (b, c) in row.iter().enumerate() {
                for (i, others) in other.0.iter().enumerate() {
                    for (j, d) in others.iter().enumerate() {
                        out[a + i][b + j] += c * d;
                    }
                }
            }
        }
        Self(out)
    }

    fn add(&mut self, other: &Self, factor: f64) {
        let [p, q] = other.degree();
        let columns = self.0[0].len().max(q + 1);
        self.0.resize(self.0.len().max(p + 1), vec![]);
        self.0.iter_mut().for_each(|row| row.resize(columns, 0.0));
        for (row, others) in self.0.iter_mut().zip(&other.0) {
            row.iter_mut().zip(others).for_each(|(c, d)| *c += factor * d);
        }
    }

    fn power(&self, exponent: usize) -> Self {
        (0..exponent).fold(Self::new(&[(0, 0, 1.0)]), |product, _| product.times(self))
    }

    /// Coefficient of `B_i^p(u) B_j^q(v)` with s = 2u - 1, t = 2v - 1.
    fn bernstein(&self, [p, q]: [usize; 2], i: usize, j: usize) -> f64 {
        let (along, across) = (powers(p, i), powers(q, j));
        let rows = self.0.iter().zip(&along);
        rows.map(|(row, f)| f * row.iter().zip(&across).map(|(c, g)| c * g).sum::<f64>()).sum()
    }
}

/// Bernstein coefficient i of degree n of every power of s on [-1, 1], by blossoming: the mean product of so many of i
/// ones and n - i minus ones.
fn powers(n: usize, i: usize) -> Vec<f64> {
    let mut sums = vec![0.0; n + 1];
    sums[0] = 1.0;
    for argument in 0..n {
        let value = if argument < i { 1.0 } else { -1.0 };
        for a in (1..=argument + 1).rev() {
            sums[a] += value * sums[a - 1];
        }
    }
    let mut choices = 1.0;
    for (a, sum) in sums.iter_mut().enumerate() {
        *sum /= choices;
        choices *= (n - a) as f64 / (a + 1) as f64;
    }
    sums
}

/// The heights of a floor over x and y.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// z = sum of `c x^i y^j`.
    Terms(&'static [(usize, usize, f64)]),
    /// Control heights `[i][j]`, i along x, over [-half, half]^2 with the given half.
    Net(f64, Vec<Vec<f64>>),
}

impl Shape {
    /// The patch (x, y, z(x, y)) for x and y as polynomials of the parameters.
    ///
    /// # Panics
    /// If its degree is beyond what a patch may have.
    pub fn over(&self, x: &Polynomial, y: &Polynomial) -> BezierPatch {
        let z = self.compose(x, y);
        let degree = [0, 1].map(|axis| [x, y, &z].map(|p| p.degree()[axis]).into_iter().max().unwrap_or(1));
        let places = (0..=degree[0]).flat_map(|i| (0..=degree[1]).map(move |j| (i, j)));
        let point = |(i, j)| {
            let [x, y, z] = [x, y, &z].map(|p| p.bernstein(degree, i, j));
            Vector3::new(x, y, z)
        };
        BezierPatch::new(degree, places.map(point).collect()).expect("the composed degree is at most 12")
    }

    fn compose(&self, x: &Polynomial, y: &Polynomial) -> Polynomial {
        let mut sum = Polynomial::new(&[]);
        match self {
            Self::Terms(terms) => {
                for (i, j, c) in *terms {
                    sum.add(&x.power(*i).times(&y.power(*j)), *c);
                }
            }
            Self::Net(half, heights) => {
                let (along, across) = (basis(x, *half, heights.len()), basis(y, *half, heights[0].len()));
                for (row, f) in heights.iter().zip(&along) {
                    for (c, g) in row.iter().zip(&across) {
                        sum.add(&f.times(g), *c);
                    }
                }
            }
        }
        sum
    }
}

/// The `count` Bernstein polynomials over [-half, half] as polynomials of the parameters.
fn basis(x: &Polynomial, half: f64, count: usize) -> Vec<Polynomial> {
    let (mut up, mut down) = (Polynomial::new(&[(0, 0, 0.5)]), Polynomial::new(&[(0, 0, 0.5)]));
    up.add(x, 0.5 / half);
    down.add(x, -0.5 / half);
    let mut choices = 1.0;
    let mut out = vec![];
    for i in 0..count {
        let mut one = Polynomial::new(&[]);
        one.add(&up.power(i).times(&down.power(count - 1 - i)), choices);
        out.push(one);
        choices *= (count - 1 - i) as f64 / (i + 1) as f64;
    }
    out
}

/// x or y = half (s + bend (s^2 - 1)): the same ends, another pace. `bend` lies within 1/2.
pub fn bent(half: f64, bend: f64, along_u: bool) -> Polynomial {
    let at = |power: usize, c: f64| if along_u { (power, 0, c) } else { (0, power, c) };
    Polynomial::new(&[at(0, -half * bend), at(1, half), at(2, half * bend)])
}

/// x = half s (1 + lean t) or y = half t (1 + lean s): a trapezium, which holds the square of half (1 - |lean|).
pub fn leaning(half: f64, lean: f64, along_u: bool) -> Polynomial {
    let straight = if along_u { (1, 0, half) } else { (0, 1, half) };
    Polynomial::new(&[straight, (1, 1, half * lean)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_chart_shows_the_same_surface() {
        let shape = Shape::Terms(&[(0, 0, 0.5), (3, 0, 0.25), (1, 2, -0.75), (2, 2, 0.25)]);
        let height = |x: f64, y: f64| 0.5 + 0.25 * x.powi(3) - 0.75 * x * y * y + 0.25 * x * x * y * y;
        let net = Shape::Net(1.5, vec![vec![0.25, -1.0, 2.0], vec![1.0, 0.5, -0.125], vec![0.0, 3.0, 1.0]]);
        let plain = net.over(&bent(1.5, 0.0, true), &bent(1.5, 0.0, false));
        let charts = [
            (bent(1.5, 0.25, true), bent(1.5, -0.2, false)),
            (leaning(1.5, 0.25, true), leaning(1.5, -0.125, false)),
        ];
        for (x, y) in charts {
            let (graph, warped) = (shape.over(&x, &y), net.over(&x, &y));
            for n in 0..=100 {
                let p = graph.jet(f64::from(n % 11) / 10.0, f64::from(n) / 100.0).point;
                assert!((p.z - height(p.x, p.y)).abs() < 1e-14, "{p:?}");
                let p = warped.jet(f64::from(n % 11) / 10.0, f64::from(n) / 100.0).point;
                let seen = plain.jet(p.x / 3.0 + 0.5, p.y / 3.0 + 0.5).point;
                assert!((p - seen).norm() < 1e-13, "{p:?} {seen:?}");
            }
        }
    }
}
