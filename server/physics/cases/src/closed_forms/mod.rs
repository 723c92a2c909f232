//! Motion and hits of few balls with exact answers.
//!
//! | file | benchmarks |
//! |---|---|
//! | [`incline`] | B0: a parabola down a slope |
//! | [`periods`] | B1 to B3: periods in a pit, a parabola and a paraboloid |
//! | [`circle`] | B4: horizontal circles, with their orientation |
//! | [`small`] | B5, B6: small motion about the bottom and the top |
//! | [`invariants`] | B8, B9: what spin and speed trade on cylinders and surfaces of revolution |
//! | [`bounce`] | B15: down a slope against a wall |
//! | [`collapse`] | B17: beads on a wall, either side of the threshold |
//! | [`loops`] | the rotation a closed path leaves behind, and a million ticks of it |
//! | [`orders`] | what order each scheme shows, and whether an error asked for is obtained |
//!
//! B16 is H1, B19 is H3, B20 is H2 among the hard cases.

pub mod bounce;
pub mod circle;
pub mod collapse;
pub mod incline;
pub mod invariants;
pub mod loops;
pub mod orders;
pub mod periods;
pub mod small;

use crate::case::Case;
use crate::scenes::{HOLLOW, SOLID, still};
use ballroom_physics::{BallSpec, MotionLaw, Place, Scene};

/// Every case of this room.
pub fn cases() -> Vec<Case> {
    [
        incline::cases(),
        periods::cases(),
        circle::cases(),
        small::cases(),
        invariants::cases(),
        bounce::cases(),
        collapse::cases(),
        loops::cases(),
        orders::cases(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// What a ball is and how it moves: a name for ids, the law, the inertia factor that acts.
#[derive(Clone, Copy, Debug)]
struct Kind {
    name: &'static str,
    motion: MotionLaw,
    k: f64,
}

const SLIDING: Kind = Kind { name: "sliding", motion: MotionLaw::Frictionless, k: 0.0 };
const ROLLING_SOLID: Kind = Kind { name: "solid", motion: MotionLaw::Rolling, k: SOLID };
const ROLLING_HOLLOW: Kind = Kind { name: "hollow", motion: MotionLaw::Rolling, k: HOLLOW };
const KINDS: [Kind; 3] = [SLIDING, ROLLING_SOLID, ROLLING_HOLLOW];

impl Kind {
    /// A ball of this kind at rest.
    fn ball(self, radius: f64, place: Place) -> BallSpec {
        // A sliding ball's inertia acts on nothing, but there must be one.
        let inertia_factor = if self.k > 0.0 { self.k } else { SOLID };
        BallSpec { inertia_factor, ..still("ball", radius, place) }
    }
}

/// The scene with this one ball.
fn with(scene: Scene, ball: BallSpec) -> Scene {
    Scene { balls: vec![ball], ..scene }
}
