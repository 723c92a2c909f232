//! `balls`: which there are, and setting, adding and removing some.

use super::connection::{ANSWER_TIMEOUT, Asked, Connection, LONG_TIMEOUT};
use super::numbers::numbers;
use ballroom_client::Abort;
use protocol::command::{BallSetting, Command};
use protocol::listing::Selection;
use protocol::scene::{Ball, Inertia, InertiaName};
use std::io::Write;

/// List balls with their places and velocities, or set, add or remove some
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
#[command(after_help = "\
Examples:
  ballroom balls
  ballroom balls --player --json
  ballroom balls --name red --name blue
  ballroom balls --within -1,-1,1,1
  ballroom balls spawn new --center 0.5,-0.2 --radius 0.1 --mass 1 --tag guests
  ballroom balls set red --center 0.5,-0.2 --velocity 1,0,0
  ballroom balls delete --tag guests")]
pub struct Balls {
    #[command(subcommand)]
    verb: Option<Verb>,
    #[command(flatten)]
    which: Which,
    /// The answer as a line of JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: Connection,
}

/// Balls that meet every condition.
#[derive(clap::Args)]
struct Which {
    /// Only the ball of this name; may be repeated
    #[arg(long, value_name = "NAME")]
    name: Vec<String>,
    /// Only balls that a player may steer
    #[arg(long)]
    player: bool,
    /// Only balls with this tag
    #[arg(long, value_name = "TAG")]
    tag: Option<String>,
    /// Only balls that were spawned
    #[arg(long)]
    spawned: bool,
    /// Only balls whose centre lies in this rectangle, m
    #[arg(long, value_name = "X0,Y0,X1,Y1", allow_hyphen_values = true, value_parser = numbers::<4>)]
    within: Option<[f64; 4]>,
}

#[derive(clap::Subcommand)]
enum Verb {
    Set(Set),
    Spawn(Spawn),
    Delete(Delete),
}

/// Put a ball elsewhere, with another velocity or spin; what is not given stays
#[derive(clap::Args)]
#[command(after_help = "\
It is refused if the ball would overlap a wall or another ball, or leave the floor. With a condition instead of a name, all
balls that meet it get the same velocity or spin.

Examples:
  ballroom balls set red --center 0.5,-0.2
  ballroom balls set red --velocity 0,0,0 --spin 0
  ballroom balls set --with-tag guests --velocity 0,0,0")]
struct Set {
    /// Which ball
    #[arg(required_unless_present_any = ["with_tag", "within"], conflicts_with_all = ["with_tag", "within"])]
    name: Option<String>,
    /// All balls with this tag
    #[arg(long, value_name = "TAG", conflicts_with = "center")]
    with_tag: Option<String>,
    /// All balls whose centre lies in this rectangle, m
    #[arg(long, value_name = "X0,Y0,X1,Y1", allow_hyphen_values = true, value_parser = numbers::<4>, conflicts_with = "center")]
    within: Option<[f64; 4]>,
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

/// Add a ball while the others roll
#[derive(clap::Args)]
#[command(after_help = "\
It is refused if it would overlap a wall or another ball, stand off the floor, or be too large for it. Many at once: the
command spawn. The clock goes on; a reset takes it away again.

Examples:
  ballroom balls spawn new --center 0.5,-0.2 --radius 0.1 --mass 1
  ballroom balls spawn shell --center 0,0 --radius 0.1 --mass 1 --hollow --velocity 1,0,0 --tag guests --player")]
struct Spawn {
    /// What to call it
    name: String,
    /// x and y of its centre, m
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = numbers::<2>)]
    center: [f64; 2],
    /// Radius, m
    #[arg(long, value_name = "M")]
    radius: f64,
    /// Mass, kg
    #[arg(long, value_name = "KG")]
    mass: f64,
    /// A thin shell, and not a solid ball
    #[arg(long)]
    hollow: bool,
    /// Velocity of its centre, m/s; projected to the tangent plane
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = numbers::<3>)]
    velocity: Option<[f64; 3]>,
    /// Spin about the floor's normal, rad/s
    #[arg(long, value_name = "RAD_PER_S", allow_hyphen_values = true)]
    spin: Option<f64>,
    /// #rrggbb
    #[arg(long)]
    color: Option<String>,
    /// A player may steer it
    #[arg(long)]
    player: bool,
    /// What to select it by; may be repeated
    #[arg(long, value_name = "TAG")]
    tag: Vec<String>,
    #[command(flatten)]
    asked: Asked,
}

/// Remove balls that meet every condition, at least one
#[derive(clap::Args)]
#[command(after_help = "\
The clock goes on; a reset brings the scene's own back.

Examples:
  ballroom balls delete --name red
  ballroom balls delete --spawned
  ballroom balls delete --tag guests --within -1,-1,1,1")]
struct Delete {
    #[command(flatten)]
    which: Which,
    #[command(flatten)]
    asked: Asked,
}

impl Which {
    fn selection(self) -> Selection {
        Selection {
            names: self.name,
            player: self.player.then_some(true),
            tag: self.tag,
            spawned: self.spawned.then_some(true),
            within_m: self.within,
        }
    }
}

impl Balls {
    pub fn run(self) -> anyhow::Result<()> {
        match self.verb {
            Some(Verb::Set(set)) => return set.run(),
            Some(Verb::Spawn(spawn)) => return spawn.run(),
            Some(Verb::Delete(Delete { which, asked })) => {
                return asked.command(&Command::Delete(which.selection()), LONG_TIMEOUT);
            }
            None => {}
        }
        let selection = self.which.selection();
        let balls = self.connection.open(Abort::default(), ANSWER_TIMEOUT)?.balls(&selection)?;
        let mut out = std::io::stdout().lock();
        if self.json {
            writeln!(out, "{}", serde_json::to_string(&balls)?)?;
            return Ok(());
        }
        for ball in &balls.balls {
            let ([x, y, z], [vx, vy, vz]) = (ball.center_m, ball.velocity_m_per_s);
            let player = if ball.player { "  player" } else { "" };
            let spawned = if ball.spawned { "  spawned" } else { "" };
            let tags: String = ball.tags.iter().map(|tag| format!("  #{tag}")).collect();
            writeln!(
                out,
                "{:24} at ({x:.6}, {y:.6}, {z:.6}) m  going ({vx:.6}, {vy:.6}, {vz:.6}) m/s{player}{spawned}{tags}",
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
        let command = match self.name {
            Some(name) => Command::set_balls(vec![BallSetting {
                name,
                center_m: self.center,
                velocity_m_per_s: self.velocity,
                spin_rad_per_s: self.spin,
            }]),
            None => Command::SetBalls {
                balls: vec![],
                select: Some(Selection { tag: self.with_tag, within_m: self.within, ..Selection::default() }),
                velocity_m_per_s: self.velocity,
                spin_rad_per_s: self.spin,
            },
        };
        self.asked.command(&command, ANSWER_TIMEOUT)
    }
}

impl Spawn {
    fn run(self) -> anyhow::Result<()> {
        let ball = Ball {
            name: self.name,
            radius_m: self.radius,
            mass_kg: self.mass,
            inertia: Inertia::Named(if self.hollow { InertiaName::Hollow } else { InertiaName::Solid }),
            center_m: Some(self.center),
            contact_m: None,
            uv: None,
            velocity_m_per_s: self.velocity.unwrap_or_default(),
            spin_rad_per_s: self.spin.unwrap_or_default(),
            color: self.color,
            player: self.player,
            tags: self.tag,
        };
        self.asked.command(&Command::Spawn { balls: vec![ball] }, LONG_TIMEOUT)
    }
}
