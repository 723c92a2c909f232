//! G, X25: gases as they are measured, held to what makes their figures mean something.

use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::gas;
use crate::ride::{Drift, Largest, run};
use ballroom_physics::{Controller, Scene, SceneFault};

const RATE_HZ: u32 = 60;

/// Relative error of the energy, and deepest overlap at an impact over the smallest radius, when the run is over.
fn kept(scene: &Scene, seconds: u64, mut look: impl FnMut(&Controller)) -> Result<[f64; 2], SceneFault> {
    let mut energy = Drift::default();
    let engine = run(scene, RATE_HZ, seconds * u64::from(RATE_HZ), |tick, engine| {
        look(engine);
        // Half a second is between looks at all balls: they cost as much as the run.
        if tick.is_multiple_of(u64::from(RATE_HZ / 2)) {
            energy.see(engine.energy());
        }
    })?;
    let smallest = scene.balls.iter().map(|ball| ball.radius).fold(f64::INFINITY, f64::min);
    Ok([energy.value(), engine.report().deepest_penetration / smallest])
}

/// The gas on a bowl: hits between balls that each has too few a second for 4; how far the root of the mean squared speed
/// is from 1 m/s, and the covered part of the floor from a fifth; energy and overlap.
fn bowl(count: usize, seconds: u64) -> Result<[f64; 5], SceneFault> {
    let scene = gas::on_a_bowl(count);
    let (mut hits, mut rms, mut ticks) = (0, Largest::default(), 0);
    let [energy, overlap] = kept(&scene, seconds, |engine| {
        hits = engine.report().collisions.ball_ball;
        if ticks % RATE_HZ == 0 {
            let squares: f64 = engine.balls().map(|ball| ball.velocity.norm_squared()).sum();
            rms.see((squares / count as f64).sqrt() - 1.0);
        }
        ticks += 1;
    })?;
    let few = 4.0 - hits as f64 / (count as f64 * seconds as f64);
    let covered = count as f64 * std::f64::consts::PI * gas::RADIUS * gas::RADIUS / gas::area(count);
    Ok([few.max(0.0), rms.value(), (covered - 0.2).abs(), energy, overlap])
}

/// Hits too few for a crowd that meets, energy and overlap.
fn dusty(dust: usize, seconds: u64) -> Result<[f64; 3], SceneFault> {
    let mut hits = 0;
    let [energy, overlap] =
        kept(&gas::dusty(dust), seconds, |engine| hits = engine.report().collisions.ball_ball)?;
    Ok([300_u64.saturating_sub(hits) as f64, energy, overlap])
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let two = Span::Seconds(2.0);
    let overlap = |span| Demand {
        norm: "deepest, over the smallest radius",
        ..Demand::over_ticks("overlap", "1", span, 1e-9)
    };
    vec![
        Case::new(
            "G/bowl-10000",
            "ten thousand balls in a bowl, a fifth of it covered, 1 m/s",
            [
                Demand::at_the_end("hits a ball and second below 4", "1/s", two, 0.0),
                Demand::over_ticks("speed in the mean square, from 1 m/s", "m/s", two, 0.05),
                Demand::at_the_end("covered part, from 0.2", "1", two, 0.001),
                Demand::relative("energy", two, 1e-10),
                overlap(two),
            ],
            || bowl(10_000, 2),
        ),
        Case::new(
            "G/bowl-10",
            "ten balls in a bowl, a fifth of it covered",
            [Demand::relative("energy", Span::Seconds(20.0), 1e-10), overlap(Span::Seconds(20.0))],
            || kept(&gas::on_a_bowl(10), 20, |_| {}),
        ),
        Case::new(
            "X25/dusty",
            "balls of a metre, some centimetres and a thousand grains of 1 to 2 mm in a bowl",
            [Demand::never("hits below 300", two), Demand::relative("energy", two, 1e-11), overlap(two)],
            || dusty(1000, 2),
        ),
    ]
}
