//! Time of impact of a ball and a vertical wall.

use super::ball_ball::{Standing, bernstein, window_polynomial};
use super::root::{divide_by_x, first_descent, refine};
use crate::detect::broad_phase::Bounds;
use crate::motion::arc::{Arc, Path};
use crate::motion::step::TERMS;
use crate::schedule::time::Time;
use crate::tolerance::{CLOSING_NOISE, CLOSING_NOISE_SPEED};
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// Distance that counts as no room, relative to a metre and to the largest coordinate.
const ROOM_SPARE: f64 = 1e-9;

/// A wall as the engine uses it: q.x = offset, q pointing into the room.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// Unit inward normal; its z is 0.
    pub normal: V3,
    /// A point of the wall; kept as a point so that a wall far from the origin loses nothing.
    pub point: V3,
}

impl Plane {
    /// Distance of `center` from the wall, m.
    #[inline]
    pub fn distance(&self, center: &V3) -> f64 {
        (center - self.point).dot(&self.normal)
    }
}

/// Where bounds can lie and surely meet none of the walls; nowhere if one stands askew.
pub fn room_between(walls: &[Plane]) -> Bounds {
    let mut room = [f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY];
    for Plane { normal, point } in walls {
        // More than any rounding.
        let spare = ROOM_SPARE * (1.0 + point.amax());
        match [normal.x, normal.y] {
            [1.0, 0.0] => room[0] = room[0].max(point.x + spare),
            [0.0, 1.0] => room[1] = room[1].max(point.y + spare),
            [-1.0, 0.0] => room[2] = room[2].min(point.x - spare),
            [0.0, -1.0] => room[3] = room[3].min(point.y - spare),
            _ => return [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY],
        }
    }
    room
}

/// Seconds after `from`, when the ball is at `now`, until the centre is `radius` from the wall, within `duration`; the same rules for
/// balls already in contact as for two balls.
pub fn time_of_impact(
    (arc, now): (&Arc, &Standing),
    plane: &Plane,
    from: Time,
    duration: f64,
    radius: f64,
) -> Option<f64> {
    if arc.path != Path::Curved {
        return time_on_plane((arc, now), plane, duration, radius);
    }
    let gap = plane.distance(&now.center) - radius;
    let speed = now.velocity.dot(&plane.normal);
    let noise = CLOSING_NOISE * now.velocity.norm() + CLOSING_NOISE_SPEED;
    if gap + speed.min(0.0) * duration - 0.5 * arc.acceleration_bound * duration * duration > 0.0 {
        return None;
    }
    let c = window_polynomial(arc, from, duration);
    let mut a: [f64; TERMS] = std::array::from_fn(|k| c[k].dot(&plane.normal));
    a[0] = gap;
    let evaluate = |x: f64| {
        let (mut p, mut v) = (a[TERMS - 1], 0.0);
        for k in a[..TERMS - 1].iter().rev() {
            v = v * x + p;
            p = p * x + k;
        }
        (p, v)
    };
    let bracket = if gap > 0.0 {
        first_descent(&bernstein(&a))?
    } else if speed < -noise {
        return Some(0.0);
    } else {
        let mut rest = a;
        rest[0] = 0.0;
        let mut rest = divide_by_x(&bernstein(&rest));
        rest[0] = rest[0].max(0.0);
        first_descent(&rest)?
    };
    Some(refine(bracket, evaluate) * duration)
}

/// The same on a plane.
pub(crate) fn time_on_plane(
    (arc, now): (&Arc, &Standing),
    plane: &Plane,
    duration: f64,
    radius: f64,
) -> Option<f64> {
    let gap = plane.distance(&now.center) - radius;
    let speed = now.velocity.dot(&plane.normal);
    let noise = CLOSING_NOISE * now.velocity.norm() + CLOSING_NOISE_SPEED;
    let acceleration = 2.0 * arc.center[2].dot(&plane.normal);
    parabola(gap, speed, noise, acceleration).filter(|t| *t <= duration)
}

/// First time gap + speed t + acceleration t^2/2 falls to zero from above, in its stable forms. In contact only
/// what closes faster than `noise` hits.
fn parabola(gap: f64, speed: f64, noise: f64, acceleration: f64) -> Option<f64> {
    if gap <= 0.0 {
        if speed < -noise {
            return Some(0.0);
        }
        return (acceleration < 0.0).then(|| -2.0 * speed.max(0.0) / acceleration);
    }
    if acceleration == 0.0 {
        return (speed < 0.0).then(|| gap / -speed);
    }
    let discriminant = speed * speed - 2.0 * acceleration * gap;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    if speed < 0.0 {
        return Some(2.0 * gap / (root - speed));
    }
    (acceleration < 0.0).then(|| (speed + root) / -acceleration)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parabola_meets_the_wall_when_it_should() {
        assert_eq!(parabola(1.0, -2.0, 0.0, 0.0), Some(0.5));
        assert_eq!(parabola(1.0, 2.0, 0.0, 0.0), None);
        assert_eq!(parabola(0.0, 1.0, 0.0, -2.0), Some(1.0));
        assert_eq!(parabola(0.0, -1.0, 0.0, 5.0), Some(0.0));
        assert_eq!(parabola(2.0, 0.0, 0.0, -1.0), Some(2.0));
        assert_eq!(parabola(1.0, -1.0, 0.0, 1.0), None);
    }
}
