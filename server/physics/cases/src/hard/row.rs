//! H10 and rows of three unlike balls: the number of hits is that of the mirrors a straight line crosses.
//!
//! With the gaps a and b of a row of masses m1, m2, m3, the point (a sqrt(mu12), b sqrt(mu23)) gives distances from the
//! two sides of a wedge of angle phi, cos phi = sqrt(m1 m3/((m1 + m2)(m2 + m3))); between hits it moves on a straight
//! line, and each hit reflects it (Y. Sinai, "Introduction to ergodic theory", 1976). Unfolded, the line crosses the
//! multiples of phi that lie between its angle at the start and that of its direction.

use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::ride::{Drift, miscount, run};
use crate::scenes::{center, graph, moving, plane, random};
use ballroom_physics::{BallSpec, MotionLaw, Scene, SceneFault};
use std::f64::consts::{PI, TAU};

/// Masses, kg, the two gaps, m, and the three velocities, m/s.
struct Row {
    masses: [f64; 3],
    gaps: [f64; 2],
    velocities: [f64; 3],
}

const RADIUS: f64 = 0.25;

impl Row {
    fn random(next: &mut impl FnMut() -> f64) -> Self {
        Self {
            masses: std::array::from_fn(|_| 10.0_f64.powf(4.0 * next() - 2.0)),
            gaps: std::array::from_fn(|_| 0.1 + next()),
            velocities: std::array::from_fn(|_| 2.0 * next() - 1.0),
        }
    }

    /// The wedge's angle, and angle and length of the point and of its velocity; the latter's angle unwound to lie within
    /// half a turn of the former.
    fn polar(&self) -> (f64, [f64; 2], [f64; 2]) {
        let [m1, m2, m3] = self.masses;
        let cos = (m1 * m3 / ((m1 + m2) * (m2 + m3))).sqrt();
        // sin phi from its own formula: 1 - cos^2 would cancel for a light ball in the middle.
        let sin = (m2 * (m1 + m2 + m3) / ((m1 + m2) * (m2 + m3))).sqrt();
        let [near, far] = [m1 * m2 / (m1 + m2), m2 * m3 / (m2 + m3)].map(f64::sqrt);
        let polar = |a: f64, b: f64| {
            let (y, x) = (a * near, (b * far + cos * a * near) / sin);
            [y.atan2(x), y.hypot(x)]
        };
        let [v1, v2, v3] = self.velocities;
        let place = polar(self.gaps[0], self.gaps[1]);
        let [direction, speed] = polar(v2 - v1, v3 - v2);
        (sin.atan2(cos), place, [place[0] + (direction - place[0] + PI).rem_euclid(TAU) - PI, speed])
    }

    /// Number of hits for ever, and when the last is past, s.
    fn hits(&self) -> (u64, f64) {
        let (wedge, [from, distance], [to, speed]) = self.polar();
        let count = ((to / wedge).floor() - (from / wedge).floor()).abs();
        // The line is at angle beta when distance sin(beta - from) = speed t sin(to - beta).
        let last = wedge * if to > from { (to / wedge).floor() } else { (to / wedge).floor() + 1.0 };
        let seconds = distance * (last - from).sin() / (speed * (to - last).sin());
        (count as u64, if count == 0.0 { 0.0 } else { seconds })
    }

    fn scene(&self, motion: MotionLaw) -> Scene {
        let mut scene = graph(16_384.0, &[], motion);
        let mut x = 0.0;
        for i in 0..3 {
            let ball = moving(&format!("{i}"), RADIUS, center(x, 0.0), self.velocities[i], 0.0);
            scene.balls.push(BallSpec { mass: self.masses[i], ..ball });
            x += 2.0 * RADIUS + self.gaps.get(i).copied().unwrap_or_default();
        }
        scene
    }

    /// Miscounted hits and relative error of the energy after 1000 s.
    fn measure(&self, exact: u64, motion: MotionLaw) -> Result<[f64; 2], SceneFault> {
        let mut energy = Drift::default();
        let engine = run(&self.scene(motion), 1, 1000, |_, engine| energy.see(engine.energy()))?;
        Ok([miscount(engine.report().collisions.ball_ball, exact), energy.value()])
    }
}

fn random_rows(count: u32, motion: MotionLaw) -> Result<[f64; 2], SceneFault> {
    let mut next = random(31);
    let mut sums = [0.0_f64; 2];
    let mut done = 0;
    while done < count {
        let row = Row::random(&mut next);
        let (exact, last) = row.hits();
        if last > 900.0 {
            continue;
        }
        let [missed, energy] = row.measure(exact, motion)?;
        sums = [sums[0] + missed, sums[1].max(energy)];
        done += 1;
    }
    Ok(sums)
}

/// Two balls a million times as heavy close in on a light one.
fn wedged() -> Row {
    Row { masses: [1e6, 1.0, 1e6], gaps: [1.0, 1.5], velocities: [1.0, 0.0, -0.7] }
}

/// Three equal balls that meet at one instant with unlike speeds leave in the order of their speeds, as in every order of
/// pairs: error of a velocity.
fn unlike_at_once() -> Result<[f64; 1], SceneFault> {
    let mut scene = plane(32.0);
    let speeds = [3.0, 0.5, -1.0, -2.0];
    for (n, v) in speeds.iter().enumerate() {
        // All gaps close after 2 s.
        scene.balls.push(moving(&format!("{n}"), 0.5, center(n as f64 - 2.0 * v, 0.0), *v, 0.0));
    }
    let engine = run(&scene, 1, 3, |_, _| {})?;
    let last = engine.balls().zip(speeds.iter().rev());
    Ok([last.map(|(ball, exact)| (ball.velocity.x - exact).abs()).fold(0.0, f64::max)])
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![];
    for (law, motion) in [("slide", MotionLaw::Frictionless), ("roll", MotionLaw::Rolling)] {
        cases.push(Case::new(
            format!("H10/wedged-{law}"),
            "a light ball between two closing ones a million times as heavy",
            [
                Demand::count("hits", Span::Seconds(1000.0)),
                Demand::relative("energy", Span::Seconds(1000.0), 1e-12),
            ],
            move || wedged().measure(wedged().hits().0, motion),
        ));
        cases.push(Case::new(
            format!("X10/rows-{law}"),
            "three balls in a row, masses 1 : 1e4 at random",
            [Demand::count("hits", Span::Runs(300)), Demand::relative("energy", Span::Runs(300), 1e-12)],
            move || random_rows(300, motion),
        ));
    }
    cases.push(Case::new(
        "X4/unlike-at-once",
        "four equal balls with unlike speeds meet at one instant",
        [Demand::at_the_end("velocities", "m/s", Span::Seconds(3.0), 1e-14)],
        unlike_at_once,
    ));
    cases
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wedged_ball_is_done_in_time_after_thousands_of_hits() {
        let (hits, last) = wedged().hits();
        assert!(hits > 2000 && last < 900.0, "{hits} hits until {last} s");
    }

    #[test]
    fn a_cradle_of_three_has_two_hits() {
        let row = Row { masses: [1.0; 3], gaps: [1.0; 2], velocities: [2.0, 0.0, 0.0] };
        // The point leaves along a mirror: both gaps close one after the other, after 0.5 s and 1 s.
        let nudged = Row { velocities: [2.0, 0.0, 0.1], ..row };
        assert_eq!(nudged.hits().0, 2);
    }
}
