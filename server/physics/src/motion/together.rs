//! Several balls' steps side by side: a single right-hand side waits for its own results most of the time, and as many
//! balls as the machine has lanes take hardly longer than one. Every bit is that of the ball alone.

use super::arc::{Arc, Path, widen};
use super::body::{Body, Stepping, Verdict, not_finite};
use super::dop853::{self, Attempt, Inside};
use super::law::{Law, ROLLING, SLIDING, State};
use super::look::on_plane;
use super::take_over::take_over;
use crate::lanes::{LANES_MAX, Lanes};
use crate::number::Triple;
use crate::scene::{Accuracy, Scheme};
use crate::surface::chart::{Chart, Frame, Kernel, Surface, with_chart};
use crate::tolerance::STEP_MIN;
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

type V3 = Vector3<f64>;

/// How many balls are computed side by side on this floor and this machine.
pub fn width(surface: &Surface, accuracy: Accuracy) -> usize {
    struct Count;
    impl WithSimd for Count {
        type Output = usize;
        #[inline(always)]
        fn with_simd<S: Simd>(self, _: S) -> usize {
            S::F64_LANES
        }
    }
    let pays = with_chart!(&surface.kernel, chart => pays(chart));
    if pays && matches!(accuracy, Accuracy::Tolerance(_)) { Arch::new().dispatch(Count) } else { 1 }
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

/// Launches all that there are, side by side where that pays.
pub fn launch(surface: &Surface, accuracy: Accuracy, balls: &mut [Option<Launch<'_>>]) {
    match accuracy {
        Accuracy::Tolerance(tolerance) if !surface.is_flat() => {
            Arch::new().dispatch(Launching { surface, tolerance, accuracy, balls });
        }
        _ => launch_alone(surface, accuracy, balls),
    }
}
fn launch_alone(surface: &Surface, accuracy: Accuracy, balls: &mut [Option<Launch<'_>>]) {
    for Launch { body, stepping, arc } in balls.iter_mut().flatten() {
        let (start, state) = (arc.start, arc.state);
        body.launch(surface, accuracy, (start, &state), stepping, arc);
    }
}

struct Launching<'a, 'b> {
    surface: &'a Surface,
    tolerance: f64,
    accuracy: Accuracy,
    balls: &'a mut [Option<Launch<'b>>],
}

impl WithSimd for Launching<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { surface, tolerance, accuracy, balls } = self;
        with_chart!(&surface.kernel, chart => {
            for balls in balls.chunks_mut(S::F64_LANES) {
                let count = balls.iter().flatten().count();
                let rolling = balls.iter().flatten().filter(|ball| ball.body.rolls).count();
                if !pays(chart) || count < 2 || (rolling > 0 && rolling < count) {
                    launch_alone(surface, accuracy, balls);
                } else if rolling > 0 {
                    launch_lanes::<ROLLING, _, S>(simd, chart, (tolerance, accuracy), balls);
                } else {
                    launch_lanes::<SLIDING, _, S>(simd, chart, (tolerance, accuracy), balls);
                }
            }
        });
    }
}

/// The law of several balls.
#[inline(always)]
fn law_of<'a, C: Chart, S: Simd>(simd: S, chart: &'a C, bodies: [&Body; LANES_MAX]) -> Law<'a, C, Lanes<S>> {
    Law {
        chart,
        radius: Lanes::new(simd, |lane| bodies[lane].radius),
        inverse_radius: Lanes::new(simd, |lane| 1.0 / bodies[lane].radius),
        inertia_factor: Lanes::new(simd, |lane| bodies[lane].inertia_factor),
        share: Lanes::new(simd, |lane| 1.0 / (1.0 + bodies[lane].inertia_factor)),
        applied: Triple([
            Lanes::new(simd, |lane| bodies[lane].applied.x),
            Lanes::new(simd, |lane| bodies[lane].applied.y),
            Lanes::new(simd, |lane| bodies[lane].applied.z),
        ]),
    }
}

/// Every ball's next step that is kept; those refused try again, side by side as well. Lanes without a ball repeat one.
#[inline(always)]
fn launch_lanes<const D: usize, C: Chart, S: Simd>(
    simd: S,
    chart: &C,
    (tolerance, accuracy): (f64, Accuracy),
    balls: &mut [Option<Launch<'_>>],
) {
    let Some(one) = balls.iter().flatten().next() else { return };
    let (mut bodies, mut states) = ([one.body; LANES_MAX], [one.arc.state; LANES_MAX]);
    let mut waiting = [false; LANES_MAX];
    for (lane, ball) in balls.iter().flatten().enumerate() {
        (bodies[lane], states[lane], waiting[lane]) = (ball.body, ball.arc.state, true);
    }
    let law = law_of(simd, chart, bodies);
    let mut y = [law.radius; D];
    for i in 0..D {
        y[i] = Lanes::new(simd, |lane| states[lane][i]);
    }
    let first = law.stand(&y);
    let mut tried = [STEP_MIN; LANES_MAX];
    let (mut attempt, mut inside) = (Attempt::new(law.radius), Inside::new(law.radius));
    while waiting.contains(&true) {
        for (lane, ball) in balls.iter().flatten().enumerate() {
            tried[lane] = ball.stepping.try_s;
        }
        let h = Lanes::new(simd, |lane| tried[lane]);
        attempt.run(Some(&mut inside), &law, &y, &first.slope.rate, h);
        let errors = dop853::error_estimate(h, first.stretch, first.precession, &attempt.errors());
        let mut kept = [false; LANES_MAX];
        for (lane, ball) in balls.iter_mut().flatten().enumerate() {
            if !waiting[lane] {
                continue;
            }
            let verdict = ball.stepping.judge(tolerance, errors.lane(lane));
            if verdict == Verdict::GivenUp {
                let arc = &mut [Some(&mut *ball.arc)];
                take_over(arc, &[tried[lane]], &[f64::NAN; D], &not_finite(), accuracy);
            }
            kept[lane] = verdict == Verdict::Kept;
            waiting[lane] = verdict == Verdict::Refused;
        }
        if kept.contains(&true) {
            let step = attempt.finish(&mut inside, &law, &y, &first, h);
            let mut arcs = [const { None }; LANES_MAX];
            for (lane, ball) in balls.iter_mut().flatten().enumerate() {
                arcs[lane] = kept[lane].then_some(&mut *ball.arc);
            }
            take_over(&mut arcs, &tried, &first.slope.rate, &step, accuracy);
        }
    }
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

/// A ball on its arc, `dt` seconds after the start.
#[derive(Clone, Copy, Debug)]
pub struct Seat<'a> {
    /// What moves it.
    pub body: &'a Body,
    /// The arc.
    pub arc: &'a Arc,
    /// Since the start, s.
    pub dt: f64,
}

/// Where a ball is on its arc, integrated afresh; see [`Arc::land`].
#[derive(Clone, Copy, Debug)]
pub struct Landing {
    /// Its state.
    pub state: State,
    /// The slope there to first order (curved arcs only).
    pub slope: State,
    /// Its centre, m.
    pub center: V3,
    /// The floor's normal.
    pub normal: V3,
}

impl Landing {
    /// Of a ball that is not landed yet.
    pub const NOWHERE: Self = Self {
        state: [0.0; ROLLING],
        slope: [0.0; ROLLING],
        center: V3::new(0.0, 0.0, 0.0),
        normal: V3::new(0.0, 0.0, 0.0),
    };
}

/// Lands all `balls`, of which there are as many as `landings`, side by side where that pays.
pub fn land(
    surface: &Surface,
    accuracy: Accuracy,
    balls: &[Option<Seat<'_>>],
    landings: &mut [Option<&mut Landing>],
) {
    let by_lanes = matches!(accuracy, Accuracy::Tolerance(_) | Accuracy::Fixed(Scheme::Dop853, _));
    let mut seats = balls.iter().flatten();
    let rolls = seats.clone().next().is_some_and(|seat| seat.body.rolls);
    let fit = |seat: &Seat<'_>| seat.arc.path == Path::Curved && seat.dt > 0.0 && seat.body.rolls == rolls;
    if by_lanes && balls.len() > 1 && seats.all(fit) {
        Arch::new().dispatch(LandingGroup { surface, accuracy, balls, landings });
    } else {
        land_each(surface, accuracy, balls, landings);
    }
}

fn land_each(
    surface: &Surface,
    accuracy: Accuracy,
    balls: &[Option<Seat<'_>>],
    landings: &mut [Option<&mut Landing>],
) {
    for (seat, landing) in balls.iter().flatten().zip(landings.iter_mut().flatten()) {
        **landing = land_alone(surface, accuracy, *seat);
    }
}

/// Lands one ball.
pub fn land_alone(surface: &Surface, accuracy: Accuracy, seat: Seat<'_>) -> Landing {
    if let Kernel::Flat(chart) = &surface.kernel {
        let (state, center, normal) = on_plane(chart, &seat);
        return Landing { state, slope: [0.0; ROLLING], center, normal };
    }
    let Seat { body, arc, dt } = seat;
    let (state, slope) = arc.land(body, surface, accuracy, dt);
    let (center, normal) = body.seat(surface, &state);
    Landing { state, slope, center, normal }
}

struct LandingGroup<'a, 'b, 'c> {
    surface: &'a Surface,
    accuracy: Accuracy,
    balls: &'a [Option<Seat<'b>>],
    landings: &'a mut [Option<&'c mut Landing>],
}

impl WithSimd for LandingGroup<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { surface, accuracy, balls, landings } = self;
        with_chart!(&surface.kernel, chart => {
            let groups = balls.chunks(S::F64_LANES).zip(landings.chunks_mut(S::F64_LANES));
            for (balls, landings) in groups {
                let Some(Some(one)) = balls.first() else { continue };
                if !pays(chart) || balls.len() == 1 {
                    land_each(surface, accuracy, balls, landings);
                } else if one.body.rolls {
                    land_lanes::<ROLLING, _, S>(simd, chart, *one, (balls, landings));
                } else {
                    land_lanes::<SLIDING, _, S>(simd, chart, *one, (balls, landings));
                }
            }
        });
    }
}

/// Whether a chart has kernels for several balls.
#[inline(always)]
pub(super) const fn pays<C: Chart>(_: &C) -> bool {
    C::SIDE_BY_SIDE
}

/// Lanes without a ball repeat `one`.
#[inline(always)]
fn land_lanes<const D: usize, C: Chart, S: Simd>(
    simd: S,
    chart: &C,
    one: Seat<'_>,
    (balls, landings): (&[Option<Seat<'_>>], &mut [Option<&mut Landing>]),
) {
    let mut seats = [one; LANES_MAX];
    for (seat, ball) in seats.iter_mut().zip(balls.iter().flatten()) {
        *seat = *ball;
    }
    let law = law_of(simd, chart, seats.map(|seat| seat.body));
    let (mut y, mut slope) = ([law.radius; D], [law.radius; D]);
    for i in 0..D {
        y[i] = Lanes::new(simd, |lane| seats[lane].arc.state[i]);
        slope[i] = Lanes::new(simd, |lane| seats[lane].arc.slope[i]);
    }
    let h = Lanes::new(simd, |lane| seats[lane].dt);
    let mut attempt = Attempt::new(h);
    attempt.run(None, &law, &y, &slope, h);
    let (end, slope) = attempt.landed();
    let frame = chart.frame([end[0], end[1]]);
    let normal = frame.normal();
    let center = frame.point() + normal * law.radius;
    for (lane, landing) in landings.iter_mut().flatten().enumerate() {
        landing.state = widen(&numbers(&end, lane));
        landing.slope = widen(&numbers(&slope, lane));
        landing.center = numbers(&center.0, lane).into();
        landing.normal = numbers(&normal.0, lane).into();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Floor;
    use crate::schedule::time::Time;
    use crate::surface::bezier::BezierPatch;
    use proptest::prelude::*;

    /// Floors of every kind of kernel that takes several balls, all of them nearly level.
    fn floors() -> Vec<Surface> {
        let polynomial = |degree: usize| {
            let mut terms = vec![vec![0.0; degree + 1]; degree + 1];
            for (i, j) in (0..=degree).flat_map(|i| (0..=degree - i).map(move |j| (i, j))) {
                terms[i][j] = 0.05 / (1.0 + (3 * i + 2 * j) as f64);
            }
            Floor::Polynomial { x: [-2.0, 2.0], y: [-2.0, 2.0], terms }
        };
        let net = |degree: usize, warp: f64| {
            let point = |k: usize| {
                let (i, j) = (k / (degree + 1), k % (degree + 1));
                let [x, y] = [i, j].map(|k| 4.0 * k as f64 / degree as f64 - 2.0);
                V3::new(x + warp * y * y, y - warp * x, 0.1 * ((3 * i + 5 * j) % 4) as f64)
            };
            let net = (0..(degree + 1).pow(2)).map(point).collect();
            Floor::Bezier(BezierPatch::new([degree; 2], net).expect("a net"))
        };
        let mut floors: Vec<_> = (2..=5).map(polynomial).collect();
        floors.extend([net(3, 0.0), net(5, 0.0), net(3, 0.02), net(5, 0.02)]);
        let plane = BezierPatch::from_heights([0.0, 1.0], [0.0, 1.0], &[vec![0.0; 2], vec![0.0; 2]]);
        let plane = plane.expect("a plane");
        let of = |floor: Floor| match &floor {
            Floor::Bezier(patch) => Surface::new(&floor, patch, 1.0),
            Floor::Polynomial { .. } => Surface::new(&floor, &plane, 1.0),
        };
        floors.into_iter().map(of).collect()
    }

    fn bits(arc: &Arc) -> Vec<u64> {
        let centers = arc.center.iter().chain(&arc.turning.turn).flat_map(|c| [c.x, c.y, c.z]);
        let states = arc.dense.iter().chain([&arc.state, &arc.slope, &arc.end]).flatten().copied();
        let rest = [arc.length, arc.scale, arc.acceleration_bound].into_iter().chain(arc.reaction);
        centers.chain(states).chain(rest).map(f64::to_bits).collect()
    }

    proptest! {
        #[test]
        fn balls_side_by_side_are_the_balls_alone_to_the_last_bit(
            states in prop::collection::vec(prop::array::uniform6(-0.25..0.25_f64), 2..=11),
            radii in prop::collection::vec(0.02..0.2_f64, 11),
            tries in prop::collection::vec(1..9_i32, 11),
            which in 0..8_usize, rolls in prop::bool::ANY, tolerance in 6..13_i32,
        ) {
            let surface = &floors()[which];
            let accuracy = Accuracy::Tolerance(10.0_f64.powi(-tolerance));
            let start: Vec<(Body, Stepping, Arc)> = states.iter().zip(radii).zip(tries).map(|((state, radius), n)| {
                let inertia_factor = if rolls { 0.4 } else { 0.0 };
                let body = Body { radius, inertia_factor, rolls, applied: V3::new(0.3, -0.1, -9.8) };
                let mut arc = Arc::empty(radius);
                arc.state = *state;
                arc.state[5] *= if rolls { 1.0 } else { 0.0 };
                body.settle(surface, &mut arc.state);
                (body, Stepping { try_s: 0.5_f64.powi(n), steps: 0, forced: 0 }, arc)
            }).collect();
            let (mut alone, mut together) = (start.clone(), start);
            for (body, stepping, arc) in &mut alone {
                let state = arc.state;
                body.launch(surface, accuracy, (Time::ZERO, &state), stepping, arc);
            }
            let mut balls: Vec<_> = together
                .iter_mut()
                .map(|(body, stepping, arc)| Some(Launch { body, stepping, arc }))
                .collect();
            launch(surface, accuracy, &mut balls);
            for ((_, a, x), (_, b, y)) in alone.iter().zip(&together) {
                prop_assert_eq!(bits(x), bits(y));
                prop_assert_eq!((a.try_s, a.steps, a.forced), (b.try_s, b.steps, b.forced));
            }
            let seats: Vec<_> = alone
                .iter()
                .take(LANES_MAX)
                .map(|(body, _, arc)| Some(Seat { body, arc, dt: 0.3 * arc.length }))
                .collect();
            let mut landings = [Landing::NOWHERE; LANES_MAX];
            land(surface, accuracy, &seats, &mut landings.each_mut().map(Some)[..seats.len()]);
            for (landing, Seat { body, arc, dt }) in landings.iter().zip(seats.into_iter().flatten()) {
                let (state, slope) = arc.land(body, surface, accuracy, dt);
                let (center, normal) = body.seat(surface, &state);
                prop_assert_eq!((landing.state, landing.slope), (state, slope));
                prop_assert_eq!((landing.center, landing.normal), (center, normal));
            }
        }
    }
}
