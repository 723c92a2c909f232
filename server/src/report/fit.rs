//! Straight lines through points, by least squares.

/// A line y = `slope` x + `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Rise over run.
    pub slope: f64,
    /// At x = 0.
    pub offset: f64,
    /// Largest distance of any point from it, along y.
    pub residual: f64,
}

/// The line nearest to at least two points, by the squares of the distances along y.
pub fn line(points: &[[f64; 2]]) -> Option<Line> {
    let count = points.len() as f64;
    let mean = |i: usize| points.iter().map(|point| point[i]).sum::<f64>() / count;
    let [x, y] = [mean(0), mean(1)];
    let across: f64 = points.iter().map(|point| (point[0] - x).powi(2)).sum();
    let along: f64 = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    let slope = along / across;
    let offset = y - slope * x;
    let residual =
        points.iter().map(|point| (point[1] - slope * point[0] - offset).abs()).fold(0.0, f64::max);
    (across > 0.0 && slope.is_finite()).then_some(Line { slope, offset, residual })
}

/// The power law through points of positive numbers: the line through their logarithms to base 10.
pub fn power_law(points: &[[f64; 2]]) -> Option<Line> {
    line(&points.iter().map(|&[x, y]| [x.log10(), y.log10()]).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_found_and_what_is_off_it_is_told() {
        let exact = [1.0, 2.0, 10.0].map(|x: f64| [x, 3.0 * x.powf(1.5)]);
        let found = power_law(&exact).unwrap();
        assert!((found.slope - 1.5).abs() < 1e-14 && found.residual < 1e-14, "{found:?}");
        assert!((found.offset - 3.0_f64.log10()).abs() < 1e-14);
        let bent = power_law(&[[1.0, 1.0], [10.0, 100.0], [100.0, 100.0]]).unwrap();
        assert!((bent.slope - 1.0).abs() < 1e-14 && (bent.residual - 2.0 / 3.0).abs() < 1e-14, "{bent:?}");
        assert_eq!(line(&[[1.0, 2.0]]), None);
    }
}
