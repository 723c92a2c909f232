//! Several balls' orientations side by side, on from where each was followed before. Every bit is that of
//! [`Turning::at`] alone.

use super::rotation::{RATE_TERMS, Turning, compose, exponential, magnus, unit};
use crate::lanes::{LANES_MAX, Lanes};
use crate::number::{Number, Triple};
use pulp::{Arch, Simd, WithSimd};

/// How far a course has been followed: a later look goes on from there, to the same bits.
#[derive(Clone, Copy, Debug)]
pub struct Followed {
    course: Turning,
    /// Whole pieces, and the orientation after them.
    pieces: u32,
    orientation: [f64; 4],
}

impl Followed {
    /// Nothing followed.
    pub const NONE: Self = Self { course: Turning::STILL, pieces: 0, orientation: Turning::STILL.start };

    /// Goes back to the start of a course, unless it was followed before and not beyond `pieces`: all that an orientation
    /// follows from is compared.
    fn begin(&mut self, course: &Turning, pieces: u32) {
        if self.pieces > pieces || self.course != *course {
            *self = Self { course: *course, pieces: 0, orientation: course.start };
        }
    }
}

/// Whether balls can be turned by [`follow`] on the courses and to the thetas given.
fn can_follow(balls: &[(&Turning, f64)]) -> bool {
    balls.iter().all(|(course, theta)| course.magnus && course.pieces > 0 && *theta > 0.0)
}

/// The orientations of at most as many balls as there are lanes, by [`Turning::at`] lane by lane, on from what was `followed`
/// of each, or from the start. Lanes without a ball repeat the first.
#[inline(always)]
fn follow<S: Simd>(simd: S, balls: &[(&Turning, f64)], followed: &mut [Followed]) -> [Lanes<S>; 4] {
    let (mut thetas, mut lengths, mut wholes) = ([0.0; LANES_MAX], [0.0; LANES_MAX], [0; LANES_MAX]);
    let (mut done, mut starts) = ([0; LANES_MAX], [[0.0; 4]; LANES_MAX]);
    let (mut most, mut doublings_most) = (0, 0);
    for lane in 0..S::F64_LANES {
        let ball = if lane < balls.len() { lane } else { 0 };
        let (course, theta) = balls[ball];
        let h = 1.0 / f64::from(course.pieces);
        let whole = (theta / h) as u32;
        (thetas[lane], lengths[lane], wholes[lane]) = (theta, h, whole);
        starts[lane] = course.start;
        if let Some(followed) = followed.get_mut(ball) {
            followed.begin(course, whole);
            (done[lane], starts[lane]) = (followed.pieces, followed.orientation);
        }
        most = most.max(whole - done[lane]);
        doublings_most = doublings_most.max(course.doublings);
    }
    let of = |lane: usize| balls[if lane < balls.len() { lane } else { 0 }].0;
    let theta = Lanes::new(simd, |lane| thetas[lane]);
    let length = Lanes::new(simd, |lane| lengths[lane]);
    let whole = Lanes::new(simd, |lane| f64::from(wholes[lane]));
    let done = Lanes::new(simd, |lane| f64::from(done[lane]));
    let doublings = Lanes::new(simd, |lane| f64::from(of(lane).doublings));
    let half = theta.like(0.5);
    let mut rate = [Triple([theta; 3]); RATE_TERMS];
    for k in 0..RATE_TERMS {
        for axis in 0..3 {
            rate[k].0[axis] = Lanes::new(simd, |lane| of(lane).turn[k + 1][axis]) * (k + 1) as f64;
        }
    }
    let mut q = [theta; 4];
    for part in 0..4 {
        q[part] = Lanes::new(simd, |lane| starts[lane][part]);
    }
    for ahead in 0..most {
        let piece = done + theta.like(f64::from(ahead));
        let angle = magnus(rate, piece * length + half * length, length);
        let next = compose(exponential(angle, Some(doublings), doublings_most), q);
        for part in 0..4 {
            q[part] = piece.where_less(whole, next[part], q[part]);
        }
    }
    for (lane, followed) in followed.iter_mut().enumerate() {
        followed.pieces = wholes[lane];
        followed.orientation = [q[0].lane(lane), q[1].lane(lane), q[2].lane(lane), q[3].lane(lane)];
    }
    // The last piece is not whole, or none: an arc that is followed to its end has none.
    let from = whole * length;
    if !(0..S::F64_LANES).any(|lane| from.lane(lane) < thetas[lane]) {
        return unit(q);
    }
    let h = theta - from;
    let next = compose(exponential(magnus(rate, from + half * h, h), Some(doublings), doublings_most), q);
    for part in 0..4 {
        q[part] = from.where_less(theta, next[part], q[part]);
    }
    unit(q)
}

/// The orientation of each ball so far along its own course, in theta: the same numbers as of each alone, on from what was
/// `followed` of it. Who looks once follows nothing: an empty slice.
pub fn orientations(balls: &[Option<(&Turning, f64)>], followed: &mut [Followed], out: &mut [[f64; 4]]) {
    Arch::new().dispatch(Orientations { balls, followed, out });
}

struct Orientations<'a> {
    balls: &'a [Option<(&'a Turning, f64)>],
    followed: &'a mut [Followed],
    out: &'a mut [[f64; 4]],
}

impl WithSimd for Orientations<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { balls, followed, out } = self;
        let mut followed = followed.chunks_mut(S::F64_LANES);
        for (balls, out) in balls.chunks(S::F64_LANES).zip(out.chunks_mut(S::F64_LANES)) {
            let followed = followed.next().unwrap_or_default();
            let Some(Some(one)) = balls.first() else { continue };
            let mut courses = [*one; LANES_MAX];
            for (course, ball) in courses.iter_mut().zip(balls.iter().flatten()) {
                *course = *ball;
            }
            let courses = &courses[..balls.len()];
            if courses.len() > 1 && can_follow(courses) {
                let [x, y, z, w] = follow(simd, courses, followed);
                for (lane, q) in out.iter_mut().enumerate() {
                    *q = [x.lane(lane), y.lane(lane), z.lane(lane), w.lane(lane)];
                }
            } else {
                for ((course, theta), q) in courses.iter().zip(out) {
                    *q = course.at(*theta);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::rotation::tests::turns;
    use super::*;

    #[test]
    fn several_orientations_are_those_of_each_alone_to_the_last_bit() {
        let turnings: Vec<Turning> = turns()
            .take(200)
            .map(|turn| {
                let mut turning = Turning::STILL;
                turning.begin(turn, 1e-9);
                turning
            })
            .collect();
        for (group, theta) in turnings.chunks(7).zip([0.0, 0.3, 0.77, 1.0].into_iter().cycle()) {
            let balls: Vec<_> = group.iter().map(|turning| Some((turning, theta))).collect();
            let mut all = [[0.0; 4]; 7];
            let mut followed = [Followed::NONE; 7];
            orientations(&balls, &mut followed[..balls.len()], &mut all[..balls.len()]);
            for (q, turning) in all.iter().zip(group) {
                assert_eq!(q.map(f64::to_bits), turning.at(theta).map(f64::to_bits));
            }
        }
    }
}
