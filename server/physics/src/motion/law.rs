//! The equations of motion of one ball on the floor.
//!
//! State: chart coordinates q of the contact point, velocity w of the centre in space, and for a rolling ball
//! sigma = r omega.n (spin about the normal, m/s). Orientation acts on nothing and is left out. With S(q) the floor, n its
//! normal, I and II its fundamental forms, k the inertia factor, a the applied acceleration, P = 1 - n n^T:
//!
//! ```text
//! (I - r II) q'  = [S_u.w ; S_v.w]              the contact point under a moving centre c = S + r n
//! n'             = -(alpha S_u + beta S_v),     I [alpha; beta] = II q'          (Weingarten)
//! w'             = (P a + k sigma (n x n'))/(1+k) - (n'.w) n
//! sigma'         = n.(w x n')
//! omega          = (sigma n + n x w)/r
//! reaction/mass  = -a.n - n'.w
//! ```
//!
//! Why this form: the contact point cannot leave the surface, only second derivatives of S appear, and k = 0
//! is sliding without friction. It agrees with Newton and Euler's equations under a rolling constraint.

use crate::number::{Number, Triple};
use crate::surface::chart::{Chart, Frame};
use nalgebra::Vector3;

/// Numbers in a sliding ball's state: q, w.
pub const SLIDING: usize = 5;
/// Numbers in a rolling ball's state: q, w, sigma.
pub const ROLLING: usize = 6;

/// A ball's state as numbers; a sliding ball uses the first [`SLIDING`].
pub type State = [f64; ROLLING];

/// The velocity in a state.
#[inline]
pub fn velocity<const D: usize>(y: &[f64; D]) -> Vector3<f64> {
    velocity_in(y).into()
}

/// Angular velocity of a rolling ball with floor normal `n`, rad/s.
#[inline]
pub fn angular_velocity(n: &Vector3<f64>, w: &Vector3<f64>, sigma: f64, radius: f64) -> Vector3<f64> {
    rotation((*n).into(), (*w).into(), sigma, 1.0 / radius).into()
}

/// The velocity in a state.
#[inline(always)]
pub(super) fn velocity_in<T: Number, const D: usize>(y: &[T; D]) -> Triple<T> {
    Triple([y[2], y[3], y[4]])
}

/// Angular velocity of a rolling ball.
#[inline(always)]
pub(super) fn rotation<T: Number>(n: Triple<T>, w: Triple<T>, sigma: T, inverse_radius: T) -> Triple<T> {
    (n * sigma + n.cross(w)) * inverse_radius
}

/// What the right-hand side gives.
#[derive(Clone, Copy, Debug)]
pub struct Slope<T, const D: usize> {
    /// Time derivative of the state.
    pub rate: [T; D],
    /// The floor's reaction per mass, m/s^2.
    pub reaction: T,
    /// The floor's normal.
    pub normal: Triple<T>,
}

/// Where a step begins or ends.
#[derive(Clone, Copy, Debug)]
pub struct Stand<T, const D: usize> {
    /// The right-hand side there.
    pub slope: Slope<T, D>,
    /// The ball's centre, m.
    pub center: Triple<T>,
    /// E and G of the floor's first fundamental form.
    pub stretch: [T; 2],
    /// Mean rate at which a ball's spin turns its velocity round on the curved floor, k sigma H / (1+k), rad/s; 0 when sliding.
    pub precession: T,
}

/// The right-hand side of one ball, or of several side by side.
#[derive(Clone, Copy, Debug)]
pub struct Law<'a, C, T> {
    /// The floor.
    pub chart: &'a C,
    /// Radius, m.
    pub radius: T,
    /// 1 / radius, 1/m.
    pub inverse_radius: T,
    /// Inertia factor k; 0 for a sliding ball.
    pub inertia_factor: T,
    /// 1 / (1 + k).
    pub share: T,
    /// Applied acceleration at the centre: gravity and the player's, m/s^2.
    pub applied: Triple<T>,
}

impl<C: Chart, T: Number> Law<'_, C, T> {
    /// The right-hand side at a state of `D` numbers.
    #[inline(always)]
    pub fn slope<const D: usize>(&self, y: &[T; D]) -> Slope<T, D> {
        self.slope_in(&self.chart.frame([y[0], y[1]]), y)
    }

    /// The right-hand side and the ball's centre.
    #[inline(always)]
    pub fn stand<const D: usize>(&self, y: &[T; D]) -> Stand<T, D> {
        let frame = self.chart.frame([y[0], y[1]]);
        let slope = self.slope_in(&frame, y);
        let [e, f, g] = frame.first();
        let mut precession = self.radius.like(0.0);
        if D == ROLLING {
            let [l, m, n] = frame.second();
            let twice_mean = (e * n - f * m * 2.0 + g * l) * frame.inverse_area_squared();
            precession = self.inertia_factor * self.share * y[5] * twice_mean * 0.5;
        }
        Stand { slope, center: frame.point() + slope.normal * self.radius, stretch: [e, g], precession }
    }

    #[inline(always)]
    fn slope_in<const D: usize>(&self, frame: &C::Frame<T>, y: &[T; D]) -> Slope<T, D> {
        let w = velocity_in(y);
        let n = frame.normal();
        let r = self.radius;
        let [e, f, g] = frame.first();
        let [l, m, nn] = frame.second();
        let (a, b, d) = (e - r * l, f - r * m, g - r * nn);
        let inverse = r.like(1.0) / (a * d - b * b);
        let [p, q] = frame.along(w);
        let du = (d * p - b * q) * inverse;
        let dv = (a * q - b * p) * inverse;
        let h1 = l * du + m * dv;
        let h2 = m * du + nn * dv;
        let area = frame.inverse_area_squared();
        let alpha = (g * h1 - f * h2) * area;
        let beta = (e * h2 - f * h1) * area;
        let n_dot = -frame.combine(alpha, beta);
        let pressing = self.applied.dot(n);
        let turning = n_dot.dot(w);
        let reaction = -pressing - turning;
        let tangential = self.applied - n * pressing;
        let mut rate = [r.like(0.0); D];
        rate[0] = du;
        rate[1] = dv;
        let mut acceleration = tangential;
        if D == ROLLING {
            let across = n.cross(n_dot);
            acceleration = (tangential + across * (self.inertia_factor * y[5])) * self.share;
            // n.(w x n') = -w.(n x n')
            rate[5] = -w.dot(across);
        }
        let Triple([x, y, z]) = acceleration - n * turning;
        (rate[2], rate[3], rate[4]) = (x, y, z);
        Slope { rate, reaction, normal: n }
    }
}
