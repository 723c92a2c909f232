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

use crate::surface::chart::{Chart, Frame};
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// Numbers in a sliding ball's state: q, w.
pub const SLIDING: usize = 5;
/// Numbers in a rolling ball's state: q, w, sigma.
pub const ROLLING: usize = 6;

/// A ball's state as numbers; a sliding ball uses the first [`SLIDING`].
pub type State = [f64; ROLLING];

/// The velocity in a state.
#[inline]
pub fn velocity<const D: usize>(y: &[f64; D]) -> V3 {
    V3::new(y[2], y[3], y[4])
}

/// Angular velocity of a rolling ball with floor normal `n`, rad/s.
#[inline]
pub fn angular_velocity(n: &V3, w: &V3, sigma: f64, radius: f64) -> V3 {
    (n * sigma + n.cross(w)) * (1.0 / radius)
}

/// What the right-hand side gives.
#[derive(Clone, Copy, Debug)]
pub struct Slope<const D: usize> {
    /// Time derivative of the state.
    pub rate: [f64; D],
    /// The floor's reaction per mass, m/s^2.
    pub reaction: f64,
    /// The floor's normal.
    pub normal: V3,
}

/// Where a step begins or ends.
#[derive(Clone, Copy, Debug)]
pub struct Stand<const D: usize> {
    /// The right-hand side there.
    pub slope: Slope<D>,
    /// The ball's centre, m.
    pub center: V3,
    /// E and G of the floor's first fundamental form.
    pub stretch: [f64; 2],
    /// Mean rate at which a ball's spin turns its velocity round on the curved floor, k sigma H / (1+k), rad/s; 0 when sliding.
    pub precession: f64,
}

/// One ball's right-hand side.
#[derive(Clone, Copy, Debug)]
pub struct Law<'a, C> {
    /// The floor.
    pub chart: &'a C,
    /// Radius, m.
    pub radius: f64,
    /// Inertia factor k; 0 for a sliding ball.
    pub inertia_factor: f64,
    /// Applied acceleration at the centre: gravity and the player's, m/s^2.
    pub applied: V3,
}

impl<C: Chart> Law<'_, C> {
    /// The right-hand side at a state of `D` numbers.
    #[inline]
    pub fn slope<const D: usize>(&self, y: &[f64; D]) -> Slope<D> {
        self.slope_in(&self.chart.frame([y[0], y[1]]), y)
    }

    /// The right-hand side and the ball's centre.
    #[inline]
    pub fn stand<const D: usize>(&self, y: &[f64; D]) -> Stand<D> {
        let frame = self.chart.frame([y[0], y[1]]);
        let slope = self.slope_in(&frame, y);
        let [e, f, g] = frame.first();
        let mut precession = 0.0;
        if D == ROLLING {
            let [l, m, n] = frame.second();
            let mean_curvature = 0.5 * (e * n - 2.0 * f * m + g * l) * frame.inverse_area_squared();
            precession = self.inertia_factor * y[5] * mean_curvature / (1.0 + self.inertia_factor);
        }
        Stand { slope, center: frame.point() + slope.normal * self.radius, stretch: [e, g], precession }
    }

    #[inline]
    fn slope_in<const D: usize>(&self, frame: &C::Frame, y: &[f64; D]) -> Slope<D> {
        let w = velocity(y);
        let n = frame.normal();
        let r = self.radius;
        let [e, f, g] = frame.first();
        let [l, m, nn] = frame.second();
        let (a, b, d) = (e - r * l, f - r * m, g - r * nn);
        let inverse = 1.0 / (a * d - b * b);
        let [p, q] = frame.along(&w);
        let du = (d * p - b * q) * inverse;
        let dv = (a * q - b * p) * inverse;
        let h1 = l * du + m * dv;
        let h2 = m * du + nn * dv;
        let area = frame.inverse_area_squared();
        let alpha = (g * h1 - f * h2) * area;
        let beta = (e * h2 - f * h1) * area;
        let n_dot = -frame.combine(alpha, beta);
        let pressing = self.applied.dot(&n);
        let turning = n_dot.dot(&w);
        let reaction = -pressing - turning;
        let tangential = self.applied - n * pressing;
        let mut out = [0.0; D];
        out[0] = du;
        out[1] = dv;
        if D < ROLLING {
            let dw = tangential - n * turning;
            out[2..5].copy_from_slice(dw.as_slice());
            return Slope { rate: out, reaction, normal: n };
        }
        let k = self.inertia_factor;
        let sigma = y[5];
        let across = n.cross(&n_dot);
        let dw = (tangential + across * (k * sigma)) * (1.0 / (1.0 + k)) - n * turning;
        out[2..5].copy_from_slice(dw.as_slice());
        // n.(w x n') = -w.(n x n')
        out[5] = -w.dot(&across);
        Slope { rate: out, reaction, normal: n }
    }
}
