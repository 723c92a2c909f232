//! Several balls looked at side by side, as a tick that shows all of them does. Every bit is that of a look at one.

use super::arc::{Arc, Path};
use super::body::Body;
use super::law::{ROLLING, State, angular_velocity, rotation, velocity};
use super::rotation::Turned;
use crate::lanes::{LANES_MAX, Lanes};
use crate::number::{Number, Triple};
use crate::surface::chart::{Chart, Frame, Surface, with_chart};
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

type V3 = Vector3<f64>;

/// A ball on its arc.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    /// What moves it.
    pub body: &'a Body,
    /// Its arc.
    pub arc: &'a Arc,
    /// Seconds after the arc's start.
    pub dt: f64,
}

/// What is seen of it.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Its state, read from the arc.
    pub state: State,
    /// Its centre, m.
    pub center: V3,
    /// The floor's normal.
    pub normal: V3,
    /// Angular velocity of a ball that rolls, rad/s.
    pub omega: V3,
    /// Orientation of a ball that rolls, ball to world: x, y, z, w.
    pub orientation: [f64; 4],
}

impl Look {
    /// Nothing seen.
    pub const NONE: Self = Self {
        state: [0.0; ROLLING],
        center: V3::new(0.0, 0.0, 0.0),
        normal: V3::new(0.0, 0.0, 0.0),
        omega: V3::new(0.0, 0.0, 0.0),
        orientation: [0.0, 0.0, 0.0, 1.0],
    };

    /// One ball.
    pub fn at(surface: &Surface, Sight { body, arc, dt }: Sight<'_>) -> Self {
        let (state, center, normal) = arc.sample(body, surface, dt);
        let mut look = Self { state, center, normal, ..Self::NONE };
        if body.rolls {
            look.omega = angular_velocity(&normal, &velocity(&state), state[5], body.radius);
            look.orientation = arc.orientation_at(dt);
        }
        look
    }
}

/// Looks at all that there are, side by side where that pays.
pub fn look(surface: &Surface, balls: &[Sight<'_>], looks: &mut [Look]) {
    Arch::new().dispatch(Looking { surface, balls, looks });
}

struct Looking<'a> {
    surface: &'a Surface,
    balls: &'a [Sight<'a>],
    looks: &'a mut [Look],
}

impl WithSimd for Looking<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { surface, balls, looks } = self;
        with_chart!(&surface.kernel, chart => {
            for (balls, looks) in balls.chunks(S::F64_LANES).zip(looks.chunks_mut(S::F64_LANES)) {
                let alike = |ball: &Sight<'_>| ball.arc.path == Path::Curved && ball.body.rolls;
                if pays(chart) && balls.len() > 1 && balls.iter().all(alike) {
                    look_lanes(simd, chart, balls, looks);
                } else {
                    for (ball, look) in balls.iter().zip(looks) {
                        *look = Look::at(surface, *ball);
                    }
                }
            }
        });
    }
}

/// Whether a chart has kernels for several balls.
#[inline(always)]
const fn pays<C: Chart>(_: &C) -> bool {
    C::SIDE_BY_SIDE
}

/// Lanes without a ball repeat the first.
#[inline(always)]
fn look_lanes<C: Chart, S: Simd>(simd: S, chart: &C, balls: &[Sight<'_>], looks: &mut [Look]) {
    let mut sights = [balls[0]; LANES_MAX];
    let mut thetas = [0.0; LANES_MAX];
    // What each polynomial says, ball by ball: its coefficients lie side by side already.
    let mut read = [[0.0; LANES_MAX]; ROLLING];
    for lane in 0..S::F64_LANES {
        sights[lane] = balls[if lane < balls.len() { lane } else { 0 }];
        let Sight { arc, dt, .. } = sights[lane];
        thetas[lane] = dt / arc.scale;
        let state = arc.read(thetas[lane]);
        for i in 0..ROLLING {
            read[i][lane] = state[i];
        }
    }
    let of = |i: usize| Lanes::new(simd, |lane| read[i][lane]);
    let radius = Lanes::new(simd, |lane| sights[lane].body.radius);
    let frame = chart.frame([of(0), of(1)]);
    let n = frame.normal();
    let center = frame.point() + n * radius;
    let w = Triple([of(2), of(3), of(4)]);
    let w = w - n * w.dot(n);
    let omega = rotation(n, w, of(5), radius.like(1.0) / radius);
    let mut turned = Turned([(&sights[0].arc.turning, thetas[0]); LANES_MAX]);
    for lane in 1..S::F64_LANES {
        turned.0[lane] = (&sights[lane].arc.turning, thetas[lane]);
    }
    let orientations = turned.fit().then(|| turned.at(simd));
    for (lane, look) in looks.iter_mut().enumerate() {
        let state = [
            read[0][lane],
            read[1][lane],
            w.0[0].lane(lane),
            w.0[1].lane(lane),
            w.0[2].lane(lane),
            read[5][lane],
        ];
        let orientation = match &orientations {
            Some([x, y, z, w]) => [x.lane(lane), y.lane(lane), z.lane(lane), w.lane(lane)],
            None => sights[lane].arc.orientation_at(sights[lane].dt),
        };
        *look = Look {
            state,
            center: of_lane(&center, lane),
            normal: of_lane(&n, lane),
            omega: of_lane(&omega, lane),
            orientation,
        };
    }
}

/// One ball's part.
#[inline(always)]
fn of_lane<S: Simd>(of: &Triple<Lanes<S>>, lane: usize) -> V3 {
    V3::new(of.0[0].lane(lane), of.0[1].lane(lane), of.0[2].lane(lane))
}
