//! H1: a light ball between a wall and a heavy ball. The number of hits spells pi.
//!
//! With the heavy ball M times as heavy there are ceil(pi / atan(sqrt(1/M))) - 1 hits (G. Galperin, "Playing pool with
//! pi", 2003): in coordinates scaled by the roots of the masses the two balls are one point in a wedge of that angle.

use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::ride::{Drift, hits, miscount, run};
use crate::scenes::{center, graph, in_list_order, moving, still, walls};
use ballroom_physics::{BallSpec, MotionLaw, Scene, SceneFault};

/// Mass ratio and number of hits.
const HITS: [(&str, f64, u64); 7] = [
    ("1", 1.0, 3),
    ("1e2", 1e2, 31),
    ("1e4", 1e4, 314),
    ("1e6", 1e6, 3_141),
    ("1e8", 1e8, 31_415),
    ("1e10", 1e10, 314_159),
    ("1e12", 1e12, 3_141_592),
];

/// By then the last hit is past and the heavy ball not yet at the far wall.
const SECONDS: u32 = 24;

fn scene(heavier: f64, motion: MotionLaw) -> Scene {
    let mut scene = graph(64.0, &[], motion);
    scene.walls = walls([0.0, 64.0], [-64.0, 64.0]);
    let light = still("light", 0.25, center(1.0, 0.0));
    let heavy = BallSpec { mass: heavier, ..moving("heavy", 0.25, center(2.0, 0.0), -1.0, 0.0) };
    scene.balls = vec![light, heavy];
    scene
}

fn measure(heavier: f64, exact: u64, motion: MotionLaw) -> Result<[f64; 3], SceneFault> {
    let mut energy = Drift::default();
    let engine =
        run(&scene(heavier, motion), 1, u64::from(SECONDS), |_, engine| energy.see(engine.energy()))?;
    let balls = in_list_order(&engine);
    let [light, heavy] = [balls[0].velocity.x, balls[1].velocity.x];
    let meet_again = !(0.0 <= light && light <= heavy);
    Ok([miscount(hits(&engine), exact), energy.value(), f64::from(u8::from(meet_again))])
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![];
    for (name, heavier, exact) in HITS {
        for (law, motion) in [("slide", MotionLaw::Frictionless), ("roll", MotionLaw::Rolling)] {
            cases.push(Case::new(
                format!("H1/{name}-{law}"),
                format!("wall, ball, ball {name} times as heavy: {exact} hits"),
                [
                    Demand::count("hits", Span::Seconds(f64::from(SECONDS))),
                    Demand::relative("energy", Span::Hits(exact), 1e-12),
                    Demand::never("balls that still meet", Span::Hits(exact)),
                ],
                move || measure(heavier, exact, motion),
            ));
        }
    }
    cases
}
