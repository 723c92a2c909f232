//! `serve`: run a scene and serve it until told to stop.

use super::ball_count::BallCount;
use super::connection::ZenohFlags;
use super::resume::Resumed;
use super::signals::abort_on_signal;
use anyhow::bail;
use protocol::keys::Name;
use server::history::DEFAULT_HISTORY_BYTES;
use server::recording::{MAX_HASH_EVERY_TICKS, RecordOptions};
use server::{Arena, ArenaOptions};
use std::io::Write;
use std::path::PathBuf;
use std::time::Duration;

/// Run a scene and serve it over Zenoh; the endpoint goes to stdout
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  ballroom serve
  ballroom serve thousand --rate 120
  ballroom serve gas --balls 10000
  ballroom serve thousand --record ride.mcap
  ballroom serve --resume ride.mcap --record more.mcap
  ballroom serve my_scene.toml -l tcp/127.0.0.1:7500 --paused

Without -l it listens on tcp/127.0.0.1:7447, or the next free port, and only this machine can reach it.")]
pub struct Serve {
    /// Name of a built-in scene, or a file ending in .toml [default: original, or what is resumed]
    scene: Option<String>,
    #[command(flatten)]
    count: BallCount,
    /// Ticks a simulated second [default: 60, or as it was]
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(1..=1000))]
    rate: Option<u32>,
    /// Go on where a run ended: a file of `ballroom save` or `simulate --save`, or a recording, which is replayed to its end
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    /// Endpoint to listen on, for instance tcp/127.0.0.1:0 for any free port
    #[arg(short = 'l', long = "listen", value_name = "ENDPOINT")]
    listen: Vec<String>,
    /// Router to connect to
    #[arg(short = 'e', long = "connect", value_name = "ENDPOINT")]
    connect: Vec<String>,
    #[command(flatten)]
    zenoh: ZenohFlags,
    /// Name of the arena in the keys
    #[arg(long, default_value = protocol::keys::DEFAULT_ARENA, value_name = "NAME")]
    arena: Name,
    /// Begin with the clock standing
    #[arg(long)]
    paused: bool,
    #[command(flatten)]
    recording: Recording,
    /// Memory for the history that `rewind` goes back in, MiB; 0 for none
    #[arg(long, value_name = "MIB", default_value_t = DEFAULT_HISTORY_BYTES >> 20)]
    #[arg(value_parser = clap::value_parser!(u64).range(0..=1 << 20))]
    history: u64,
}

/// What is written down.
#[derive(clap::Args)]
struct Recording {
    /// Record scene, commands, hashes and states into a new MCAP file, for `ballroom replay`
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// States recorded a simulated second; 0 for none
    #[arg(long, value_name = "HZ", default_value_t = 10, requires = "record")]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=1000))]
    record_states_hz: u32,
    /// Ticks between two recorded hashes
    #[arg(long, value_name = "TICKS", default_value_t = 1, requires = "record")]
    #[arg(value_parser = clap::value_parser!(u64).range(1..=MAX_HASH_EVERY_TICKS))]
    record_hash_every: u64,
}

impl Recording {
    fn options(self) -> Option<RecordOptions> {
        let Self { record, record_states_hz: states_hz, record_hash_every: hash_every_ticks } = self;
        record.map(|file| RecordOptions { file, hash_every_ticks, states_hz })
    }
}

impl Serve {
    pub fn run(self) -> anyhow::Result<()> {
        let abort = abort_on_signal()?;
        let resumed = self.resume.as_deref().map(|file| Resumed::from_file(file, || abort.is_aborted()));
        let (found, first, rate) = match resumed.transpose()? {
            Some(Resumed { scene, first, tick_rate_hz }) => (scene, first, Some(tick_rate_hz)),
            None => (None, Vec::new(), None),
        };
        let scene = match (&self.scene, found) {
            (Some(scene), _) => self.count.open(scene)?,
            (None, Some(scene)) => self.count.of(scene),
            (None, None) if self.resume.is_some() => bail!("name the scene that the run belongs to"),
            (None, None) => self.count.open("original")?,
        };
        let options = ArenaOptions {
            arena: self.arena,
            tick_rate_hz: self.rate.or(rate).unwrap_or(60),
            paused: self.paused,
            listen: self.listen,
            connect: self.connect,
            config: self.zenoh.config,
            settings: self.zenoh.cfg,
            record: self.recording.options(),
            history_bytes: self.history << 20,
            first,
        };
        let arena = Arena::start(&scene, &options)?;
        let (endpoint, name) = (arena.endpoint(), &options.arena);
        tracing::info!("{} runs at {} Hz as arena {name} on {endpoint}", scene.file(), options.tick_rate_hz);
        // Scripts wait for this line; nobody has to.
        drop(writeln!(std::io::stdout(), "{endpoint}"));
        while !abort.is_aborted() && !arena.is_finished() {
            std::thread::sleep(Duration::from_millis(20));
        }
        let asked = abort.is_aborted();
        if !(arena.join() && asked) {
            bail!("the arena ended by itself; the log says why");
        }
        tracing::info!("ended");
        Ok(())
    }
}
