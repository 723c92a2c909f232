//! `balls`: which there are, and setting one anew.

use super::connection::{ANSWER_TIMEOUT, Asked, Connection};
use ballroom_client::Abort;
use protocol::command::{BallSetting, Command};
use protocol::listing::Selection;
use std::io::Write;

/// List balls with their places and velocities, or set one anew
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
#[command(after_help = "\
Examples:
  ballroom balls
  ballroom balls --player --json
  ballroom balls --name red --name blue
  ballroom balls --within -1,-1,1,1
  ballroom balls set red --center 0.5,-0.2 --velocity 1,0,0")]
pub struct Balls {
    #[command(subcommand)]
    set: Option<Verb>,
    /// Only the ball of this name; may be repeated
    #[arg(long, value_name = "NAME")]
    name: Vec<String>,
    /// Only balls that a player may steer
    #[arg(long)]
    player: bool,
    /// Only balls whose centre lies in this rectangle, m
    #[arg(long, value_name = "X0,Y0,X1,Y1", allow_hyphen_values = true, value_parser = numbers::<4>)]
    within: Option<[f64; 4]>,
    /// The answer as a line of JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: Connection,
}

#[derive(clap::Subcommand)]
enum Verb {
    Set(Set),
}

/// Put a ball elsewhere, with another velocity or spin; what is not given stays
#[derive(clap::Args)]
#[command(after_help = "\
It is refused if the ball would overlap a wall or another ball, or leave the floor. Many at once: the command set_balls.

Examples:
  ballroom balls set red --center 0.5,-0.2
  ballroom balls set red --velocity 0,0,0 --spin 0")]
struct Set {
    /// Which ball
    name: String,
    /// x and y of its centre, m
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = numbers::<2>)]
    center: Option<[f64; 2]>,
    /// Velocity of its centre, m/s; projected to the tangent plane
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = numbers::<3>)]
    velocity: Option<[f64; 3]>,
    /// Spin about the floor's normal, rad/s
    #[arg(long, value_name = "RAD_PER_S", allow_hyphen_values = true)]
    spin: Option<f64>,
    #[command(flatten)]
    asked: Asked,
}

impl Balls {
    pub fn run(self) -> anyhow::Result<()> {
        if let Some(Verb::Set(set)) = self.set {
            return set.run();
        }
        let selection =
            Selection { names: self.name, player: self.player.then_some(true), within_m: self.within };
        let balls = self.connection.open(Abort::default(), ANSWER_TIMEOUT)?.balls(&selection)?;
        let mut out = std::io::stdout().lock();
        if self.json {
            writeln!(out, "{}", serde_json::to_string(&balls)?)?;
            return Ok(());
        }
        for ball in &balls.balls {
            let ([x, y, z], [vx, vy, vz]) = (ball.center_m, ball.velocity_m_per_s);
            let player = if ball.player { "  player" } else { "" };
            writeln!(
                out,
                "{:24} at ({x:.6}, {y:.6}, {z:.6}) m  going ({vx:.6}, {vy:.6}, {vz:.6}) m/s{player}",
                ball.name
            )?;
        }
        if balls.left_out > 0 {
            writeln!(out, "and {} more: ask for a region with --within", balls.left_out)?;
        }
        Ok(())
    }
}

impl Set {
    fn run(self) -> anyhow::Result<()> {
        let ball = BallSetting {
            name: self.name,
            center_m: self.center,
            velocity_m_per_s: self.velocity,
            spin_rad_per_s: self.spin,
        };
        self.asked.command(&Command::SetBalls { balls: vec![ball] }, ANSWER_TIMEOUT)
    }
}

/// N numbers with commas between them.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(str::parse).collect();
    let numbers = numbers.map_err(|e| e.to_string())?;
    numbers.try_into().map_err(|_| format!("use {N} numbers with commas between them"))
}
