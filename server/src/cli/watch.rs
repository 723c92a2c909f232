//! `watch`: states as lines, newest first come.

use super::connection::{ANSWER_TIMEOUT, Connection};
use super::lines::{Format, Lines};
use super::signals::abort_on_signal;
use ballroom_client::Update;
use protocol::snapshot::Roster;

/// Print the states of a running arena as lines, beginning with the present one
#[derive(clap::Args)]
#[command(after_help = "\
A reader that is too slow misses states, it never gets old ones. Velocities and orientations come as f32 but for the
first line. It goes on when the server is restarted.

Examples:
  ballroom watch
  ballroom watch --json --count 1 | jq .balls[0].center_m
  ballroom watch --csv > states.csv")]
pub struct Watch {
    #[command(flatten)]
    format: Format,
    /// End after this many states
    #[arg(long, value_name = "N")]
    count: Option<u64>,
    #[command(flatten)]
    connection: Connection,
}

impl Watch {
    pub fn run(self) -> anyhow::Result<()> {
        let client = self.connection.open(abort_on_signal()?, ANSWER_TIMEOUT)?;
        // Fails when nobody is there to begin with; later losses are waited out.
        client.stats()?;
        let mut lines = Lines::new(self.format)?;
        let mut roster = Roster::default();
        let mut left = self.count.unwrap_or(u64::MAX);
        for update in client.follow()? {
            if left == 0 {
                break;
            }
            match update {
                Update::World(world) => {
                    if world.snapshot.paused {
                        tracing::info!("the clock stands: `ballroom resume` lets it run");
                    }
                    roster = world.roster;
                    lines.write(&roster, &world.snapshot)?;
                }
                Update::State(state) => lines.write(&roster, &state)?,
                Update::Gone => {
                    tracing::warn!("the server is gone, waiting for it");
                    continue;
                }
            }
            left -= 1;
            if left == 0 {
                break;
            }
        }
        Ok(())
    }
}
