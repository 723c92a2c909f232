//! Schemes of lower order with a fixed step: the classical Runge-Kutta scheme and Tsitouras 5(4).
//!
//! They are here to be compared with. Tsitouras' coefficients and interpolant: Ch. Tsitouras, "Runge-Kutta
//! pairs of order 5(4) satisfying only the first column simplifying assumption", Comput. Math. Appl. 62 (2011).

use super::law::{Law, ROLLING, Stand, angular_velocity, velocity};
use super::step::{Step, TERMS, combine, cubic_hermite, quintic_hermite};
use crate::surface::chart::Chart;
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// The classical scheme: the state after h.
pub fn rk4_land<const D: usize, C: Chart>(law: &Law<'_, C>, y: &[f64; D], k1: &[f64; D], h: f64) -> [f64; D] {
    let k2 = law.slope(&combine(y, h, [(0.5, k1)])).rate;
    let k3 = law.slope(&combine(y, h, [(0.5, &k2)])).rate;
    let k4 = law.slope(&combine(y, h, [(1.0, &k3)])).rate;
    combine(y, h, [(1.0 / 6.0, k1), (1.0 / 3.0, &k2), (1.0 / 3.0, &k3), (1.0 / 6.0, &k4)])
}

/// The classical scheme: a whole step with a cubic inside.
pub fn rk4_step<const D: usize, C: Chart>(
    law: &Law<'_, C>,
    y: &[f64; D],
    first: &Stand<D>,
    h: f64,
) -> Step<D> {
    let end = rk4_land(law, y, &first.slope.rate, h);
    finish(law, y, first, h, end, None)
}

/// Stages 1 to 5 of Tsitouras' scheme.
#[allow(clippy::excessive_precision, reason = "as published")]
const TSIT5: [[f64; 5]; 5] = [
    [0.161, 0.0, 0.0, 0.0, 0.0],
    [-0.008_480_655_492_356_989, 0.335_480_655_492_357, 0.0, 0.0, 0.0],
    [2.897_153_057_105_493_5, -6.359_448_489_975_075, 4.362_295_432_869_581_5, 0.0, 0.0],
    [5.325_864_828_439_257, -11.748_883_564_062_828, 7.495_539_342_889_836_5, -0.092_495_066_361_755_25, 0.0],
    [
        5.861_455_442_946_42,
        -12.920_969_317_847_11,
        8.159_367_898_576_159,
        -0.071_584_973_281_401_01,
        -0.028_269_050_394_068_383,
    ],
];

/// Weights of the solution.
#[allow(clippy::excessive_precision, reason = "as published")]
const TSIT5_B: [f64; 6] = [
    0.096_460_766_818_065_23,
    0.01,
    0.479_889_650_414_499_6,
    1.379_008_574_103_742,
    -3.290_069_515_436_081,
    2.324_710_524_099_774,
];

fn tsit5_stages<const D: usize, C: Chart>(
    law: &Law<'_, C>,
    y: &[f64; D],
    k1: &[f64; D],
    h: f64,
) -> ([[f64; D]; 6], [f64; D]) {
    let a = &TSIT5;
    let mut k = [[0.0; D]; 6];
    k[0] = *k1;
    k[1] = law.slope(&combine(y, h, [(a[0][0], &k[0])])).rate;
    k[2] = law.slope(&combine(y, h, [(a[1][0], &k[0]), (a[1][1], &k[1])])).rate;
    k[3] = law.slope(&combine(y, h, [(a[2][0], &k[0]), (a[2][1], &k[1]), (a[2][2], &k[2])])).rate;
    k[4] = law
        .slope(&combine(y, h, [(a[3][0], &k[0]), (a[3][1], &k[1]), (a[3][2], &k[2]), (a[3][3], &k[3])]))
        .rate;
    k[5] = law
        .slope(&combine(
            y,
            h,
            [(a[4][0], &k[0]), (a[4][1], &k[1]), (a[4][2], &k[2]), (a[4][3], &k[3]), (a[4][4], &k[4])],
        ))
        .rate;
    let b = &TSIT5_B;
    let end = combine(
        y,
        h,
        [(b[0], &k[0]), (b[1], &k[1]), (b[2], &k[2]), (b[3], &k[3]), (b[4], &k[4]), (b[5], &k[5])],
    );
    (k, end)
}

/// Tsitouras' scheme: the state after h.
pub fn tsit5_land<const D: usize, C: Chart>(
    law: &Law<'_, C>,
    y: &[f64; D],
    k1: &[f64; D],
    h: f64,
) -> [f64; D] {
    tsit5_stages(law, y, k1, h).1
}

/// Tsitouras' scheme: a whole step with its interpolant of order 4 inside.
pub fn tsit5_step<const D: usize, C: Chart>(
    law: &Law<'_, C>,
    y: &[f64; D],
    first: &Stand<D>,
    h: f64,
) -> Step<D> {
    let (k, end) = tsit5_stages(law, y, &first.slope.rate, h);
    finish(law, y, first, h, end, Some(&k))
}

/// `b_i(theta)` of the interpolant in powers theta^1 to theta^4, expanded from its published factors.
#[allow(clippy::excessive_precision, reason = "as published")]
fn tsit5_interpolant() -> [[f64; 4]; 7] {
    /// c theta^2 (theta - a)(theta - b)
    fn factored(c: f64, a: f64, b: f64) -> [f64; 4] {
        [0.0, c * a * b, -c * (a + b), c]
    }
    /// c theta^2 (theta^2 + a theta + b)
    fn quadratic(c: f64, a: f64, b: f64) -> [f64; 4] {
        [0.0, c * b, c * a, c]
    }
    let (c, r, a, b) = (
        -1.053_088_497_729_021_6,
        1.329_989_018_975_141_2,
        -1.436_402_854_171_635_1,
        0.713_981_691_707_420_9,
    );
    // c theta (theta - r)(theta^2 + a theta + b)
    let first = [-c * r * b, c * (b - r * a), c * (a - r), c];
    [
        first,
        quadratic(0.101_7, -2.196_656_833_824_975_4, 1.294_985_250_737_463_1),
        quadratic(2.490_627_285_651_252_8, -2.385_356_454_720_616_6, 1.578_034_682_080_924_9),
        factored(-16.548_102_889_244_902_7, 1.217_129_272_955_332_44, 0.616_204_060_378_000_89),
        factored(47.379_521_962_819_281_2, 1.203_071_208_372_362_603, 0.658_047_292_653_547_382),
        factored(-34.870_657_861_496_609_7, 1.2, 2.0 / 3.0),
        factored(2.5, 1.0, 0.6),
    ]
}

fn finish<const D: usize, C: Chart>(
    law: &Law<'_, C>,
    y: &[f64; D],
    start: &Stand<D>,
    h: f64,
    end: [f64; D],
    tsit5: Option<&[[f64; D]; 6]>,
) -> Step<D> {
    let stop = law.stand(&end);
    let (first, last) = (&start.slope, &stop.slope);
    let mut dense = cubic_hermite(h, [y, &end], [&first.rate, &last.rate]);
    if let Some(k) = tsit5 {
        let weights = tsit5_interpolant();
        dense = [[0.0; D]; TERMS];
        dense[0] = *y;
        for power in 0..4 {
            for i in 0..D {
                let mut sum = weights[6][power] * last.rate[i];
                for (w, stage) in weights.iter().zip(k) {
                    sum += w[power] * stage[i];
                }
                dense[power + 1][i] = h * sum;
            }
        }
    }
    let (w0, w1) = (velocity(y), velocity(&end));
    let accelerations = [velocity(&first.rate), velocity(&last.rate)];
    let center = quintic_hermite(h, [start.center, stop.center], [w0, w1], accelerations);
    let mut turn = [V3::zeros(); TERMS];
    if D == ROLLING {
        // Linear in between: of the order of the cubic that the state is read from.
        let omega = [
            angular_velocity(&first.normal, &w0, y[5], law.radius),
            angular_velocity(&last.normal, &w1, end[5], law.radius),
        ];
        turn[1] = omega[0] * h;
        turn[2] = (omega[1] - omega[0]) * (0.5 * h);
    }
    // Linear between the ends is as good as these schemes.
    let inside = first.reaction + (last.reaction - first.reaction) * super::step::REACTION_AT[1];
    Step { end, error: 0.0, dense, center, turn, reaction: [first.reaction, inside, last.reaction] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interpolant_ends_at_the_solution() {
        for (i, row) in tsit5_interpolant().iter().enumerate() {
            let at_one: f64 = row.iter().sum();
            let want = TSIT5_B.get(i).copied().unwrap_or(0.0);
            assert!((at_one - want).abs() < 2e-13, "b{i}(1) = {at_one}, weight {want}");
        }
    }
}
