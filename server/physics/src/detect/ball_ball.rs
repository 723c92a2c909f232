//! Time of impact of two balls on their arcs.

use super::root::{divide_by_x, first_descent, refine};
use crate::motion::arc::{Arc, Path};
use crate::motion::step::TERMS;
use crate::schedule::time::Time;
use crate::tolerance::{ADVANCES_MAX, ALONE_CLOSING, ALONE_MARGIN, CLOSING_NOISE, CLOSING_NOISE_SPEED};
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// Coefficients of the squared distance: degree 14.
const SQUARED: usize = 2 * TERMS - 1;

/// Binomials of degree 7.
const C7: [f64; TERMS] = [1.0, 7.0, 21.0, 35.0, 35.0, 21.0, 7.0, 1.0];
/// Binomials of degree 14.
const C14: [f64; SQUARED] =
    [1.0, 14.0, 91.0, 364.0, 1001.0, 2002.0, 3003.0, 3432.0, 3003.0, 2002.0, 1001.0, 364.0, 91.0, 14.0, 1.0];

/// Where two arcs stand at the start of a search.
#[derive(Clone, Copy, Debug)]
pub struct Standing {
    /// Centre, m.
    pub center: V3,
    /// Velocity, m/s.
    pub velocity: V3,
}

impl Standing {
    /// Of `arc` at `time`.
    #[inline(always)]
    pub fn of(arc: &Arc, time: Time) -> Self {
        Self::on::<false>(arc, time)
    }

    /// The same; on a plane the arc need not be asked what kind it is.
    #[inline(always)]
    pub(crate) fn on<const PLANE: bool>(arc: &Arc, time: Time) -> Self {
        let dt = time.since(arc.start);
        if PLANE || arc.path != Path::Curved {
            Self { center: arc.parabola_center(dt), velocity: arc.parabola_velocity(dt) }
        } else {
            Self { center: arc.center_at(dt), velocity: arc.velocity_at(dt) }
        }
    }
}

/// How near two balls come to each other within a time: on straight lines, widened by what acceleration can add.
#[derive(Clone, Copy, Debug)]
pub struct Approach {
    /// Least squared distance of the centres on straight lines, m^2.
    least: f64,
    /// Squared relative speed, m^2/s^2.
    speed: f64,
    /// Distance that it must exceed, m.
    wide: f64,
}

impl Approach {
    /// Of balls at `a` and `b` within `duration`, whose relative acceleration is at most `acceleration`.
    #[inline]
    pub fn of(a: &Standing, b: &Standing, acceleration: f64, reach: f64, duration: f64) -> Self {
        let p = b.center - a.center;
        let v = b.velocity - a.velocity;
        let closing = -p.dot(&v);
        let speed = v.norm_squared();
        let t = if closing <= 0.0 || speed == 0.0 { 0.0 } else { (closing / speed).min(duration) };
        let wide = reach + 0.5 * acceleration * duration * duration;
        Self { least: (p + v * t).norm_squared(), speed, wide }
    }

    /// Whether the balls surely stay apart.
    #[inline]
    pub fn stays_apart(&self) -> bool {
        self.least > self.wide * self.wide
    }

    /// Whether they do so for [`ALONE_MARGIN`] before and after as well, by more than any rounding. Twice their speed is at
    /// most its square plus one, which takes no root.
    #[inline]
    pub fn stays_clear(&self) -> bool {
        self.least > self.wide * self.wide + ALONE_MARGIN * (1.0 + self.speed) * (self.wide + ALONE_MARGIN)
    }
}

/// Whether balls that will hit after `t` seconds come on so briskly that [`ALONE_MARGIN`] earlier they are clearly apart, and
/// have been before: the distance is convex in time but for the acceleration.
pub fn comes_briskly(a: &Standing, b: &Standing, acceleration: f64, reach: f64, t: f64) -> bool {
    let v = b.velocity - a.velocity;
    let closing = -(b.center - a.center + v * t).dot(&v);
    let gained = acceleration * t;
    closing > reach * (ALONE_CLOSING + 1.5 * gained) + 0.5 * gained * t * v.norm()
}

/// Whether balls that may touch part so briskly that [`ALONE_MARGIN`] later they are clearly apart, and stay so for `duration`.
pub fn parts_briskly(a: &Standing, b: &Standing, acceleration: f64, duration: f64) -> bool {
    let p = b.center - a.center;
    p.dot(&(b.velocity - a.velocity)) > p.norm() * (ALONE_CLOSING + 0.5 * acceleration * duration)
}

/// Seconds after `from`, where the arcs stand at `now`, until the distance of the centres falls to `reach`, within
/// `duration`. Balls that overlap or touch count only if they approach; balls that part count only once they return.
///
/// Straight motion is solved; elsewhere the balls first advance as far as they surely may, which finds or excludes
/// most hits, and what is left (grazes, contacts) is isolated by Bernstein coefficients.
pub fn time_of_impact(
    (a, b): (&Arc, &Arc),
    now: (&Standing, &Standing),
    from: Time,
    duration: f64,
    reach: f64,
) -> Option<f64> {
    let both_parabolas = a.path != Path::Curved && b.path != Path::Curved;
    if both_parabolas {
        time_on_plane((a, b), now, from, duration, reach)
    } else {
        search((a, b), now, from, duration, reach)
    }
}

/// The same on a plane.
pub(crate) fn time_on_plane(
    (a, b): (&Arc, &Arc),
    now: (&Standing, &Standing),
    from: Time,
    duration: f64,
    reach: f64,
) -> Option<f64> {
    if a.center[2] != b.center[2] {
        return search((a, b), now, from, duration, reach);
    }
    let noise = closing_noise(now.0.velocity.norm() + now.1.velocity.norm(), 1.0);
    straight(now.1.center - now.0.center, now.1.velocity - now.0.velocity, noise, reach)
        .filter(|t| *t <= duration)
}

/// Balls that do not move straight towards each other.
#[inline(never)]
fn search(
    (a, b): (&Arc, &Arc),
    now: (&Standing, &Standing),
    from: Time,
    duration: f64,
    reach: f64,
) -> Option<f64> {
    match advance_surely((a, b), now, from, duration, reach) {
        Advance::Hit(t) => Some(t),
        Advance::Apart => None,
        Advance::Unclear => isolate(a, b, from, duration, reach),
    }
}

/// What sure advances have found.
enum Advance {
    /// The hit.
    Hit(f64),
    /// There is none.
    Apart,
    /// Nothing within [`ADVANCES_MAX`].
    Unclear,
}

/// Conservative advancement: under a bound A of the relative acceleration, and since the distance along a straight line is
/// convex, distance(t) >= distance - closing t - A t^2/2. The root of the right side is passed by no hit, and from
/// this side it is Newton's method: quadratic unless the balls graze.
fn advance_surely(
    (a, b): (&Arc, &Arc),
    now: (&Standing, &Standing),
    from: Time,
    duration: f64,
    reach: f64,
) -> Advance {
    let acceleration = a.acceleration_bound + b.acceleration_bound;
    let (begin_a, begin_b) = (from.since(a.start), from.since(b.start));
    let (mut p, mut v) = (now.1.center - now.0.center, now.1.velocity - now.0.velocity);
    // First as far as straight motion goes with all the acceleration of the window against it.
    let wide = reach + 0.5 * acceleration * duration * duration;
    let mut t = straight(p, v, 0.0, wide).unwrap_or(0.0);
    if t > 0.0 {
        p = b.center_at(begin_b + t) - a.center_at(begin_a + t);
        v = b.velocity_at(begin_b + t) - a.velocity_at(begin_a + t);
    }
    for _ in 0..ADVANCES_MAX {
        let distance = p.norm();
        let gap = distance - reach;
        let closing = -p.dot(&v) / distance;
        if gap <= 0.0 {
            // Passed by rounding alone, unless the search began in contact.
            return if t > 0.0 && closing > 0.0 { Advance::Hit(t) } else { Advance::Unclear };
        }
        let pace = closing + (closing * closing + 2.0 * acceleration * gap).sqrt();
        let step = 2.0 * gap / pace;
        if pace <= 0.0 || t + step > duration {
            return Advance::Apart;
        }
        if t + step == t {
            return Advance::Hit(t);
        }
        t += step;
        p = b.center_at(begin_b + t) - a.center_at(begin_a + t);
        v = b.velocity_at(begin_b + t) - a.velocity_at(begin_a + t);
    }
    Advance::Unclear
}

/// The first root of the squared distance less the squared reach, a polynomial of degree 14.
fn isolate(a: &Arc, b: &Arc, from: Time, duration: f64, reach: f64) -> Option<f64> {
    let (pa, pb) = (window_polynomial(a, from, duration), window_polynomial(b, from, duration));
    let d: [V3; TERMS] = std::array::from_fn(|k| pb[k] - pa[k]);
    let mut f = squared_distance(&d);
    f[0] = d[0].norm_squared() - reach * reach;
    for x in &mut f[1..] {
        *x -= reach * reach;
    }
    let evaluate = |x: f64| {
        let (mut p, mut v) = (d[TERMS - 1], V3::zeros());
        for c in d[..TERMS - 1].iter().rev() {
            v = v * x + p;
            p = p * x + c;
        }
        (p.norm_squared() - reach * reach, 2.0 * p.dot(&v))
    };
    let bracket = if f[0] > 0.0 {
        first_descent(&f)?
    } else if d[0].dot(&d[1]) < -d[0].norm() * closing_noise(pa[1].norm() + pb[1].norm(), duration) {
        return Some(0.0);
    } else {
        // In contact and parting: the contact itself is a root to be divided out.
        f[0] = 0.0;
        let mut rest = divide_by_x(&f);
        rest[0] = rest[0].max(0.0);
        first_descent(&rest)?
    };
    Some(refine(bracket, evaluate) * duration)
}

/// Closing speed that is rounding, times `duration`, for a sum of speeds times `duration`.
fn closing_noise(path: f64, duration: f64) -> f64 {
    CLOSING_NOISE * path + CLOSING_NOISE_SPEED * duration
}

/// Two balls in straight relative motion that close faster than `noise`: the smaller root of |p + v t| = reach in its stable form.
fn straight(p: V3, v: V3, noise: f64, reach: f64) -> Option<f64> {
    let closing = -p.dot(&v);
    if closing <= noise * p.norm() {
        return None;
    }
    let c = p.norm_squared() - reach * reach;
    if c <= 0.0 {
        return Some(0.0);
    }
    // closing^2 - v^2 c, without its cancellation in a grazing hit: reach^2 v^2 - |p x v|^2.
    let discriminant = reach * reach * v.norm_squared() - p.cross(&v).norm_squared();
    (discriminant > 0.0).then(|| c / (closing + discriminant.sqrt()))
}

/// The centre over `from .. from + duration` in powers of x in [0, 1].
pub fn window_polynomial(arc: &Arc, from: Time, duration: f64) -> [V3; TERMS] {
    let mut c = arc.center;
    let theta = from.since(arc.start) / arc.scale;
    let top = if arc.path == Path::Curved { TERMS - 1 } else { 2 };
    c[top + 1..].fill(V3::zeros());
    if theta != 0.0 {
        // Taylor shift by repeated synthetic division.
        for k in 0..top {
            for i in (k..top).rev() {
                let higher = c[i + 1];
                c[i] += higher * theta;
            }
        }
    }
    let ratio = duration / arc.scale;
    let mut power = 1.0;
    for x in c.iter_mut().take(top + 1).skip(1) {
        power *= ratio;
        *x *= power;
    }
    c
}

/// Bernstein coefficients of degree 14 of |d(x)|^2.
fn squared_distance(d: &[V3; TERMS]) -> [f64; SQUARED] {
    let scaled = scaled_bernstein(d);
    let mut out = [0.0; SQUARED];
    for i in 0..TERMS {
        out[2 * i] += scaled[i].norm_squared();
        for j in i + 1..TERMS {
            out[i + j] += 2.0 * scaled[i].dot(&scaled[j]);
        }
    }
    for (x, c) in out.iter_mut().zip(&C14) {
        *x /= c;
    }
    out
}

/// Bernstein coefficients of degree 7 times their binomials: sums with binomials C(7 - k, i - k).
fn scaled_bernstein(d: &[V3; TERMS]) -> [V3; TERMS] {
    // Coefficient i is the sum over k <= i of C(7,i) C(i,k)/C(7,k) d_k = C(7-k, i-k) d_k.
    let mut out = [V3::zeros(); TERMS];
    for (k, c) in d.iter().enumerate() {
        let mut binomial = 1.0;
        for (step, o) in out[k..].iter_mut().enumerate() {
            *o += c * binomial;
            let left = TERMS - 1 - k;
            if step < left {
                binomial = binomial * (left - step) as f64 / (step + 1) as f64;
            }
        }
    }
    out
}

/// Bernstein coefficients of degree 7 of a scalar polynomial in powers of x.
pub fn bernstein(a: &[f64; TERMS]) -> [f64; TERMS] {
    let vectors: [V3; TERMS] = std::array::from_fn(|k| V3::new(a[k], 0.0, 0.0));
    let scaled = scaled_bernstein(&vectors);
    std::array::from_fn(|i| scaled[i].x / C7[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_squared_distance_is_that_of_the_polynomial() {
        let d: [V3; TERMS] = std::array::from_fn(|k| {
            let k = k as f64;
            V3::new(1.0 - 0.3 * k, 0.2 * k * k - 0.5, 0.1 - 0.05 * k)
        });
        let b = squared_distance(&d);
        for step in 0..=10 {
            let x = f64::from(step) / 10.0;
            let point = d.iter().rev().fold(V3::zeros(), |sum, c| sum * x + c);
            let value: f64 = b
                .iter()
                .enumerate()
                .zip(0_i32..)
                .map(|((i, c), k)| c * C14[i] * x.powi(k) * (1.0 - x).powi(14 - k))
                .sum();
            assert!((value - point.norm_squared()).abs() < 1e-12 * (1.0 + value.abs()));
        }
    }

    #[test]
    fn a_grazing_pass_is_told_from_a_miss_to_the_last_bits() {
        let reach = 0.2;
        for exponent in [3, 6, 9, 12, 14, 15] {
            let epsilon = 10.0_f64.powi(-exponent);
            for (offset, hits) in [(reach * (1.0 - epsilon), true), (reach * (1.0 + epsilon), false)] {
                let found = straight(V3::new(-1.0, offset, 0.0), V3::new(1.0, 0.0, 0.0), 0.0, reach);
                assert_eq!(found.is_some(), hits, "offset {offset:e}");
            }
        }
    }
}
