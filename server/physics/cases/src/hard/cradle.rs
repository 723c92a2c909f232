//! H2, H3: rows and groups of touching balls.

use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::mirror::differing_states;
use crate::ride::{Largest, run};
use crate::scenes::{center, graph, moving};
use ballroom_physics::{MotionLaw, Scene, SceneFault};
use nalgebra::Vector3;

/// Five touching balls, `swung` of them a metre to the left with speed 2.
fn cradle(swung: usize, motion: MotionLaw) -> Scene {
    let mut scene = graph(32.0, &[], motion);
    for n in 0..5 {
        let place = n as f64 - if n < swung { 1.0 } else { 0.0 };
        let speed = if n < swung { 2.0 } else { 0.0 };
        scene.balls.push(moving(&format!("{n}"), 0.5, center(place, 0.0), speed, 0.0));
    }
    scene
}

fn as_many_leave(swung: usize, motion: MotionLaw) -> Result<[f64; 1], SceneFault> {
    let mut largest = Largest::default();
    run(&cradle(swung, motion), 60, 180, |tick, engine| {
        let t = tick as f64 / 60.0;
        for (n, ball) in engine.balls().iter().enumerate() {
            let came = if n < swung { 2.0 * t.min(0.5) - 1.0 } else { 0.0 };
            let left = if n >= 5 - swung { 2.0 * (t - 0.5).max(0.0) } else { 0.0 };
            largest.see_center(ball, Vector3::new(n as f64 + came + left, 0.0, 0.5));
        }
    })?;
    Ok([largest.value()])
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![];
    for (law, motion) in [("slide", MotionLaw::Frictionless), ("roll", MotionLaw::Rolling)] {
        for swung in 1..=3 {
            cases.push(Case::new(
                format!("H2/{swung}-in-{law}"),
                format!("{swung} into a cradle of five, {swung} out"),
                [Demand::over_ticks("centres", "m", Span::Seconds(3.0), 1e-12)],
                move || as_many_leave(swung, motion),
            ));
        }
    }
    cases.push(Case::new(
        "H2/mirror",
        "a cradle in a mirror",
        [Demand::never("states that differ", Span::Seconds(3.0))],
        || Ok([differing_states(&cradle(2, MotionLaw::Rolling), 60, 180)? as f64]),
    ));
    cases
}
