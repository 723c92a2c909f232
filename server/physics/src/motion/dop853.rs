//! Dormand and Prince 8(5,3): one step of order 8 with a dense output of order 7.
//!
//! Twelve stages, one slope at the end and three more for the dense output. The centre's polynomial and the angle turned come from the same formula, since the stages'
//! velocities are the slopes of the centre and of the angle; the centre's ends are set to the exact ones.

use super::dop853_tableau::{A, B, D as DENSE, E3, E5, STAGES, STAGES_DENSE};
use super::law::{Law, ROLLING, Slope, Stand, angular_velocity, velocity};
use super::step::{Step, TERMS, combine};
use crate::surface::chart::Chart;
use crate::tolerance::ERROR_TIME;
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// The stages of one step: states are needed for their velocities only.
struct Stages<const D: usize> {
    slope: [[f64; D]; STAGES_DENSE],
    velocity: [V3; STAGES_DENSE],
    omega: [V3; STAGES_DENSE],
}

impl<const D: usize> Stages<D> {
    #[inline]
    fn enter(&mut self, stage: usize, y: &[f64; D], radius: f64, slope: &Slope<D>) {
        self.slope[stage] = slope.rate;
        self.velocity[stage] = velocity(y);
        if D == ROLLING {
            self.omega[stage] = angular_velocity(&slope.normal, &self.velocity[stage], y[5], radius);
        }
    }
}

/// `stage!(s, law, y, h, i; j ...)`: stage i from the stages j with weights A[i][j].
macro_rules! stage {
    ($s:ident, $law:ident, $y:ident, $h:ident, $i:literal; $($j:literal)+) => {{
        let at = combine($y, $h, [$((A[$i][$j], &$s.slope[$j])),+]);
        let slope = $law.slope(&at);
        $s.enter($i, &at, $law.radius, &slope);
        slope.reaction
    }};
}

/// Stages 1 to 11 after the first, and the state at the end.
#[inline]
fn advance<const D: usize, C: Chart>(
    law: &Law<'_, C>,
    y: &[f64; D],
    slope: &[f64; D],
    h: f64,
) -> (Stages<D>, [f64; D]) {
    let mut s = Stages {
        slope: [[0.0; D]; STAGES_DENSE],
        velocity: [V3::zeros(); STAGES_DENSE],
        omega: [V3::zeros(); STAGES_DENSE],
    };
    s.slope[0] = *slope;
    stage!(s, law, y, h, 1; 0);
    stage!(s, law, y, h, 2; 0 1);
    stage!(s, law, y, h, 3; 0 2);
    stage!(s, law, y, h, 4; 0 2 3);
    stage!(s, law, y, h, 5; 0 3 4);
    stage!(s, law, y, h, 6; 0 3 4 5);
    stage!(s, law, y, h, 7; 0 3 4 5 6);
    stage!(s, law, y, h, 8; 0 3 4 5 6 7);
    stage!(s, law, y, h, 9; 0 3 4 5 6 7 8);
    stage!(s, law, y, h, 10; 0 3 4 5 6 7 8 9);
    stage!(s, law, y, h, 11; 0 3 4 5 6 7 8 9 10);
    let k = &s.slope;
    let end = combine(
        y,
        h,
        [
            (B[0], &k[0]),
            (B[5], &k[5]),
            (B[6], &k[6]),
            (B[7], &k[7]),
            (B[8], &k[8]),
            (B[9], &k[9]),
            (B[10], &k[10]),
            (B[11], &k[11]),
        ],
    );
    (s, end)
}

/// The state after h, and the slope there to first order: enough to land on an event.
#[inline]
pub fn land<const D: usize, C: Chart>(
    law: &Law<'_, C>,
    y: &[f64; D],
    slope: &[f64; D],
    h: f64,
) -> ([f64; D], [f64; D]) {
    let (stages, end) = advance(law, y, slope, h);
    (end, stages.slope[STAGES - 1])
}

/// A whole step with error estimate, or the estimate alone when it exceeds `allowed` or is no number (the dense output is
/// not computed).
#[inline]
pub fn step<const D: usize, C: Chart>(
    law: &Law<'_, C>,
    y: &[f64; D],
    first: &Stand<D>,
    h: f64,
    allowed: f64,
) -> Result<Step<D>, f64> {
    let (mut s, end) = advance(law, y, &first.slope.rate, h);
    let error = error_estimate(first, h, &s.slope);
    // A NaN is refused too.
    if error.is_nan() || error > allowed {
        return Err(error);
    }
    let last = law.stand(&end);
    s.enter(12, &end, law.radius, &last.slope);
    stage!(s, law, y, h, 13; 0 6 7 8 9 10 11 12);
    stage!(s, law, y, h, 14; 0 5 6 7 10 11 12 13);
    let reaction_inside = stage!(s, law, y, h, 15; 0 5 6 7 8 12 13 14);
    s.enter(0, y, law.radius, &first.slope);
    let rise = std::array::from_fn(|i| end[i] - y[i]);
    let dense = dense_output(h, y, &rise, &s.slope);
    let center = dense_path(h, first.center, last.center - first.center, &s.velocity);
    let mut turn = [V3::zeros(); TERMS];
    if D == ROLLING {
        let rise =
            [0, 5, 6, 7, 8, 9, 10, 11].iter().fold(V3::zeros(), |sum, i| sum + s.omega[*i] * B[*i]) * h;
        turn = dense_path(h, V3::zeros(), rise, &s.omega);
    }
    Ok(Step {
        end,
        error,
        dense,
        center,
        turn,
        reaction: [first.slope.reaction, reaction_inside, last.slope.reaction],
    })
}

/// The error of the solution in metres, from Hairer's estimates of order 5 and 3: an error of velocity counts with
/// [`ERROR_TIME`], or with the time of a turn by the spin where that is less.
///
/// One is to the other as h^2: `five * trust` goes with h^8 as in the source, and with one more square root of `trust` it
/// would go with h^9 as the error itself. Half way between keeps what is obtained nearest to what is asked for from 1e-6 to
/// 1e-12 m: errors of place grow with the number of steps, those of energy faster.
#[inline]
fn error_estimate<const D: usize>(first: &Stand<D>, h: f64, k: &[[f64; D]; STAGES_DENSE]) -> f64 {
    let [e, g] = first.stretch;
    let turn = ERROR_TIME * first.precession;
    let time_squared = ERROR_TIME * ERROR_TIME / (1.0 + turn * turn);
    let [five, three] = [&E5, &E3].map(|weights| {
        let mut sum = [0.0; D];
        for i in [0, 5, 6, 7, 8, 9, 10, 11] {
            for x in 0..D {
                sum[x] += weights[i] * k[i][x];
            }
        }
        let place = e * sum[0] * sum[0] + g * sum[1] * sum[1];
        let mut speed = sum[2] * sum[2] + sum[3] * sum[3] + sum[4] * sum[4];
        if D == ROLLING {
            speed = speed.max(sum[5] * sum[5]);
        }
        place.max(speed * time_squared)
    });
    if five == 0.0 {
        return 0.0;
    }
    let trust = (five / (five + 0.01 * three)).sqrt();
    h * five.sqrt() * trust * trust.sqrt().sqrt()
}

/// The dense output of a point whose slopes are `slopes`.
fn dense_path(h: f64, start: V3, rise: V3, slopes: &[V3; STAGES_DENSE]) -> [V3; TERMS] {
    let slopes = slopes.map(|s| [s.x, s.y, s.z]);
    let dense = dense_output(h, &[start.x, start.y, start.z], &[rise.x, rise.y, rise.z], &slopes);
    dense.map(|c| V3::new(c[0], c[1], c[2]))
}

/// The dense output in powers of theta. The source gives it nested in theta and 1 - theta; expanded here.
#[inline]
fn dense_output<const D: usize>(
    h: f64,
    y: &[f64; D],
    rise: &[f64; D],
    k: &[[f64; D]; STAGES_DENSE],
) -> [[f64; D]; TERMS] {
    let mut tail = [[0.0; D]; 4];
    for (t, weights) in tail.iter_mut().zip(&DENSE) {
        for i in [0, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15] {
            for x in 0..D {
                t[x] += weights[i] * k[i][x];
            }
        }
    }
    let mut out = [[0.0; D]; TERMS];
    for x in 0..D {
        let f0 = rise[x];
        let f1 = h * k[0][x] - f0;
        let f2 = 2.0 * f0 - h * (k[12][x] + k[0][x]);
        let [f3, f4, f5, f6] = [h * tail[0][x], h * tail[1][x], h * tail[2][x], h * tail[3][x]];
        out[0][x] = y[x];
        out[1][x] = f0 + f1;
        out[2][x] = (f2 - f1) + f3;
        out[3][x] = (f4 + f5) - (f2 + 2.0 * f3);
        out[4][x] = (f3 + f6) - (2.0 * f4 + 3.0 * f5);
        out[5][x] = (f4 + 3.0 * f5) - 3.0 * f6;
        out[6][x] = 3.0 * f6 - f5;
        out[7][x] = -f6;
    }
    out
}
