//! `steer`: one press, or a force.

use super::connection::{ANSWER_TIMEOUT, Asked};
use protocol::command::{Command, Direction, DirectionName, SteerMode};

/// Push a player's ball
#[derive(clap::Args)]
#[command(after_help = "\
A force lasts half a simulated second unless it is renewed or stopped.

Examples:
  ballroom steer up
  ballroom steer -0.6,0.8 --force
  ballroom steer stop --force --ball player")]
pub struct Steer {
    /// up, down, left, right, stop, or a vector X,Y of length at most 1
    #[arg(allow_hyphen_values = true, value_parser = direction)]
    direction: Direction,
    /// Which ball; the scene's first player's when not given
    #[arg(long, value_name = "NAME")]
    ball: Option<String>,
    /// Hold a force instead of pressing once
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    asked: Asked,
}

impl Steer {
    pub fn run(self) -> anyhow::Result<()> {
        let mode = if self.force { SteerMode::Force } else { SteerMode::Impulse };
        let command = Command::Steer { ball: self.ball, direction: self.direction, mode };
        self.asked.command(&command, ANSWER_TIMEOUT)
    }
}

fn direction(text: &str) -> Result<Direction, String> {
    let name = match text {
        "up" => DirectionName::Up,
        "down" => DirectionName::Down,
        "left" => DirectionName::Left,
        "right" => DirectionName::Right,
        "stop" => DirectionName::Stop,
        _ => {
            let vector = text.split_once(',').and_then(|(x, y)| Some([x.parse().ok()?, y.parse().ok()?]));
            return vector
                .map(Direction::Vector)
                .ok_or_else(|| "use up, down, left, right, stop or X,Y".into());
        }
    };
    Ok(Direction::Named(name))
}
