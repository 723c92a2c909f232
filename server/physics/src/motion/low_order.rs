//! Schemes of lower order with a fixed step: the classical Runge-Kutta scheme and Tsitouras 5(4).
//!
//! They are here to be compared with. Tsitouras' coefficients and interpolant: Ch. Tsitouras, "Runge-Kutta
//! pairs of order 5(4) satisfying only the first column simplifying assumption", Comput. Math. Appl. 62 (2011).

use super::law::{Law, ROLLING, Slope, Stand, rotation, velocity_in};
use super::step::{Step, TERMS, combine, cubic_hermite, quintic_hermite};
use crate::number::Triple;
use crate::surface::chart::Chart;

type V3 = Triple<f64>;
/// Nothing.
const ZERO: V3 = Triple([0.0; 3]);

/// Every stage counts.
const ALL: [usize; 6] = [0, 1, 2, 3, 4, 5];

/// The right-hand side as a call: these schemes are compared by their errors, not by their speed.
#[inline(never)]
fn slope<const D: usize, C: Chart>(law: &Law<'_, C, f64>, y: &[f64; D]) -> Slope<f64, D> {
    law.slope(y)
}

/// See [`slope`].
#[inline(never)]
fn stand<const D: usize, C: Chart>(law: &Law<'_, C, f64>, y: &[f64; D]) -> Stand<f64, D> {
    law.stand(y)
}

/// Slopes at the stages, and the angular velocities there: the slopes of the angle turned.
struct Stages<const D: usize, const N: usize> {
    rate: [[f64; D]; N],
    omega: [V3; N],
}

impl<const D: usize, const N: usize> Stages<D, N> {
    fn first(k1: &[f64; D]) -> Self {
        let mut stages = Self { rate: [[0.0; D]; N], omega: [ZERO; N] };
        stages.rate[0] = *k1;
        stages
    }

    /// Evaluates stage `i` from those before it.
    fn enter<C: Chart, const M: usize>(
        &mut self,
        i: usize,
        (law, y, h): (&Law<'_, C, f64>, &[f64; D], f64),
        weights: [f64; M],
    ) {
        let at = combine(y, h, &weights, &self.rate, &ALL[..M]);
        let slope = slope(law, &at);
        self.rate[i] = slope.rate;
        self.omega[i] = turning(law, &at, &slope);
    }

    fn end(&self, y: &[f64; D], h: f64, weights: &[f64; N]) -> [f64; D] {
        combine(y, h, weights, &self.rate, &ALL[..N])
    }
}

/// The angular velocity at a state; zero when sliding.
fn turning<const D: usize, C: Chart>(law: &Law<'_, C, f64>, y: &[f64; D], slope: &Slope<f64, D>) -> V3 {
    if D < ROLLING {
        return ZERO;
    }
    rotation(slope.normal, velocity_in(y), y[5], law.inverse_radius)
}

/// Weights of the classical scheme.
const RK4_B: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];

fn rk4_stages<const D: usize, C: Chart>(
    law: &Law<'_, C, f64>,
    y: &[f64; D],
    k1: &[f64; D],
    h: f64,
) -> (Stages<D, 4>, [f64; D]) {
    let mut k = Stages::first(k1);
    let from = (law, y, h);
    k.enter(1, from, [0.5]);
    k.enter(2, from, [0.0, 0.5]);
    k.enter(3, from, [0.0, 0.0, 1.0]);
    let end = k.end(y, h, &RK4_B);
    (k, end)
}

/// The classical scheme: the state after h.
pub fn rk4_land<const D: usize, C: Chart>(
    law: &Law<'_, C, f64>,
    y: &[f64; D],
    k1: &[f64; D],
    h: f64,
) -> [f64; D] {
    rk4_stages(law, y, k1, h).1
}

/// The classical scheme: a whole step with cubics inside.
pub fn rk4_step<const D: usize, C: Chart>(
    law: &Law<'_, C, f64>,
    y: &[f64; D],
    first: &Stand<f64, D>,
    h: f64,
) -> Step<f64, D> {
    let (mut k, end) = rk4_stages(law, y, &first.slope.rate, h);
    let last = stand(law, &end);
    k.omega[0] = turning(law, y, &first.slope);
    let omega_end = turning(law, &end, &last.slope);
    let rise = RK4_B.iter().zip(k.omega).fold(ZERO, |sum, (b, omega)| sum + omega * *b) * h;
    let turn = cubic_hermite(h, [&[0.0; 3], &rise.0], [&k.omega[0].0, &omega_end.0]);
    let dense = cubic_hermite(h, [y, &end], [&first.slope.rate, &last.slope.rate]);
    finish((y, first), (&end, &last), h, (dense, turn))
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
    law: &Law<'_, C, f64>,
    y: &[f64; D],
    k1: &[f64; D],
    h: f64,
) -> (Stages<D, 6>, [f64; D]) {
    let mut k = Stages::first(k1);
    for (i, weights) in (1..).zip(TSIT5) {
        k.enter(i, (law, y, h), weights);
    }
    let end = k.end(y, h, &TSIT5_B);
    (k, end)
}

/// Tsitouras' scheme: the state after h.
pub fn tsit5_land<const D: usize, C: Chart>(
    law: &Law<'_, C, f64>,
    y: &[f64; D],
    k1: &[f64; D],
    h: f64,
) -> [f64; D] {
    tsit5_stages(law, y, k1, h).1
}

/// Tsitouras' scheme: a whole step with its interpolant of order 4 inside.
pub fn tsit5_step<const D: usize, C: Chart>(
    law: &Law<'_, C, f64>,
    y: &[f64; D],
    first: &Stand<f64, D>,
    h: f64,
) -> Step<f64, D> {
    let (mut k, end) = tsit5_stages(law, y, &first.slope.rate, h);
    let last = stand(law, &end);
    k.omega[0] = turning(law, y, &first.slope);
    let omega_end = turning(law, &end, &last.slope);
    let turn = tsit5_dense(h, &[0.0; 3], &k.omega.map(|o| o.0), &omega_end.0);
    let dense = tsit5_dense(h, y, &k.rate, &last.slope.rate);
    finish((y, first), (&end, &last), h, (dense, turn))
}

/// The interpolant of what begins at `y` with these slopes.
fn tsit5_dense<const D: usize>(
    h: f64,
    y: &[f64; D],
    slopes: &[[f64; D]; 6],
    last: &[f64; D],
) -> [[f64; D]; TERMS] {
    let weights = tsit5_interpolant();
    let mut dense = [[0.0; D]; TERMS];
    dense[0] = *y;
    for power in 0..4 {
        for i in 0..D {
            let mut sum = weights[6][power] * last[i];
            for (w, stage) in weights.iter().zip(slopes) {
                sum += w[power] * stage[i];
            }
            dense[power + 1][i] = h * sum;
        }
    }
    dense
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

/// The step from the states and slopes at its ends, with the state and the angle turned inside.
fn finish<const D: usize>(
    (y, first): (&[f64; D], &Stand<f64, D>),
    (end, last): (&[f64; D], &Stand<f64, D>),
    h: f64,
    (dense, turn): ([[f64; D]; TERMS], [[f64; 3]; TERMS]),
) -> Step<f64, D> {
    let accelerations = [velocity_in(&first.slope.rate), velocity_in(&last.slope.rate)];
    let center =
        quintic_hermite(h, [first.center, last.center], [velocity_in(y), velocity_in(end)], accelerations);
    // Linear between the ends is as good as these schemes.
    let [begin, stop] = [first.slope.reaction, last.slope.reaction];
    let inside = begin + (stop - begin) * super::step::REACTION_AT[1];
    let turn = turn.map(Triple);
    Step { end: *end, dense, center, turn, reaction: [begin, inside, stop] }
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
