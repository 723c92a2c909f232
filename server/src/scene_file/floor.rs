//! A floor as people write it to a floor as the engine takes it.

use super::{SceneError, SceneText};
use ballroom_physics as physics;
use ballroom_physics::surface::bezier::BezierPatch;
use nalgebra::Vector3;
use protocol::scene::{Floor, Term};

/// The engine's floor. Sizes and numbers have been checked.
pub fn convert(text: &SceneText, floor: &Floor) -> Result<physics::Floor, SceneError> {
    match floor {
        Floor::Grid { x_m, y_m, control_heights_m: rows } => {
            let degree = degree(rows);
            let point = |i: usize, j: usize| {
                Vector3::new(spaced(*x_m, i, degree[0]), spaced(*y_m, j, degree[1]), rows[j][i])
            };
            patch(text, "floor.grid", degree, point)
        }
        Floor::Net { control_points_m: rows } => {
            patch(text, "floor.net", degree(rows), |i, j| Vector3::from(rows[j][i]))
        }
        Floor::Polynomial { x_m, y_m, terms } => {
            Ok(physics::Floor::Polynomial { x: *x_m, y: *y_m, terms: coefficients(terms) })
        }
    }
}

/// Rows run along v, columns along u.
fn degree<T>(rows: &[Vec<T>]) -> [usize; 2] {
    [rows[0].len() - 1, rows.len() - 1]
}

/// Number `i` of `n + 1` evenly spaced ones; multiplying first keeps whole numbers whole.
fn spaced([from, to]: [f64; 2], i: usize, n: usize) -> f64 {
    if i == n { to } else { from + (to - from) * i as f64 / n as f64 }
}

fn patch(
    text: &SceneText,
    field: &str,
    degree: [usize; 2],
    point: impl Fn(usize, usize) -> Vector3<f64>,
) -> Result<physics::Floor, SceneError> {
    let net = (0..=degree[0]).flat_map(|i| (0..=degree[1]).map(move |j| (i, j))).map(|(i, j)| point(i, j));
    let patch = BezierPatch::new(degree, net.collect());
    patch
        .map(physics::Floor::Bezier)
        .ok_or_else(|| text.error(field, "is no patch the engine can take".into()))
}

/// Terms summed into `[power of x][power of y]`.
fn coefficients(terms: &[Term]) -> Vec<Vec<f64>> {
    let most = |power: fn(&Term) -> u32| terms.iter().map(power).max().map_or(0, |p| p as usize + 1);
    let mut sums = vec![vec![0.0; most(|t| t.py)]; most(|t| t.px)];
    for term in terms {
        sums[term.px as usize][term.py as usize] += term.c;
    }
    sums
}
