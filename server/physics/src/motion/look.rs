//! Several balls looked at side by side, as a tick that shows all of them does. Every bit is that of a look at one.

use super::arc::Path;
use super::follow::{Followed, orientations};
use super::law::{ROLLING, State, angular_velocity, rotation, velocity, velocity_in};
use super::together::{Seat, pays};
use crate::lanes::{LANES_MAX, Lanes};
use crate::number::{Number, Triple};
use crate::surface::chart::{Chart, FlatChart, Frame, Surface, with_chart};
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

type V3 = Vector3<f64>;

/// What is seen of a ball on its arc.
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
    fn at(surface: &Surface, seat: Seat<'_>) -> Self {
        let (state, center, normal) = seat.arc.sample(seat.body, surface, seat.dt);
        let mut look = Self { state, center, normal, ..Self::NONE };
        if seat.body.rolls {
            (look.omega, look.orientation) = turn(&seat, &state, &normal);
        }
        look
    }
}

/// State, centre and normal of one ball on a plane, where no arc is curved: see `Arc::sample`.
#[inline(always)]
pub fn on_plane(chart: &FlatChart, Seat { body, arc, dt }: &Seat<'_>) -> (State, V3, V3) {
    let state = arc.follow(*dt);
    let (center, normal) = body.seat_on(chart, &state);
    (state, center, normal)
}

/// Angular velocity and orientation of one ball that rolls, seen in a state and with a normal.
#[inline(always)]
pub fn turn(Seat { body, arc, dt }: &Seat<'_>, state: &State, normal: &V3) -> (V3, [f64; 4]) {
    (angular_velocity(normal, &velocity(state), state[5], body.radius), arc.orientation_at(*dt))
}

/// Looks at up to `LANES_MAX` balls, side by side where that pays; orientations go on from what was `followed` before.
pub fn look(surface: &Surface, balls: &[Seat<'_>], followed: &mut [Followed], looks: &mut [Look]) {
    let alike = |ball: &Seat<'_>| ball.arc.path == Path::Curved && ball.body.rolls;
    let pays = with_chart!(&surface.kernel, chart => pays(chart));
    if pays && balls.len() > 1 && balls.iter().all(alike) {
        Arch::new().dispatch(Seats { surface, balls, looks });
        let courses: [_; LANES_MAX] = std::array::from_fn(|place| {
            let Seat { arc, dt, .. } = *balls.get(place)?;
            Some((&arc.turning, dt / arc.scale))
        });
        let mut q = [[0.0; 4]; LANES_MAX];
        orientations(&courses[..balls.len()], followed, &mut q[..balls.len()]);
        for (look, q) in looks.iter_mut().zip(q) {
            look.orientation = q;
        }
    } else {
        for (ball, look) in balls.iter().zip(looks) {
            *look = Look::at(surface, *ball);
        }
    }
}

/// Everything but the orientation, of rolling balls on curved arcs.
struct Seats<'a> {
    surface: &'a Surface,
    balls: &'a [Seat<'a>],
    looks: &'a mut [Look],
}

impl WithSimd for Seats<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { surface, balls, looks } = self;
        for (balls, looks) in balls.chunks(S::F64_LANES).zip(looks.chunks_mut(S::F64_LANES)) {
            // What each polynomial says, ball by ball: its coefficients lie side by side already.
            let mut read = [[0.0; LANES_MAX]; ROLLING];
            for lane in 0..S::F64_LANES {
                // Lanes without a ball repeat the first.
                let Seat { arc, dt, .. } = balls[if lane < balls.len() { lane } else { 0 }];
                let state = arc.read(dt / arc.scale);
                for i in 0..ROLLING {
                    read[i][lane] = state[i];
                }
            }
            let radius =
                Lanes::new(simd, |lane| balls[if lane < balls.len() { lane } else { 0 }].body.radius);
            let mut y = [radius; ROLLING];
            for i in 0..ROLLING {
                y[i] = Lanes::new(simd, |lane| read[i][lane]);
            }
            let [n, center, w, omega] = with_chart!(&surface.kernel, chart => seat(chart, &y, radius));
            for (lane, look) in looks.iter_mut().enumerate() {
                let [n, center, w, omega] =
                    [of_lane(&n, lane), of_lane(&center, lane), of_lane(&w, lane), of_lane(&omega, lane)];
                look.state = [read[0][lane], read[1][lane], w.x, w.y, w.z, read[5][lane]];
                (look.normal, look.center, look.omega) = (n, center, omega);
            }
        }
    }
}

/// Normal, centre, velocity in the tangent plane, angular velocity.
#[inline(always)]
fn seat<C: Chart, T: Number>(chart: &C, y: &[T; ROLLING], radius: T) -> [Triple<T>; 4] {
    let frame = chart.frame([y[0], y[1]]);
    let n = frame.normal();
    let center = frame.point() + n * radius;
    let w = velocity_in(y);
    let w = w - n * w.dot(n);
    [n, center, w, rotation(n, w, y[5], radius.like(1.0) / radius)]
}

/// One ball's part.
#[inline(always)]
fn of_lane<S: Simd>(of: &Triple<Lanes<S>>, lane: usize) -> V3 {
    V3::new(of.0[0].lane(lane), of.0[1].lane(lane), of.0[2].lane(lane))
}
