//! `players`: who drives which ball.

use super::connection::{ANSWER_TIMEOUT, Connection};
use ballroom_client::Abort;
use protocol::player::PlayerRow;
use std::io::Write;

/// List who drives which ball
#[derive(clap::Args)]
#[command(after_help = "\
Hits are those of the ball since it was claimed; the rank is by hits with other balls, most first. Messages are counted
by the server; the latency is from a command to its acknowledgement, as the player measured last.

Examples:
  ballroom players
  ballroom players --json | jq .players[0].ball")]
pub struct Players {
    /// The answer as a line of JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: Connection,
}

impl Players {
    pub fn run(self) -> anyhow::Result<()> {
        let listing = self.connection.open(Abort::default(), ANSWER_TIMEOUT)?.players()?;
        let mut out = std::io::stdout().lock();
        if self.json {
            writeln!(out, "{}", serde_json::to_string(&listing)?)?;
            return Ok(());
        }
        if listing.players.is_empty() {
            writeln!(out, "nobody drives a ball")?;
        }
        for PlayerRow { player, ball, hits, rank, commands, messages, lost, latency_ms, silent_s, .. } in
            &listing.players
        {
            let latency = latency_ms.map_or_else(|| "-".to_owned(), |latency| format!("{latency:.1}"));
            writeln!(
                out,
                "{player:16} drives {ball:16} rank {rank}  hits {} balls {} walls  {commands} commands  \
                 latency {latency} ms  lost {lost} of {} messages  silent for {silent_s:.1} s",
                hits.ball_ball,
                hits.ball_wall,
                messages + lost,
            )?;
        }
        Ok(())
    }
}
