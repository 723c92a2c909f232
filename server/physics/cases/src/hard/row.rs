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

    /// The wedge's angle, the angle of the point and that of its direction, unwound to lie within half a turn.
    fn angles(&self) -> [f64; 3] {
        let [m1, m2, m3] = self.masses;
        let cos = (m1 * m3 / ((m1 + m2) * (m2 + m3))).sqrt();
        // sin phi from its own formula: 1 - cos^2 would cancel for a light ball in the middle.
        let sin = (m2 * (m1 + m2 + m3) / ((m1 + m2) * (m2 + m3))).sqrt();
        let [near, far] = [m1 * m2 / (m1 + m2), m2 * m3 / (m2 + m3)].map(f64::sqrt);
        let angle = |a: f64, b: f64| (a * near * sin).atan2(b * far + cos * a * near);
        let [v1, v2, v3] = self.velocities;
        let place = angle(self.gaps[0], self.gaps[1]);
        let direction = angle(v2 - v1, v3 - v2);
        [sin.atan2(cos), place, place + (direction - place + PI).rem_euclid(TAU) - PI]
    }

    /// Hits for ever; none if the line ends so nearly along a mirror that the last hit is far away.
    fn hits(&self) -> Option<u64> {
        let [wedge, place, direction] = self.angles();
        let mirrors = direction / wedge;
        let clear =
            ((mirrors - mirrors.round()) * wedge).abs() > 0.01 && (direction - place).abs() < PI - 0.01;
        clear.then_some((mirrors.floor() - (place / wedge).floor()).abs() as u64)
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
        let Some(exact) = row.hits() else { continue };
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
    let last = engine.balls().iter().zip(speeds.iter().rev());
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
            move || {
                let row = wedged();
                row.measure(row.hits().expect("clear of every mirror"), motion)
            },
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
