//! `serve`: run scenes and serve them until told to stop.

use super::ball_count::BallCount;
use super::connection::ZenohFlags;
use super::dial::Dial;
use super::resume::Resumed;
use super::signals::abort_on_signal;
use anyhow::bail;
use protocol::arenas::MAX_ARENAS;
use protocol::keys::Name;
use server::arenas::recording_beside;
use server::crew::cores_to_tick_on;
use server::history::DEFAULT_HISTORY_BYTES;
use server::recording::{MAX_HASH_EVERY_TICKS, RecordOptions};
use server::shadows::SHADOWS_MAX;
use server::{ArenaOptions, Arenas, NetworkOptions, SceneText, begin_with_enough_threads};
use std::io::Write;
use std::path::PathBuf;
use std::str::FromStr;

/// Run scenes and serve them over Zenoh; the endpoint goes to stdout
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  ballroom serve
  ballroom serve thousand --rate 120
  ballroom serve gas --balls 10000
  ballroom serve thousand --record ride.mcap
  ballroom serve bicubic --tolerance 1e-9 --estimate-error
  ballroom serve --resume ride.mcap --record more.mcap
  ballroom serve my_scene.toml -l tcp/127.0.0.1:7500 --paused
  ballroom serve bowl left=gas right=thousand

NAME=SCENE runs a scene as an arena of that name beside the others; --balls, --rate and --paused are for all of them, and
--record FILE records each in a file of its own, FILE-NAME. `ballroom arenas` lists, starts and stops arenas later on.
Without -l it listens on tcp/127.0.0.1:7447, or the next free port, and only this machine can reach it.")]
pub struct Serve {
    /// Name of a built-in scene, or a file ending in .toml; NAME=SCENE for several [default: original, or what is resumed]
    #[arg(value_name = "SCENE", num_args = 0..=MAX_ARENAS)]
    scenes: Vec<Spec>,
    #[command(flatten)]
    count: BallCount,
    #[command(flatten)]
    dial: Dial,
    /// Balls whose error is estimated while they run, by shadows that move a hundred times more exactly; 8 at most
    #[arg(long, value_name = "BALLS", num_args = 0..=1, require_equals = true, default_value_t = 0, default_missing_value = "8")]
    #[arg(value_parser = clap::value_parser!(u8).range(0..=SHADOWS_MAX as i64))]
    estimate_error: u8,
    /// Ticks a simulated second [default: 60, or as it was]
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(1..=1000))]
    rate: Option<u32>,
    /// Threads for a large scene [default: all cores but one, which publishes]; they change no bit
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,
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
    /// Name in the keys of an arena without one
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

/// A scene, and the arena that runs it.
#[derive(Clone, Debug)]
struct Spec {
    name: Option<Name>,
    scene: String,
}

impl FromStr for Spec {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        // A path may hold the sign too; what stands before it is then no name.
        let parts = text.split_once('=').and_then(|(name, scene)| Some((name.parse().ok()?, scene)));
        Ok(match parts {
            Some((name, scene)) => Self { name: Some(name), scene: scene.to_owned() },
            None => Self { name: None, scene: text.to_owned() },
        })
    }
}

impl Serve {
    /// The scenes that were named, or what is resumed, each with the name of its arena.
    fn scenes(&self, found: Option<SceneText>) -> anyhow::Result<Vec<(Name, SceneText)>> {
        if self.resume.is_some() && self.scenes.len() > 1 {
            bail!("a run that is resumed is of one scene: name it, or none");
        }
        let open = |spec: &Spec| {
            let name = spec.name.as_ref().unwrap_or(&self.arena);
            Ok((name.clone(), self.dial.of(self.count.open(&spec.scene)?)))
        };
        let named = self.scenes.iter().map(open).collect::<anyhow::Result<Vec<_>>>()?;
        if !named.is_empty() {
            return Ok(named);
        }
        let scene = match found {
            Some(scene) => self.dial.of(self.count.of(scene)),
            None if self.resume.is_some() => bail!("name the scene that the run belongs to"),
            None => self.dial.of(self.count.open("original")?),
        };
        Ok(vec![(self.arena.clone(), scene)])
    }

    pub fn run(self) -> anyhow::Result<()> {
        begin_with_enough_threads();
        let abort = abort_on_signal()?;
        let resumed = self.resume.as_deref().map(|file| Resumed::from_file(file, || abort.is_aborted()));
        let (found, first, rate) = match resumed.transpose()? {
            Some(Resumed { scene, first, tick_rate_hz }) => (scene, first, Some(tick_rate_hz)),
            None => (None, Vec::new(), None),
        };
        if let Some(file) = &self.resume {
            let recorded = if self.recording.record.is_some() { "" } else { "; --record keeps what follows" };
            tracing::info!("goes on where {} ends{recorded}", file.display());
        }
        let rate_hz = self.rate.or(rate).unwrap_or(60);
        let scenes = self.scenes(found)?;
        let network = NetworkOptions {
            listen: self.listen,
            connect: self.connect,
            config: self.zenoh.config,
            settings: self.zenoh.cfg,
        };
        let record = self.recording.options();
        let mut arenas = Arenas::open(&network, record.clone())?;
        for (name, scene) in &scenes {
            let record = match &record {
                Some(record) if scenes.len() > 1 => Some(recording_beside(record, name)),
                record => record.clone(),
            };
            let options = ArenaOptions {
                arena: name.clone(),
                tick_rate_hz: rate_hz,
                threads: self.threads.map_or_else(cores_to_tick_on, |threads| threads as usize),
                paused: self.paused,
                record,
                history_bytes: self.history << 20,
                shadows: usize::from(self.estimate_error),
                first: first.clone(),
                ..ArenaOptions::default()
            };
            arenas.start(scene, &options)?;
            tracing::info!("{} runs at {rate_hz} Hz as arena {name} on {}", scene.file(), arenas.endpoint());
        }
        // Scripts wait for this line; nobody has to.
        drop(writeln!(std::io::stdout(), "{}", arenas.endpoint()));
        let faults = arenas.run(|| abort.is_aborted());
        if !faults.is_empty() {
            let names: Vec<&str> = faults.iter().map(Name::as_str).collect();
            bail!("ended by a fault, which the log names: arena {}", names.join(", "));
        }
        tracing::info!("ended");
        Ok(())
    }
}
