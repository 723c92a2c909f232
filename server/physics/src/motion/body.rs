//! A body: what moves a ball and does not change along an arc, and how it is launched, held and landed.

use super::arc::{Arc, Path, narrow, widen};
use super::dop853::{self, Attempt, Inside};
use super::law::{Law, ROLLING, SLIDING, Stand, State, angular_velocity, velocity};
use super::low_order;
use super::step::{Step, TERMS};
use super::step_size;
use super::take_over::take_over;
use crate::number::Triple;
use crate::scene::{Accuracy, Scheme};
use crate::schedule::time::Time;
use crate::surface::chart::{Chart, FlatChart, Frame, Kernel, Surface, with_chart};
use crate::tolerance;
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// What moves a ball and does not change along an arc.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    /// Radius, m.
    pub radius: f64,
    /// Inertia factor k; 0 when sliding.
    pub inertia_factor: f64,
    /// Whether the ball rolls.
    pub rolls: bool,
    /// Applied acceleration: gravity and the player's, m/s^2.
    pub applied: V3,
}

/// Length of step wanted next, and steps spent.
#[derive(Clone, Copy, Debug)]
pub struct Stepping {
    /// Step to try, s: of few bits, or the scene's fixed step.
    pub try_s: f64,
    /// Steps computed, kept or not.
    pub steps: u64,
    /// Steps kept at the shortest length though their error was too large.
    pub forced: u64,
}

impl Body {
    fn law<'a, C: Chart>(&self, chart: &'a C) -> Law<'a, C, f64> {
        Law {
            chart,
            radius: self.radius,
            inverse_radius: 1.0 / self.radius,
            inertia_factor: self.inertia_factor,
            share: 1.0 / (1.0 + self.inertia_factor),
            applied: self.applied.into(),
        }
    }

    /// Centre and normal at a state.
    #[inline]
    pub fn seat(&self, surface: &Surface, state: &State) -> (V3, V3) {
        match &surface.kernel {
            Kernel::Flat(chart) => self.seat_on(chart, state),
            _ => self.seat_on_any(surface, state),
        }
    }

    #[inline(never)]
    fn seat_on_any(&self, surface: &Surface, state: &State) -> (V3, V3) {
        with_chart!(&surface.kernel, chart => self.seat_on(chart, state))
    }

    /// Centre and normal on one kind of floor.
    #[inline(always)]
    pub(super) fn seat_on<C: Chart>(&self, chart: &C, state: &State) -> (V3, V3) {
        let frame = chart.frame([state[0], state[1]]);
        let n = frame.normal();
        ((frame.point() + n * self.radius).into(), n.into())
    }

    /// Time derivative of a state.
    pub fn slope(&self, surface: &Surface, state: &State) -> State {
        with_chart!(&surface.kernel, chart => {
            let law = self.law(chart);
            if self.rolls { law.slope(state).rate } else { widen(&law.slope(&narrow::<SLIDING>(state)).rate) }
        })
    }

    /// Takes from a state what interpolation put off the tangent plane; returns centre and normal.
    pub fn settle(&self, surface: &Surface, state: &mut State) -> (V3, V3) {
        let (center, n) = self.seat(surface, state);
        let w = velocity(state);
        let w = w - n * w.dot(&n);
        state[2..5].copy_from_slice(w.as_slice());
        (center, n)
    }

    /// State and slope `dt` seconds after `state` on a curved floor.
    pub(super) fn land(
        &self,
        surface: &Surface,
        accuracy: Accuracy,
        state: &State,
        slope: &State,
        dt: f64,
    ) -> (State, State) {
        with_chart!(&surface.kernel, chart => {
            let law = self.law(chart);
            if self.rolls {
                land_by::<ROLLING, _>(&law, accuracy, state, slope, dt)
            } else {
                let (y, s) = land_by::<SLIDING, _>(&law, accuracy, &narrow(state), &narrow(slope), dt);
                (widen(&y), widen(&s))
            }
        })
    }

    /// The arc from `state` at `start`.
    pub fn launch(
        &self,
        surface: &Surface,
        accuracy: Accuracy,
        (start, state): (Time, &State),
        stepping: &mut Stepping,
        arc: &mut Arc,
    ) {
        arc.start = start;
        arc.state = *state;
        if let Kernel::Flat(chart) = &surface.kernel {
            return self.launch_parabola(chart, accuracy, arc);
        }
        self.launch_step(surface, accuracy, state, stepping, arc);
    }

    #[inline(never)]
    fn launch_step(
        &self,
        surface: &Surface,
        accuracy: Accuracy,
        state: &State,
        stepping: &mut Stepping,
        arc: &mut Arc,
    ) {
        with_chart!(&surface.kernel, chart => {
            let law = self.law(chart);
            if self.rolls {
                let first = law.stand(state);
                let (h, step) = step_by::<ROLLING, _>(&law, accuracy, state, &first, stepping);
                take_over(&mut [Some(arc)], &[h], &first.slope.rate, &step, accuracy);
            } else {
                let y = narrow::<SLIDING>(state);
                let first = law.stand(&y);
                let (h, step) = step_by::<SLIDING, _>(&law, accuracy, &y, &first, stepping);
                take_over(&mut [Some(arc)], &[h], &first.slope.rate, &step, accuracy);
            }
        });
    }

    fn launch_parabola(&self, chart: &FlatChart, accuracy: Accuracy, arc: &mut Arc) {
        let (center, n) = self.seat_on(chart, &arc.state);
        let acceleration = (self.applied - n * self.applied.dot(&n)) * (1.0 / (1.0 + self.inertia_factor));
        arc.path = Path::Parabola;
        arc.set_length(f64::INFINITY);
        arc.scale = 1.0;
        arc.set_parabola([center, velocity(&arc.state), acceleration * 0.5]);
        arc.acceleration_bound = acceleration.norm();
        arc.reaction = [-self.applied.dot(&n); 3];
        if self.rolls {
            let mut turn = [V3::zeros(); TERMS];
            turn[1] = angular_velocity(&n, &arc.center[1], arc.state[5], self.radius);
            turn[2] = n.cross(&acceleration) * (0.5 / self.radius);
            arc.turning.begin(turn, tolerance::turn_left_out(accuracy, tolerance::TURN_MAX, self.radius));
            // Orientation under force is a quadrature from the start of the arc; keep it short.
            if arc.acceleration_bound > 0.0 {
                arc.set_length(tolerance::TURN_MAX);
            }
        }
    }

    /// Stands still at `state` for `length` seconds, and goes on spinning about the normal.
    pub fn hold(&self, surface: &Surface, (start, state): (Time, &State), length: f64, arc: &mut Arc) {
        arc.start = start;
        arc.set_length(length);
        arc.scale = 1.0;
        arc.path = Path::Held;
        arc.state = *state;
        arc.state[2..5].fill(0.0);
        let (center, n) = self.seat(surface, state);
        arc.set_parabola([center, V3::zeros(), V3::zeros()]);
        let mut turn = [V3::zeros(); TERMS];
        turn[1] = angular_velocity(&n, &V3::zeros(), state[5], self.radius);
        arc.turning.begin(turn, tolerance::TURN_LEAST);
        arc.acceleration_bound = 0.0;
    }
}

/// One copy for all who step one ball.
#[inline(never)]
fn attempt_alone<const D: usize, C: Chart>(
    (attempt, inside): (&mut Attempt<f64, D>, &mut Inside<f64>),
    law: &Law<'_, C, f64>,
    y: &[f64; D],
    slope: &[f64; D],
    h: f64,
) {
    attempt.run(Some(inside), law, y, slope, h);
}

/// See [`attempt_alone`].
#[inline(never)]
fn finish_alone<const D: usize, C: Chart>(
    (attempt, inside): (&mut Attempt<f64, D>, &mut Inside<f64>),
    law: &Law<'_, C, f64>,
    y: &[f64; D],
    first: &Stand<f64, D>,
    h: f64,
) -> Step<f64, D> {
    attempt.finish(inside, law, y, first, h)
}

fn land_by<const D: usize, C: Chart>(
    law: &Law<'_, C, f64>,
    accuracy: Accuracy,
    y: &[f64; D],
    slope: &[f64; D],
    dt: f64,
) -> ([f64; D], [f64; D]) {
    let end = match accuracy {
        Accuracy::Tolerance(_) | Accuracy::Fixed(Scheme::Dop853, _) => {
            let (mut attempt, mut inside) = (Attempt::new(dt), Inside::new(dt));
            attempt_alone((&mut attempt, &mut inside), law, y, slope, dt);
            return attempt.landed();
        }
        Accuracy::Fixed(Scheme::Rk4, _) => low_order::rk4_land(law, y, slope, dt),
        Accuracy::Fixed(Scheme::Tsit5, _) => low_order::tsit5_land(law, y, slope, dt),
    };
    (end, law.slope(&end).rate)
}

/// One accepted step and its length.
fn step_by<const D: usize, C: Chart>(
    law: &Law<'_, C, f64>,
    accuracy: Accuracy,
    y: &[f64; D],
    first: &Stand<f64, D>,
    stepping: &mut Stepping,
) -> (f64, Step<f64, D>) {
    let tolerance = match accuracy {
        Accuracy::Tolerance(tolerance) => tolerance,
        Accuracy::Fixed(scheme, h) => {
            stepping.steps += 1;
            let step = match scheme {
                Scheme::Rk4 => low_order::rk4_step(law, y, first, h),
                Scheme::Tsit5 => low_order::tsit5_step(law, y, first, h),
                Scheme::Dop853 => {
                    let (mut attempt, mut inside) = (Attempt::new(h), Inside::new(h));
                    attempt_alone((&mut attempt, &mut inside), law, y, &first.slope.rate, h);
                    finish_alone((&mut attempt, &mut inside), law, y, first, h)
                }
            };
            return (h, step);
        }
    };
    let (mut attempt, mut inside) = (Attempt::new(0.0), Inside::new(0.0));
    loop {
        let h = stepping.try_s;
        attempt_alone((&mut attempt, &mut inside), law, y, &first.slope.rate, h);
        let error = dop853::error_estimate(h, first.stretch, first.precession, &attempt.errors());
        match stepping.judge(tolerance, error) {
            Verdict::Kept => return (h, finish_alone((&mut attempt, &mut inside), law, y, first, h)),
            Verdict::Refused => {}
            Verdict::GivenUp => return (h, not_finite()),
        }
    }
}

/// What becomes of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// It is good enough.
    Kept,
    /// A shorter one is to be tried.
    Refused,
    /// Even the shortest holds numbers that are not finite; the launch holds such a ball.
    GivenUp,
}

impl Stepping {
    /// Counts a step of [`Self::try_s`] with this error, and chooses the length of the next. Whether it is kept depends on
    /// nothing else.
    pub(super) fn judge(&mut self, tolerance: f64, error: f64) -> Verdict {
        let h = self.try_s;
        let allowed = tolerance::allowed_error(tolerance, h);
        let smallest = h <= tolerance::STEP_MIN;
        self.steps += 1;
        self.try_s = step_size::next(h, allowed, error);
        // A NaN is refused too.
        if error.is_nan() || (error > allowed && !smallest) {
            return if smallest { Verdict::GivenUp } else { Verdict::Refused };
        }
        self.forced += u64::from(error > allowed);
        Verdict::Kept
    }
}

/// A step of which no number is one.
pub(super) fn not_finite<const D: usize>() -> Step<f64, D> {
    Step {
        end: [f64::NAN; D],
        dense: [[f64::NAN; D]; TERMS],
        center: [Triple([f64::NAN; 3]); TERMS],
        turn: [Triple([f64::NAN; 3]); TERMS],
        reaction: [f64::NAN; 3],
    }
}
