//! Each command as a method that returns when it is done. What the server refuses is an error with its reason and code.
//!
//! ```no_run
//! use ballroom_client::{Client, ClientOptions};
//! use protocol::command::DirectionName;
//!
//! # fn main() -> Result<(), ballroom_client::ClientError> {
//! let server = Client::open(ClientOptions::default())?;
//! server.pause()?;
//! server.steer(None, DirectionName::Up)?;
//! let reply = server.step(60)?;
//! println!("tick {}: {:?}", reply.tick, server.snapshot()?.snapshot.center_m);
//! # Ok(())
//! # }
//! ```

use crate::client::{Client, ClientError};
use protocol::change::PointMove;
use protocol::command::{
    BallSetting, Command, Direction, Reply, RunState, Scope, SpeedFactor, SpeedName, SteerMode,
};
use protocol::keys::Name;
use protocol::listing::Selection;
use protocol::parameter::Value;
use protocol::scene::Ball;
use protocol::timeline::{Rewind, SavedState};

impl Client {
    /// A command that must be obeyed.
    fn done(&self, command: &Command) -> Result<Reply, ClientError> {
        let reply = self.command(command)?;
        if reply.ok {
            return Ok(reply);
        }
        let Reply { code, error: why, .. } = reply;
        Err(ClientError::Refused { question: self.keys().srv_command(), why, code })
    }

    /// One push of a ball that nobody has claimed; of the scene's first player without a name.
    pub fn steer(&self, ball: Option<&str>, direction: impl Into<Direction>) -> Result<Reply, ClientError> {
        let (ball, direction) = (ball.map(str::to_owned), direction.into());
        self.done(&Command::Steer { ball, direction, mode: SteerMode::Impulse })
    }

    /// Stops the clock.
    pub fn pause(&self) -> Result<Reply, ClientError> {
        self.done(&Command::Pause {})
    }

    /// Lets the clock run.
    pub fn resume(&self) -> Result<Reply, ClientError> {
        self.done(&Command::Resume {})
    }

    /// Advances a paused arena by whole ticks.
    pub fn step(&self, ticks: u64) -> Result<Reply, ClientError> {
        self.done(&Command::Step { ticks })
    }

    /// Advances a paused arena as fast as it goes to the first tick at or after a simulated time.
    pub fn run_until(&self, time_s: f64) -> Result<Reply, ClientError> {
        self.done(&Command::RunUntil { time_s })
    }

    /// Simulated seconds per wall second, 0.01 to 100.
    pub fn set_speed(&self, factor: f64) -> Result<Reply, ClientError> {
        self.done(&Command::Speed { factor: SpeedFactor::Times(factor) })
    }

    /// As fast as possible: no tick waits for the wall clock.
    pub fn set_speed_max(&self) -> Result<Reply, ClientError> {
        self.done(&Command::Speed { factor: SpeedFactor::Named(SpeedName::Max) })
    }

    /// What the clock shall do, in the words of ROS.
    pub fn set_state(&self, state: RunState) -> Result<Reply, ClientError> {
        self.done(&Command::SetState { state })
    }

    /// Back to the scene's first state or to a part of it; a seed places its clouds anew.
    pub fn reset(&self, scope: Scope, seed: Option<u64>) -> Result<Reply, ClientError> {
        self.done(&Command::Reset { scope, seed })
    }

    /// Puts balls elsewhere, with another velocity or spin: all of them, or none.
    pub fn set_balls(&self, balls: Vec<BallSetting>) -> Result<Reply, ClientError> {
        self.done(&Command::set_balls(balls))
    }

    /// Adds balls: all of them, or none.
    pub fn spawn(&self, balls: Vec<Ball>) -> Result<Reply, ClientError> {
        self.done(&Command::Spawn { balls })
    }

    /// Removes the balls that meet every condition.
    pub fn delete(&self, selection: Selection) -> Result<Reply, ClientError> {
        self.done(&Command::Delete(selection))
    }

    /// Moves control points of the floor: all of them, or none.
    pub fn move_control_points(&self, points: Vec<PointMove>) -> Result<Reply, ClientError> {
        self.done(&Command::MoveControlPoints { points })
    }

    /// Sets numbers of the scene by their names in [`Client::parameters`]: all of them, or none.
    pub fn set_parameters(
        &self,
        values: impl IntoIterator<Item = (String, Value)>,
    ) -> Result<Reply, ClientError> {
        self.done(&Command::SetParameters { values: values.into_iter().collect() })
    }

    /// Goes on with a scene that comes with the program.
    pub fn load_scene(&self, name: &str) -> Result<Reply, ClientError> {
        self.done(&Command::LoadScene { name: Some(name.to_owned()), toml: None, balls: None })
    }

    /// Goes on with a scene as it stands in a file.
    pub fn load_scene_text(&self, toml: &str) -> Result<Reply, ClientError> {
        self.done(&Command::LoadScene { name: None, toml: Some(toml.to_owned()), balls: None })
    }

    /// Has the scene that the arena was started with read again.
    pub fn reload_scene(&self) -> Result<Reply, ClientError> {
        self.done(&Command::ReloadScene {})
    }

    /// Back along what happened, into a new epoch whose tick is the one that was gone back to.
    pub fn rewind(&self, rewind: Rewind) -> Result<Reply, ClientError> {
        self.done(&Command::Rewind(rewind))
    }

    /// Keeps the present state under a name.
    pub fn save_state(&self, slot: &Name) -> Result<Reply, ClientError> {
        self.done(&Command::SaveState { slot: slot.as_str().to_owned() })
    }

    /// Goes on from a state that was kept under a name.
    pub fn load_state(&self, slot: &Name) -> Result<Reply, ClientError> {
        self.done(&Command::LoadState { slot: Some(slot.as_str().to_owned()), state: None })
    }

    /// Goes on from a state of the present scene.
    pub fn load_saved_state(&self, state: SavedState) -> Result<Reply, ClientError> {
        self.done(&Command::LoadState { slot: None, state: Some(Box::new(state)) })
    }
}
