//! Scenes in few words, and runs that end the test when a scene is refused.

pub use ballroom_cases::scenes::*;
use ballroom_cases::{mirror, ride};
use ballroom_physics::{Controller, Scene};

/// The engine with a scene that it must take.
pub fn load(scene: &Scene) -> Controller {
    Controller::new(scene).unwrap_or_else(|fault| panic!("the scene is refused: {fault}"))
}

/// Advances tick by tick up to and including `ticks`, showing every tick's state, the start included.
pub fn run(scene: &Scene, rate_hz: u32, ticks: u64, look: impl FnMut(u64, &Controller)) -> Controller {
    ride::run(scene, rate_hz, ticks, look).unwrap_or_else(|fault| panic!("the scene is refused: {fault}"))
}

/// Asserts that a scene and its mirror image run as mirror images, without a bit of difference.
pub fn assert_mirrors(scene: &Scene, rate_hz: u32, ticks: u64) {
    let differing = mirror::differing_states(scene, rate_hz, ticks);
    assert_eq!(differing, Ok(0), "states of the mirror image that differ");
}
