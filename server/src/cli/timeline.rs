//! `rewind`, `save`, `load-state` and `slots`: back along what happened, and on from what was kept.

use super::connection::{ANSWER_TIMEOUT, Asked, Connection, LONG_TIMEOUT};
use anyhow::bail;
use ballroom_client::Abort;
use protocol::command::Command;
use protocol::timeline::{MAX_WORDS_BYTES, Rewind as Target};
use server::checkpoint_file;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Go back along what happened, and on from there as a new epoch
#[derive(clap::Args)]
#[command(after_help = "\
The state is that of the wanted tick to the last bit, before the commands of that tick; the clock goes on or stands as before.
Seconds are simulated ones and reach back through resets and other scenes. What came after is forgotten.

Examples:
  ballroom rewind --seconds 600
  ballroom rewind --tick 1200
  ballroom rewind --tick 300 --epoch 1790000000000     of an epoch that was reset since; `ballroom slots` shows the oldest")]
#[command(group = clap::ArgGroup::new("where").required(true).args(["seconds", "tick"]))]
pub struct Rewind {
    /// So many simulated seconds back
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// To this tick
    #[arg(long, value_name = "N")]
    tick: Option<u64>,
    /// Of this epoch, if not of the present count of ticks
    #[arg(long, value_name = "E", requires = "tick")]
    epoch: Option<u64>,
    #[command(flatten)]
    asked: Asked,
}

/// Keep the present state: in a slot of the server by its name, or in a file
#[derive(clap::Args)]
#[command(after_help = "\
A name is a slot: 1 to 32 of a-z, 0-9, _ and -. Anything else, with a dot or a slash in it, is a new file, the same that
`ballroom simulate --save` writes.

Examples:
  ballroom save before
  ballroom save before.json
  ballroom save before.json --slot before      a slot's state instead of the present one")]
pub struct Save {
    /// Slot or file
    #[arg(value_name = "SLOT|FILE")]
    to: String,
    /// Write what this slot holds into the file
    #[arg(long, value_name = "NAME")]
    slot: Option<String>,
    #[command(flatten)]
    asked: Asked,
}

/// Go on from a state that was kept, in a slot or in a file, as a new epoch
#[derive(clap::Args)]
#[command(after_help = "\
A slot brings its scene with it; a file is refused when it belongs to another scene than the present one.

Examples:
  ballroom load-state before
  ballroom load-state before.json")]
pub struct LoadState {
    /// Slot or file
    #[arg(value_name = "SLOT|FILE")]
    from: String,
    #[command(flatten)]
    asked: Asked,
}

/// List what can be gone back to: how far the history reaches, and the slots
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  ballroom slots\n  ballroom slots --json")]
pub struct Slots {
    /// The answer as a line of JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: Connection,
}

impl Rewind {
    pub fn run(self) -> anyhow::Result<()> {
        let Self { seconds, tick, epoch, asked } = self;
        asked.command(&Command::Rewind(Target { seconds, tick, epoch }), LONG_TIMEOUT)
    }
}

impl Save {
    pub fn run(self) -> anyhow::Result<()> {
        let Some(file) = file(&self.to) else {
            if self.slot.is_some() {
                bail!("{} is a slot: name a file to write another slot into", self.to);
            }
            return self.asked.command(&Command::SaveState { slot: self.to }, ANSWER_TIMEOUT);
        };
        if file.exists() {
            bail!("{} is there already: name a new file to save to", file.display());
        }
        let client = self.asked.client(LONG_TIMEOUT)?;
        let saved = client.checkpoint(self.slot.as_deref())?;
        checkpoint_file::write(&saved, &file)?;
        let (tick, time_s) = (saved.tick, saved.time_s);
        let mut out = std::io::stdout();
        if self.asked.wants_json() {
            let told =
                serde_json::json!({ "file": file, "scene": saved.scene, "tick": tick, "time_s": time_s });
            writeln!(out, "{told}")?;
        } else {
            writeln!(out, "tick {tick} of {}, {time_s} s, is in {}", saved.scene, file.display())?;
        }
        Ok(())
    }
}

impl LoadState {
    pub fn run(self) -> anyhow::Result<()> {
        let command = match file(&self.from) {
            Some(file) => {
                let state = checkpoint_file::read(&file)?;
                if state.words.len() > MAX_WORDS_BYTES {
                    let file = file.display();
                    bail!(
                        "{file} is too long for a command: begin with it, `ballroom serve --resume {file}`"
                    );
                }
                Command::LoadState { slot: None, state: Some(Box::new(state)) }
            }
            None => Command::LoadState { slot: Some(self.from), state: None },
        };
        self.asked.command(&command, LONG_TIMEOUT)
    }
}

impl Slots {
    pub fn run(self) -> anyhow::Result<()> {
        let timeline = self.connection.open(Abort::default(), ANSWER_TIMEOUT)?.slots()?;
        let mut out = std::io::stdout().lock();
        if self.json {
            writeln!(out, "{}", serde_json::to_string(&timeline)?)?;
            return Ok(());
        }
        let history = &timeline.history;
        let [taken, most] = [history.bytes, history.max_bytes].map(|bytes| bytes as f64 / f64::from(1 << 20));
        if history.points > 0 {
            writeln!(
                out,
                "history  {:.1} s back, to tick {} of epoch {}; {} points, {taken:.1} of {most} MiB",
                history.reach_s, history.oldest_tick, history.oldest_epoch, history.points
            )?;
        } else {
            writeln!(out, "history  none")?;
        }
        for slot in &timeline.slots {
            writeln!(
                out,
                "{:32} tick {} of epoch {}, {} s, {}",
                slot.name, slot.tick, slot.epoch, slot.time_s, slot.scene
            )?;
        }
        Ok(())
    }
}

/// A file, when it cannot be the name of a slot.
fn file(text: &str) -> Option<PathBuf> {
    let is_file = text.contains('.') || text.contains(std::path::is_separator);
    is_file.then(|| Path::new(text).to_owned())
}
