//! How tools reach a server.

use super::exit::Refused;
use ballroom_client::{Abort, Client, ClientOptions, Setting};
use protocol::arenas::ArenaCommand;
use protocol::command::{Command, Reply};
use protocol::keys::Name;
use std::io::Write;
use std::path::PathBuf;
use std::time::Duration;

/// Zenoh's own flags, alike for server and tools.
#[derive(clap::Args, Debug)]
pub struct ZenohFlags {
    /// Zenoh configuration file, JSON5 or YAML
    #[arg(short = 'c', long, value_name = "FILE", env = "ZENOH_CONFIG")]
    pub config: Option<PathBuf>,
    /// One setting of Zenoh, for instance transport/link/tx/lease:5000; may be repeated
    #[arg(long, value_name = "KEY:VALUE")]
    pub cfg: Vec<Setting>,
}

/// Where the server is.
#[derive(clap::Args, Debug)]
pub struct Connection {
    /// Endpoint of the server [default: tcp/127.0.0.1:7447]
    #[arg(short = 'e', long = "endpoint", alias = "connect", value_name = "ENDPOINT")]
    connect: Vec<String>,
    #[command(flatten)]
    zenoh: ZenohFlags,
    /// Name of the arena
    #[arg(long, default_value = protocol::keys::DEFAULT_ARENA, value_name = "NAME")]
    arena: Name,
}

impl Connection {
    /// A session, given up after 3 s without a server.
    pub fn open(&self, abort: Abort, timeout: Duration) -> anyhow::Result<Client> {
        let options = ClientOptions {
            endpoints: self.connect.clone(),
            config: self.zenoh.config.clone(),
            settings: self.zenoh.cfg.clone(),
            arena: self.arena.clone(),
            timeout,
            abort,
            ..ClientOptions::default()
        };
        Ok(Client::open(options)?)
    }
}

/// A command to be answered, and how the answer is told.
#[derive(clap::Args, Debug)]
pub struct Asked {
    /// Print the reply as a line of JSON, whatever it says
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    connection: Connection,
}

impl Asked {
    /// A session with the server.
    pub fn client(&self, timeout: Duration) -> anyhow::Result<Client> {
        self.connection.open(Abort::default(), timeout)
    }

    /// Whether answers are wanted as JSON.
    pub const fn wants_json(&self) -> bool {
        self.json
    }

    /// Sends a command and says what came of it.
    pub fn command(&self, command: &Command, timeout: Duration) -> anyhow::Result<()> {
        let reply = self.client(timeout)?.command(command)?;
        self.tell(reply)
    }

    /// Sends a command to the process and says what came of it.
    pub fn arena_command(&self, command: &ArenaCommand, timeout: Duration) -> anyhow::Result<()> {
        let reply = self.client(timeout)?.arena_command(command)?;
        self.tell(reply)
    }

    fn tell(&self, reply: Reply) -> anyhow::Result<()> {
        let mut out = std::io::stdout();
        if self.json {
            writeln!(out, "{}", serde_json::to_string(&reply)?)?;
        }
        if !reply.ok {
            return Err(Refused(reply.error).into());
        }
        if !self.json {
            writeln!(out, "done at tick {} of epoch {}", reply.tick, reply.epoch)?;
        }
        Ok(())
    }
}

/// How long one answer may take that needs no work.
pub const ANSWER_TIMEOUT: Duration = Duration::from_secs(5);
/// How long one may take that has to be worked for: a million ticks, a floor to be proved.
pub const LONG_TIMEOUT: Duration = Duration::from_hours(1);
