//! H14, H17 to H21: what floors alone can break.

use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::ride::{Drift, Largest, hits, run};
use crate::scenes::{SOLID, all_bits, as_net, center, contact, graph, moving, plane, still};
use ballroom_physics::surface::bezier::BezierPatch;
use ballroom_physics::{BallSpec, Controller, Floor, MotionLaw, Place, Scene, SceneFault, Time, Wall};
use nalgebra::{Vector2, Vector3};

const GRAVITY: f64 = 9.81;

/// A bowl whose curvature at the bottom is that of the ball, 1/m, times `curvature`.
fn tight_bowl(curvature: f64) -> Scene {
    let mut scene = graph(3.0, &[(2, 0, 0.5 * curvature), (0, 2, 0.5 * curvature)], MotionLaw::Rolling);
    scene.balls = vec![moving("ball", 1.0, contact(0.9, 0.0), 0.0, 0.3)];
    scene
}

/// States that are not finite and relative error of the energy over 20 s.
fn just_fits() -> Result<[f64; 2], SceneFault> {
    let (mut energy, mut lost) = (Drift::default(), 0);
    run(&tight_bowl(0.99), 60, 1200, |_, engine| {
        energy.see(engine.energy());
        lost += u32::from(!engine.ball(0).center.iter().all(|x| x.is_finite()));
    })?;
    Ok([f64::from(lost), energy.value()])
}

/// 1 unless the ball is refused as too large, with a bracket that holds the curvature.
fn does_not_fit(curvature: f64) -> f64 {
    let named = |fault: &SceneFault| match fault {
        SceneFault::TooCurved { ball: 0, lo, hi, .. } => *lo <= curvature && curvature <= *hi,
        _ => false,
    };
    let refused = Controller::new(&tight_bowl(curvature)).is_err_and(|fault| named(&fault));
    f64::from(u8::from(!refused))
}

/// A polynomial in u and v: `[i][j]` belongs to u^i v^j.
type Polynomial = Vec<Vec<f64>>;

fn times(a: &Polynomial, b: &Polynomial) -> Polynomial {
    let mut out = vec![vec![0.0; a[0].len() + b[0].len() - 1]; a.len() + b.len() - 1];
    for (i, row) in a.iter().enumerate() {
        for (j, x) in row.iter().enumerate() {
            for (k, other) in b.iter().enumerate() {
                for (l, y) in other.iter().enumerate() {
                    out[i + k][j + l] += x * y;
                }
            }
        }
    }
    out
}

/// Bernstein coefficient (i, j) of degrees p, q: the sum of C(i,k) C(j,l)/(C(p,k) C(q,l)) times the term u^k v^l.
fn ordinate(terms: &Polynomial, [i, j]: [usize; 2], [p, q]: [usize; 2]) -> f64 {
    let share =
        |i: usize, p: usize, k: usize| (0..k).map(|n| (i - n) as f64 / (p - n) as f64).product::<f64>();
    let mut sum = 0.0;
    for (k, row) in terms.iter().enumerate().take(i + 1) {
        for (l, term) in row.iter().enumerate().take(j + 1) {
            sum += term * share(i, p, k) * share(j, q, l);
        }
    }
    sum
}

/// z = the sum of `c x^i y^j` over [-half, half]^2 as a net in a warped chart: x and y of degree 2 x 1 and 1 x 2 in u and
/// v, with the borders where they were.
fn warped(half: f64, terms: &[(usize, usize, f64)]) -> Floor {
    // x = half (-1 + 2 u + 0.5 u (1 - u)(1 + v)).
    let x = vec![vec![-half, 0.0], vec![2.5 * half, 0.5 * half], vec![-0.5 * half, -0.5 * half]];
    // y = half (-1 + 2 v - 0.25 v (1 - v)(1 + 2 u)).
    let y = vec![vec![-half, 1.75 * half, 0.25 * half], vec![0.0, -0.5 * half, 0.5 * half]];
    let power =
        |base: &Polynomial, n: usize| (0..n).fold(vec![vec![1.0]], |product, _| times(&product, base));
    let degree = [6, 8];
    let mut z = vec![vec![0.0; degree[1] + 1]; degree[0] + 1];
    for (i, j, c) in terms {
        for (row, sum) in times(&power(&x, *i), &power(&y, *j)).iter().zip(&mut z) {
            for (term, sum) in row.iter().zip(sum) {
                *sum += c * term;
            }
        }
    }
    let points = (0..=degree[0]).flat_map(|i| (0..=degree[1]).map(move |j| [i, j]));
    let net = points.map(|at| Vector3::from([&x, &y, &z].map(|terms| ordinate(terms, at, degree)))).collect();
    Floor::Bezier(BezierPatch::new(degree, net).expect("degrees 6 and 8"))
}

/// Largest distance of a ball's centres on a floor and on the same floor in a warped chart over 3 s, m.
fn warp(motion: MotionLaw) -> Result<[f64; 1], SceneFault> {
    const BUMPS: &[(usize, usize, f64)] =
        &[(2, 0, 0.2), (0, 2, 0.15), (1, 1, 0.05), (3, 0, -0.03), (1, 2, 0.02), (2, 2, 0.01), (0, 4, 0.004)];
    let mut straight = graph(3.0, BUMPS, motion);
    let ball = moving("ball", 0.25, contact(1.2, -0.7), -0.4, 1.3);
    straight.balls = vec![BallSpec { spin: -9.0, ..ball }];
    let mut other = Controller::new(&Scene { floor: warped(3.0, BUMPS), ..straight.clone() })?;
    let mut largest = Largest::default();
    run(&straight, 60, 180, |tick, engine| {
        other.advance_to(Time::of_tick(tick, 60));
        largest.see_center(&engine.ball(0), other.ball(0).center);
    })?;
    Ok([largest.value()])
}

/// A ball that rolls along a wall it touches, from end to end and back: hits beside those of the ends, error across.
fn along_a_border(scene: &Scene, seconds: u64) -> Result<[f64; 2], SceneFault> {
    let mut largest = Largest::default();
    let mut ends = 0;
    let mut before = scene.balls[0].velocity.x;
    let engine = run(scene, 64, 64 * seconds, |_, engine| {
        let ball = engine.ball(0);
        largest.see(ball.center.y - 7.5);
        ends += u64::from(ball.velocity.x * before < 0.0);
        before = ball.velocity.x;
    })?;
    Ok([hits(&engine).saturating_sub(ends) as f64, largest.value()])
}

fn along_the_flat_border() -> Result<[f64; 2], SceneFault> {
    let mut scene = plane(8.0);
    scene.balls = vec![moving("ball", 0.5, center(-5.0, 7.5), 1.5, 0.0)];
    along_a_border(&scene, 60)
}

/// In a trough z = x^2/16 the ball turns round by itself, at no end.
fn along_the_curved_border() -> Result<[f64; 2], SceneFault> {
    let mut scene = graph(8.0, &[(2, 0, 0.0625)], MotionLaw::Rolling);
    scene.balls = vec![moving("ball", 0.5, center(-4.0, 7.5), 0.5, 0.0)];
    let mut largest = Largest::default();
    let engine = run(&scene, 60, 3600, |_, engine| largest.see(engine.ball(0).center.y - 7.5))?;
    Ok([hits(&engine) as f64, largest.value()])
}

/// Along a wall that leans by 1 rad, where neither place nor direction can be exact: hits beyond one, error of the centre.
fn along_a_leaning_wall() -> Result<[f64; 2], SceneFault> {
    let (sin, cos) = 1.0_f64.sin_cos();
    let (normal, along) = (Vector2::new(-sin, cos), Vector2::new(cos, sin));
    let mut scene = plane(64.0);
    scene.walls.push(Wall { point: Vector2::new(0.3, -0.2), normal });
    let from = Vector2::new(0.3, -0.2) + normal * 0.5 - along * 20.0;
    scene.balls = vec![moving("ball", 0.5, Place::Center(from), 2.0 * along.x, 2.0 * along.y)];
    let mut largest = Largest::default();
    let engine = run(&scene, 60, 1200, |tick, engine| {
        let exact = from + along * (2.0 * tick as f64 / 60.0);
        largest.see_center(&engine.ball(0), Vector3::new(exact.x, exact.y, 0.5));
    })?;
    Ok([hits(&engine).saturating_sub(1) as f64, largest.value()])
}

/// Numbers of all balls' states that change in `seconds`.
fn changes(scene: &Scene, seconds: f64) -> Result<[f64; 1], SceneFault> {
    let mut engine = Controller::new(scene)?;
    let start = all_bits(&engine);
    let mut changed = 0;
    for part in 1..=4 {
        engine.advance_to(Time::of_seconds(0.25 * seconds * f64::from(part)));
        changed += all_bits(&engine).iter().zip(&start).filter(|(a, b)| a != b).count();
    }
    Ok([changed as f64])
}

fn saddle(motion: MotionLaw) -> Scene {
    graph(4.0, &[(2, 0, 0.25), (0, 2, -0.25)], motion)
}

/// A ball 1e-6 m off a saddle: its way down against r0 cosh(lambda t) with lambda^2 = g K/(1+k), K = kappa/(1 + r kappa).
/// Largest relative error over 3 s, in which the motion stays linear to 1e-8.
fn off_a_saddle(motion: MotionLaw) -> Result<[f64; 1], SceneFault> {
    let (radius, offset, kappa) = (0.2, 1e-6, 0.5);
    let mut scene = saddle(motion);
    scene.balls = vec![still("ball", radius, center(0.0, offset))];
    let k = if motion == MotionLaw::Rolling { SOLID } else { 0.0 };
    let lambda = (GRAVITY * kappa / ((1.0 + radius * kappa) * (1.0 + k))).sqrt();
    let mut largest = Largest::default();
    run(&scene, 60, 180, |tick, engine| {
        let exact = offset * (lambda * tick as f64 / 60.0).cosh();
        largest.see((engine.ball(0).center.xy() - Vector2::new(0.0, exact)).norm() / exact);
    })?;
    Ok([largest.value()])
}

/// B7: a spinning ball 1e-6 m off the top of a hill, sigma `factor` times the threshold 4(1+k)g/(k^2 K) for sigma^2.
/// With z = x + i y: (1+k) z'' = g K z + i k sigma K z', from rest. Largest relative error over 8 s.
fn spin_on_a_hill(factor: f64) -> Result<[f64; 1], SceneFault> {
    let (radius, offset, kappa, k) = (0.2, 1e-6, 0.5, SOLID);
    let curvature = kappa / (1.0 + radius * kappa);
    let sigma = factor * (4.0 * (1.0 + k) * GRAVITY / (k * k * curvature)).sqrt();
    let mut scene = graph(4.0, &[(2, 0, -0.5 * kappa), (0, 2, -0.5 * kappa)], MotionLaw::Rolling);
    scene.balls = vec![BallSpec { spin: sigma / radius, ..still("ball", radius, center(offset, 0.0)) }];
    // z = r0 e^(ipt) (cos qt - i p/q sin qt), p = k sigma K/(2(1+k)), q^2 = p^2 - gK/(1+k).
    let p = k * sigma * curvature / (2.0 * (1.0 + k));
    let square = p * p - GRAVITY * curvature / (1.0 + k);
    let q = square.abs().sqrt();
    let mut largest = Largest::default();
    run(&scene, 60, 480, |tick, engine| {
        let t = tick as f64 / 60.0;
        let (even, odd) = if square > 0.0 {
            ((q * t).cos(), (q * t).sin() * p / q)
        } else {
            ((q * t).cosh(), (q * t).sinh() * p / q)
        };
        let (sin, cos) = (p * t).sin_cos();
        let exact = Vector2::new(even * cos + odd * sin, even * sin - odd * cos) * offset;
        largest.see((engine.ball(0).center.xy() - exact).norm() / exact.norm());
    })?;
    Ok([largest.value()])
}

fn resting(name: &str) -> Scene {
    let mut scene = match name {
        "plane" => graph(8.0, &[], MotionLaw::Rolling),
        "saddle" => saddle(MotionLaw::Rolling),
        _ => graph(8.0, &[(2, 0, 0.125), (0, 2, 0.25)], MotionLaw::Rolling),
    };
    scene.balls = vec![still("a", 0.5, contact(0.0, 0.0))];
    if name == "plane" {
        scene.balls.push(still("b", 0.5, center(1.3, 0.3)));
    }
    if name == "net" { as_net(&scene) } else { scene }
}

/// Needless hits and error of a centre.
type Measure = fn() -> Result<[f64; 2], SceneFault>;

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![];
    let span = Span::Seconds(20.0);
    cases.push(Case::new(
        "H14/0.99",
        "curvature times radius 0.99: runs",
        [Demand::never("states not finite", span), Demand::relative("energy", span, 1e-10)],
        just_fits,
    ));
    for curvature in [1.0, 1.01] {
        cases.push(Case::new(
            format!("H14/{curvature}"),
            format!("curvature times radius {curvature}: is refused by name"),
            [Demand::never("other verdicts", Span::Loads(1))],
            move || Ok([does_not_fit(curvature)]),
        ));
    }
    for (law, motion) in [("slide", MotionLaw::Frictionless), ("roll", MotionLaw::Rolling)] {
        cases.push(Case::new(
            format!("H17/warp-{law}"),
            "one floor in a straight and in a warped chart",
            [Demand::over_ticks("centre", "m", Span::Seconds(3.0), 1e-11)],
            move || warp(motion),
        ));
        cases.push(Case::new(
            format!("H19/at-rest-{law}"),
            "a ball at rest on a saddle",
            [Demand::never("numbers that change", Span::Seconds(1000.0))],
            move || {
                let balls = vec![still("ball", 0.2, contact(0.0, 0.0))];
                changes(&Scene { balls, ..saddle(motion) }, 1000.0)
            },
        ));
        cases.push(Case::new(
            format!("H19/off-{law}"),
            "a ball 1e-6 m off a saddle: cosh",
            [Demand::over_ticks("centre, relative", "1", Span::Seconds(3.0), 1e-6)],
            move || off_a_saddle(motion),
        ));
    }
    let borders: [(&str, &str, f64, Measure); 3] = [
        ("H18/flat", "along a wall it touches, end to end", 60.0, along_the_flat_border),
        ("H18/curved", "to and fro in a trough along a wall it touches", 60.0, along_the_curved_border),
        ("H18/leaning", "along a touched wall that leans by 1 rad", 20.0, along_a_leaning_wall),
    ];
    for (id, title, seconds, measure) in borders {
        let span = Span::Seconds(seconds);
        let demands = [Demand::never("needless hits", span), Demand::over_ticks("centre", "m", span, 1e-12)];
        cases.push(Case::new(id, title, demands, measure));
    }
    for factor in [0.97, 1.03] {
        cases.push(Case::new(
            format!("H20/{factor}"),
            format!("a ball on a hill, spinning {factor} times as fast as steadies it"),
            [Demand::over_ticks("centre, relative", "1", Span::Seconds(8.0), 1e-6)],
            move || spin_on_a_hill(factor),
        ));
    }
    for name in ["plane", "net", "bowl", "saddle"] {
        let seconds = 1e6;
        cases.push(Case::new(
            format!("H21/{name}"),
            format!("rest where the floor is level: {name}"),
            [Demand::never("numbers that change", Span::Seconds(seconds))],
            move || changes(&resting(name), seconds),
        ));
    }
    cases
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_warped_chart_holds_the_same_floor() {
        let terms = [(2, 0, 0.3), (1, 1, -0.2), (0, 3, 0.1)];
        let Floor::Bezier(patch) = warped(2.0, &terms) else { panic!("a net") };
        for n in 0..=100 {
            let jet = patch.jet(0.01 * f64::from(n), (0.37 * f64::from(n)).fract());
            let [x, y] = [jet.point.x, jet.point.y];
            let z = 0.3 * x * x - 0.2 * x * y + 0.1 * y * y * y;
            assert!((jet.point.z - z).abs() < 1e-14, "{z} at {x}, {y}");
        }
    }
}
