//! What a tick shows: states, energy. Read off the arcs when somebody asks; looking changes nothing.

use super::{Ball, BallState, Controller};
use crate::lanes::LANES_MAX;
use crate::motion::follow::Followed;
use crate::motion::law::{State, angular_velocity, velocity};
use crate::motion::look::{self, Look};
use crate::motion::rotation;
use crate::motion::together::Seat;
use crate::surface::chart::Kernel;
use nalgebra::{Vector2, Vector3};

type V3 = Vector3<f64>;

/// What who looks at a run again and again keeps between looks. It fits any run at any time.
#[derive(Clone, Debug, Default)]
pub struct Observer {
    followed: Vec<Followed>,
}

impl Controller {
    /// A ball at the controller's time, by id: about 0.3 us on a curved floor, most of it for the orientation.
    pub fn ball(&self, ball: usize) -> BallState {
        let (b, seat) = self.place_on_arc(ball);
        match &self.surface.kernel {
            Kernel::Flat(chart) => self.shown_alone(b, &seat, look::on_plane(chart, &seat)),
            _ => self.shown_on_curve(b, &seat),
        }
    }

    #[inline(never)]
    fn shown_on_curve(&self, b: &Ball, seat: &Seat<'_>) -> BallState {
        self.shown_alone(b, seat, seat.arc.sample(seat.body, &self.surface, seat.dt))
    }

    #[inline(always)]
    fn shown_alone(&self, b: &Ball, seat: &Seat<'_>, (state, center, normal): (State, V3, V3)) -> BallState {
        let (omega, orientation) =
            if b.body.rolls { look::turn(seat, &state, &normal) } else { self.free_spin(b) };
        self.shown(&Look { state, center, normal, omega, orientation })
    }

    /// The balls at the controller's time, by id, each computed as it is asked for.
    pub fn balls(&self) -> impl ExactSizeIterator<Item = BallState> + Clone + '_ {
        (0..self.balls.len()).map(|ball| self.ball(ball))
    }

    /// Shows all balls at the controller's time, by id: the same states as [`Self::ball`], some computed at once, and
    /// orientations on from where the same observer last saw them: quicker for who looks again and again.
    pub fn observe(&self, observer: &mut Observer, mut show: impl FnMut(usize, &BallState)) {
        let followed = &mut observer.followed;
        followed.resize(self.balls.len(), Followed::NONE);
        for (group, followed) in followed.chunks_mut(LANES_MAX).enumerate() {
            let (first, count) = (group * LANES_MAX, followed.len());
            let seats: [_; LANES_MAX] =
                std::array::from_fn(|place| self.place_on_arc(first + place.min(count - 1)).1);
            let mut looks = [Look::NONE; LANES_MAX];
            look::look(&self.surface, &seats[..count], followed, &mut looks[..count]);
            for (place, look) in looks[..count].iter().enumerate() {
                let ball = first + place;
                let (b, mut look) = (&self.holder(ball).balls[ball], *look);
                if !b.body.rolls {
                    (look.omega, look.orientation) = self.free_spin(b);
                }
                show(ball, &self.shown(&look));
            }
        }
    }

    /// A ball and its place on its arc at the controller's time.
    #[inline]
    fn place_on_arc(&self, ball: usize) -> (&Ball, Seat<'_>) {
        let at = self.holder(ball);
        let (b, arc) = (&at.balls[ball], &at.arcs[ball]);
        (b, Seat { body: &b.body, arc, dt: at.time.since(arc.start).max(0.0) })
    }

    /// What is seen, as it is shown.
    #[inline]
    fn shown(&self, look: &Look) -> BallState {
        let Look { state, center, normal, omega, orientation } = *look;
        let [u, v] = self.surface.uv([state[0], state[1]]);
        BallState { uv: Vector2::new(u, v), center, normal, velocity: velocity(&state), omega, orientation }
    }

    /// Angular velocity and orientation of a sliding ball.
    #[inline]
    fn free_spin(&self, b: &Ball) -> (V3, [f64; 4]) {
        (b.free_omega, rotation::of_steady_spin(&b.free_omega, self.time))
    }

    /// State, centre and normal at the controller's time.
    pub(super) fn seen(&self, ball: usize) -> (State, V3, V3) {
        let arc = &self.arcs[ball];
        let dt = self.time.since(arc.start).max(0.0);
        arc.sample(&self.balls[ball].body, &self.surface, dt)
    }

    /// Total energy at the controller's time, J: translation, rotation, height. The spin of a sliding ball, which
    /// nothing changes, is left out.
    pub fn energy(&self) -> f64 {
        let of_ball = |ball: usize| {
            let at = self.holder(ball);
            let (state, center, normal) = at.seen(ball);
            let velocity = velocity(&state);
            let omega = angular_velocity(&normal, &velocity, state[5], at.balls[ball].body.radius);
            self.energy_seen(ball, &BallState { center, normal, velocity, omega, ..BallState::default() })
        };
        (0..self.balls.len()).map(of_ball).sum()
    }

    /// A ball's part of [`Self::energy`] in a state that was read, J.
    pub fn energy_seen(&self, ball: usize, state: &BallState) -> f64 {
        let b = &self.holder(ball).balls[ball];
        let k = b.body.inertia_factor;
        let mut spin = 0.0;
        if b.body.rolls {
            let sigma = state.omega.dot(&state.normal) * b.body.radius;
            spin = 0.5 * k * sigma * sigma;
        }
        b.mass * (0.5 * (1.0 + k) * state.velocity.norm_squared() + spin - self.gravity.dot(&state.center))
    }
}
