//! Several balls' steps side by side: a single right-hand side waits for its own results most of the time, and as many
//! balls as the machine has lanes take hardly longer than one. Every bit is that of the ball alone.

use super::arc::{Arc, Path, widen};
use super::body::{Body, Stepping, Verdict, not_finite};
use super::dop853;
use super::law::{Law, ROLLING, SLIDING, State};
use super::step::{Step, TERMS};
use crate::lanes::{LANES_MAX, Lanes};
use crate::number::Triple;
use crate::scene::{Accuracy, Scheme};
use crate::surface::chart::{Chart, Frame, Surface, with_chart};
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

type V3 = Vector3<f64>;

/// How many balls are computed side by side on this machine.
pub fn lanes() -> usize {
    struct Count;
    impl WithSimd for Count {
        type Output = usize;
        #[inline(always)]
        fn with_simd<S: Simd>(self, _: S) -> usize {
            S::F64_LANES
        }
    }
    Arch::new().dispatch(Count)
}

/// A ball to be launched from its arc's `start` and `state`; see [`Body::launch`].
#[derive(Debug)]
pub struct Launch<'a> {
    /// What moves it.
    pub body: &'a Body,
    /// Its steps.
    pub stepping: &'a mut Stepping,
    /// Where it starts, and what comes of it.
    pub arc: &'a mut Arc,
}

/// Launches all, side by side where that pays.
pub fn launch(surface: &Surface, accuracy: Accuracy, balls: &mut [Launch<'_>]) {
    let alike = balls.iter().all(|ball| ball.body.rolls == balls[0].body.rolls);
    match accuracy {
        Accuracy::Tolerance(tolerance) if alike && balls.len() > 1 && !surface.is_flat() => {
            Arch::new().dispatch(Launching { surface, tolerance, accuracy, balls });
        }
        _ => balls.iter_mut().for_each(|ball| launch_alone(surface, accuracy, ball)),
    }
}

fn launch_alone(surface: &Surface, accuracy: Accuracy, ball: &mut Launch<'_>) {
    let (start, state) = (ball.arc.start, ball.arc.state);
    ball.body.launch(surface, accuracy, (start, &state), ball.stepping, ball.arc);
}

struct Launching<'a, 'b> {
    surface: &'a Surface,
    tolerance: f64,
    accuracy: Accuracy,
    balls: &'a mut [Launch<'b>],
}

impl WithSimd for Launching<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { surface, tolerance, accuracy, balls } = self;
        with_chart!(&surface.kernel, chart => {
            for balls in balls.chunks_mut(S::F64_LANES) {
                if !pays(chart) || balls.len() == 1 {
                    balls.iter_mut().for_each(|ball| launch_alone(surface, accuracy, ball));
                } else if balls[0].body.rolls {
                    launch_lanes::<ROLLING, _, S>(simd, chart, (tolerance, accuracy), balls);
                } else {
                    launch_lanes::<SLIDING, _, S>(simd, chart, (tolerance, accuracy), balls);
                }
            }
        });
    }
}

/// The law of several balls; lanes beyond the last ball repeat it.
#[inline(always)]
fn law_of<'a, 'b, C: Chart, S: Simd>(
    simd: S,
    chart: &'a C,
    body: impl Fn(usize) -> &'b Body,
) -> Law<'a, C, Lanes<S>> {
    Law {
        chart,
        radius: Lanes::new(simd, |lane| body(lane).radius),
        inverse_radius: Lanes::new(simd, |lane| 1.0 / body(lane).radius),
        inertia_factor: Lanes::new(simd, |lane| body(lane).inertia_factor),
        share: Lanes::new(simd, |lane| 1.0 / (1.0 + body(lane).inertia_factor)),
        applied: Triple([0, 1, 2].map(|axis| Lanes::new(simd, |lane| body(lane).applied[axis]))),
    }
}

/// Every ball's next step that is kept; those refused try again, side by side as well.
#[inline(always)]
fn launch_lanes<const D: usize, C: Chart, S: Simd>(
    simd: S,
    chart: &C,
    (tolerance, accuracy): (f64, Accuracy),
    balls: &mut [Launch<'_>],
) {
    let count = balls.len();
    let of = |lane: usize| lane.min(count - 1);
    let law = law_of(simd, chart, |lane| balls[of(lane)].body);
    let mut y = [law.radius; D];
    for i in 0..D {
        y[i] = Lanes::new(simd, |lane| balls[of(lane)].arc.state[i]);
    }
    let first = law.stand(&y);
    let mut waiting = [false; LANES_MAX];
    waiting[..count].fill(true);
    while waiting.contains(&true) {
        let h = Lanes::new(simd, |lane| balls[of(lane)].stepping.try_s);
        let attempt = dop853::attempt(&law, &y, &first.slope.rate, h);
        let errors = attempt.errors();
        let mut kept = [false; LANES_MAX];
        for lane in 0..count {
            if !waiting[lane] {
                continue;
            }
            let stretch = numbers(&first.stretch, lane);
            let errors = [numbers(&errors[0], lane), numbers(&errors[1], lane)];
            let error = dop853::error_estimate(h.lane(lane), stretch, first.precession.lane(lane), errors);
            let ball = &mut balls[lane];
            let verdict = ball.stepping.judge(tolerance, error);
            if verdict == Verdict::GivenUp {
                ball.arc.fill::<D>(h.lane(lane), &[f64::NAN; D], &not_finite(), accuracy);
            }
            kept[lane] = verdict == Verdict::Kept;
            waiting[lane] = verdict == Verdict::Refused;
        }
        if kept.contains(&true) {
            let step = dop853::finish(&law, &y, &first, h, attempt);
            for lane in (0..count).filter(|lane| kept[*lane]) {
                let slope = numbers(&first.slope.rate, lane);
                balls[lane].arc.fill(h.lane(lane), &slope, &step_of(&step, lane), accuracy);
            }
        }
    }
}

/// One ball's step.
#[inline(always)]
fn step_of<const D: usize, S: Simd>(step: &Step<Lanes<S>, D>, lane: usize) -> Step<f64, D> {
    let mut out = not_finite();
    out.end = numbers(&step.end, lane);
    out.reaction = numbers(&step.reaction, lane);
    for power in 0..TERMS {
        out.dense[power] = numbers(&step.dense[power], lane);
        out.center[power] = Triple(numbers(&step.center[power].0, lane));
        out.turn[power] = Triple(numbers(&step.turn[power].0, lane));
    }
    out
}

/// One ball's numbers.
#[inline(always)]
fn numbers<const N: usize, S: Simd>(of: &[Lanes<S>; N], lane: usize) -> [f64; N] {
    let mut out = [0.0; N];
    for i in 0..N {
        out[i] = of[i].lane(lane);
    }
    out
}

/// Where a ball is on its arc, integrated afresh; see [`Arc::land`].
#[derive(Clone, Copy, Debug)]
pub struct Landing {
    /// Its state.
    pub state: State,
    /// The slope there to first order.
    pub slope: State,
    /// Its centre, m.
    pub center: V3,
    /// The floor's normal.
    pub normal: V3,
}

/// Two balls on their arcs, each so many seconds after its start.
pub fn land(surface: &Surface, accuracy: Accuracy, balls: [(&Body, &Arc, f64); 2]) -> [Landing; 2] {
    let by_lanes = matches!(accuracy, Accuracy::Tolerance(_) | Accuracy::Fixed(Scheme::Dop853, _));
    let alike = balls[0].0.rolls == balls[1].0.rolls;
    let inside = balls.iter().all(|(_, arc, dt)| arc.path == Path::Curved && *dt > 0.0);
    if by_lanes && alike && inside {
        return Arch::new().dispatch(LandingPair { surface, accuracy, balls });
    }
    balls.map(|ball| land_alone(surface, accuracy, ball))
}

fn land_alone(surface: &Surface, accuracy: Accuracy, (body, arc, dt): (&Body, &Arc, f64)) -> Landing {
    let (state, slope) = arc.land(body, surface, accuracy, dt);
    let (center, normal) = body.seat(surface, &state);
    Landing { state, slope, center, normal }
}

struct LandingPair<'a> {
    surface: &'a Surface,
    accuracy: Accuracy,
    balls: [(&'a Body, &'a Arc, f64); 2],
}

impl WithSimd for LandingPair<'_> {
    type Output = [Landing; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Landing; 2] {
        let Self { surface, accuracy, balls } = self;
        with_chart!(&surface.kernel, chart => {
            if !pays(chart) || S::F64_LANES == 1 {
                balls.map(|ball| land_alone(surface, accuracy, ball))
            } else if balls[0].0.rolls {
                land_lanes::<ROLLING, _, S>(simd, chart, balls)
            } else {
                land_lanes::<SLIDING, _, S>(simd, chart, balls)
            }
        })
    }
}

/// Whether a chart has kernels for several balls.
#[inline(always)]
const fn pays<C: Chart>(_: &C) -> bool {
    C::SIDE_BY_SIDE
}

#[inline(always)]
fn land_lanes<const D: usize, C: Chart, S: Simd>(
    simd: S,
    chart: &C,
    balls: [(&Body, &Arc, f64); 2],
) -> [Landing; 2] {
    let of = |lane: usize| balls[lane.min(1)];
    let law = law_of(simd, chart, |lane| of(lane).0);
    let (mut y, mut slope) = ([law.radius; D], [law.radius; D]);
    for i in 0..D {
        y[i] = Lanes::new(simd, |lane| of(lane).1.state[i]);
        slope[i] = Lanes::new(simd, |lane| of(lane).1.slope[i]);
    }
    let h = Lanes::new(simd, |lane| of(lane).2);
    let (end, slope) = dop853::land(&law, &y, &slope, h);
    let frame = chart.frame([end[0], end[1]]);
    let normal = frame.normal();
    let center = frame.point() + normal * law.radius;
    [0, 1].map(|lane| Landing {
        state: widen(&numbers(&end, lane)),
        slope: widen(&numbers(&slope, lane)),
        center: numbers(&center.0, lane).into(),
        normal: numbers(&normal.0, lane).into(),
    })
}
