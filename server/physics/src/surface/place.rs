//! Sets a ball on the floor: the chart coordinates of its contact point from what the scene says.

use super::chart::{Chart, Frame, Surface, with_chart};
use crate::scene::Place;

/// Newton steps before a place is given up.
const STEPS_MAX: u32 = 60;

/// Chart coordinates of the contact point of a ball of `radius`, or why there are none on the patch.
pub fn contact(surface: &Surface, place: &Place, radius: f64) -> Result<[f64; 2], &'static str> {
    let q = match place {
        Place::Uv(uv) => surface.chart([uv.x, uv.y]),
        Place::Contact(xy) => {
            let q = solve(surface, [xy.x, xy.y], 0.0, start(surface, [xy.x, xy.y]));
            q.ok_or("no point of the floor lies at this contact place")?
        }
        Place::Center(xy) => solve(surface, [xy.x, xy.y], radius, start(surface, [xy.x, xy.y]))
            .ok_or("no place on the floor puts the ball's centre there")?,
    };
    on_patch(surface, q)
}

/// The same for a ball whose centre has these x and y, looked for around the parameters `uv` first.
pub fn contact_near(
    surface: &Surface,
    center: [f64; 2],
    radius: f64,
    uv: [f64; 2],
) -> Result<[f64; 2], &'static str> {
    let near = solve(surface, center, radius, surface.chart(uv)).map(|q| on_patch(surface, q));
    if let Some(Ok(q)) = near {
        return Ok(q);
    }
    contact(surface, &Place::Center(center.into()), radius)
}

/// Chart coordinates, if they lie on the patch.
fn on_patch(surface: &Surface, q: [f64; 2]) -> Result<[f64; 2], &'static str> {
    let inside = surface.uv(q).iter().all(|x| (-1e-12..=1.0 + 1e-12).contains(x));
    if inside {
        Ok(q)
    } else {
        Err("its contact point lies outside the patch: move it inside the floor's borders")
    }
}

/// The q at which S(q) + radius n(q) has the given x and y: Newton with the exact derivative
/// (1 - radius * Weingarten map) of the offset from `start` on, halved until the residual falls.
fn solve(surface: &Surface, target: [f64; 2], radius: f64, start: [f64; 2]) -> Option<[f64; 2]> {
    let evaluate = |q: [f64; 2]| {
        with_chart!(&surface.kernel, chart => {
            let frame = chart.frame(q);
            let c = frame.point() + frame.normal() * radius;
            let [e, f, g] = frame.first();
            let [l, m, n] = frame.second();
            let area = frame.inverse_area_squared();
            // n_u = -(alpha S_u + beta S_v) with I (alpha, beta) = II e_u.
            let column = |h1: f64, h2: f64, a: f64, b: f64| {
                let (alpha, beta) = ((g * h1 - f * h2) * area, (e * h2 - f * h1) * area);
                frame.combine(a - radius * alpha, b - radius * beta)
            };
            let (du, dv) = (column(l, m, 1.0, 0.0), column(m, n, 0.0, 1.0));
            let [[cx, cy, _], [ux, uy, _], [vx, vy, _]] = [c.0, du.0, dv.0];
            ([cx - target[0], cy - target[1]], [[ux, vx], [uy, vy]])
        })
    };
    let size = |r: [f64; 2]| r[0].abs().max(r[1].abs());
    let mut q = start;
    let (mut residual, mut derivative) = evaluate(q);
    for _ in 0..STEPS_MAX {
        if residual == [0.0; 2] {
            break;
        }
        let [[a, b], [c, d]] = derivative;
        let determinant = a * d - b * c;
        let step = [
            (d * residual[0] - b * residual[1]) / determinant,
            (a * residual[1] - c * residual[0]) / determinant,
        ];
        let mut share = 1.0;
        let better = loop {
            let next = [q[0] - share * step[0], q[1] - share * step[1]];
            let (r, j) = evaluate(next);
            if size(r) < size(residual) {
                break Some((next, r, j));
            }
            share *= 0.5;
            if share < 1e-9 {
                break None;
            }
        };
        let Some(better) = better else { break };
        (q, residual, derivative) = better;
    }
    // What remains is rounding, or there is no such place.
    (size(residual) <= 1e-9 * (1.0 + size(target))).then_some(q)
}

/// The nearest of a coarse lattice of places.
fn start(surface: &Surface, target: [f64; 2]) -> [f64; 2] {
    let mut best = ([0.0; 2], f64::INFINITY);
    for i in 0..=16 {
        for j in 0..=16 {
            let q = surface.chart([f64::from(i) / 16.0, f64::from(j) / 16.0]);
            let [x, y, _] = with_chart!(&surface.kernel, chart => chart.frame(q).point()).0;
            let distance = (x - target[0]).abs().max((y - target[1]).abs());
            if distance < best.1 {
                best = (q, distance);
            }
        }
    }
    best.0
}
