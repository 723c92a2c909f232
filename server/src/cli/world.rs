//! `load`, `reload`, `scenes` and `features`: another scene, and what there is to choose from.

use super::connection::{ANSWER_TIMEOUT, Asked, Connection, LONG_TIMEOUT};
use anyhow::Context;
use ballroom_client::Abort;
use protocol::codec::MAX_REQUEST_BYTES;
use protocol::command::Command;
use std::io::{Read, Write};
use std::path::Path;

/// Go on with another scene
#[derive(clap::Args)]
#[command(after_help = "\
A file is read here and sent to the server, which refuses it with line and field if it cannot be run; the present scene
then goes on.

Examples:
  ballroom load bowl
  ballroom load gas --balls 2000
  ballroom load my_scene.toml")]
pub struct Load {
    /// Name of a built-in scene, or a file ending in .toml
    scene: String,
    /// Balls in all, for a scene with one cloud
    #[arg(long, value_name = "N")]
    balls: Option<u32>,
    #[command(flatten)]
    asked: Asked,
}

/// Read the scene's file again that the arena was started with
#[derive(clap::Args)]
#[command(after_help = "\
The server reads it where it was started; what cannot be run is refused with line and field, and the present scene goes on.

Examples:
  ballroom reload
  ballroom reload --arena left --json")]
pub struct Reload {
    #[command(flatten)]
    asked: Asked,
}

/// List the scenes that come with the server
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  ballroom scenes\n  ballroom scenes --json | jq -r '.scenes[].name'")]
pub struct Scenes {
    /// The answer as a line of JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: Connection,
}

/// List what the server understands, with limits
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  ballroom features\n  ballroom features --json | jq .commands.step")]
pub struct Features {
    /// The answer as a line of JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: Connection,
}

impl Load {
    pub fn run(self) -> anyhow::Result<()> {
        let (name, toml) = name_or_text(&self.scene)?;
        let command = Command::LoadScene { name, toml, balls: self.balls };
        self.asked.command(&command, LONG_TIMEOUT)
    }
}

impl Reload {
    pub fn run(self) -> anyhow::Result<()> {
        self.asked.command(&Command::ReloadScene {}, LONG_TIMEOUT)
    }
}

/// The name of a scene, or the text of its file, as the server takes them.
pub fn name_or_text(scene: &str) -> anyhow::Result<(Option<String>, Option<String>)> {
    let path = Path::new(scene);
    let is_file =
        path.extension().is_some_and(|end| end == "toml") || scene.contains(std::path::is_separator);
    if !is_file {
        return Ok((Some(scene.to_owned()), None));
    }
    let mut toml = String::new();
    let file = std::fs::File::open(path).with_context(|| format!("{scene} cannot be opened"))?;
    // The server reads no more; one byte beyond shows that there is more.
    let read = file.take(MAX_REQUEST_BYTES as u64 + 1).read_to_string(&mut toml);
    read.with_context(|| format!("{scene} cannot be read"))?;
    Ok((None, Some(toml)))
}

impl Scenes {
    pub fn run(self) -> anyhow::Result<()> {
        let scenes = self.connection.open(Abort::default(), ANSWER_TIMEOUT)?.scenes()?;
        let mut out = std::io::stdout().lock();
        if self.json {
            writeln!(out, "{}", serde_json::to_string(&scenes)?)?;
            return Ok(());
        }
        for scene in scenes.scenes {
            writeln!(out, "{:24} {}", scene.name, scene.description)?;
        }
        Ok(())
    }
}

impl Features {
    pub fn run(self) -> anyhow::Result<()> {
        let features = self.connection.open(Abort::default(), ANSWER_TIMEOUT)?.features()?;
        let mut out = std::io::stdout().lock();
        if self.json {
            writeln!(out, "{}", serde_json::to_string(&features)?)?;
            return Ok(());
        }
        for (kind, entries) in [("command", features.commands), ("question", features.questions)] {
            for (name, limits) in entries {
                let limits: Vec<_> = limits.iter().map(|(name, limit)| format!("{name} {limit}")).collect();
                writeln!(out, "{kind:8} {name:12} {}", limits.join(", "))?;
            }
        }
        for (name, number) in features.ros {
            writeln!(out, "{:8} {name} {number}", "ros")?;
        }
        Ok(())
    }
}
