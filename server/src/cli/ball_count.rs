//! A scene with another number of balls than it says.

use server::{SceneError, SceneText};

/// How many balls a scene shall have.
#[derive(clap::Args)]
pub struct BallCount {
    /// Balls in all, for a scene with one cloud: the room is stretched until each has as much of the floor as before
    #[arg(long, value_name = "N")]
    balls: Option<u32>,
}

impl BallCount {
    /// The scene with that many balls.
    pub fn open(&self, scene: &str) -> Result<SceneText, SceneError> {
        Ok(self.of(SceneText::open(scene)?))
    }

    /// The same of a scene that is there.
    pub fn of(&self, scene: SceneText) -> SceneText {
        scene.with_balls(self.balls)
    }
}
