//! `floor`: moving control points.

use super::connection::{Asked, LONG_TIMEOUT};
use super::numbers::numbers;
use protocol::change::PointMove;
use protocol::command::Command;

/// Change the floor while balls roll on it
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  ballroom floor move 5,3=-4,0,-60")]
pub struct Floor {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(clap::Subcommand)]
enum Verb {
    Move(Move),
}

/// Move control points: all of them, or none
#[derive(clap::Args)]
#[command(after_help = "\
Rows run along v (y, south to north), columns along u (x, west to east), both from 0. The new floor is proved as a loaded
one is. Balls keep x, y, spin and orientation; the energy that takes counts as steering work. It is refused if a ball
would be in a wall, in another ball or off the floor.

Examples:
  ballroom floor move 5,3=-4,0,-60
  ballroom floor move 4,3=-4,-2,-10 6,3=-4,2,-10 --json")]
struct Move {
    /// Which, and where to, m
    #[arg(required = true, value_name = "ROW,COLUMN=X,Y,Z", value_parser = point)]
    points: Vec<PointMove>,
    #[command(flatten)]
    asked: Asked,
}

impl Floor {
    pub fn run(self) -> anyhow::Result<()> {
        let Verb::Move(Move { points, asked }) = self.verb;
        asked.command(&Command::MoveControlPoints { points }, LONG_TIMEOUT)
    }
}

fn point(text: &str) -> Result<PointMove, String> {
    let usage = || "use ROW,COLUMN=X,Y,Z".to_owned();
    let (place, to) = text.split_once('=').ok_or_else(usage)?;
    let (row, column) = place.split_once(',').ok_or_else(usage)?;
    let index = |text: &str| text.trim().parse().map_err(|_| usage());
    Ok(PointMove { row: index(row)?, column: index(column)?, to_m: numbers(to)? })
}
