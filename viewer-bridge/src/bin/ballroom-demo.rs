//! `ballroom-demo`: the main job in one process. A server with a scene, a real Zenoh session on loopback, a Rerun
//! viewer, and the keys of this terminal on the player's ball.

use anyhow::{Context, Result, bail};
use ballroom_client::{Abort, Client, ClientOptions, Patience};
use clap::Parser;
use crossterm::event::{self, Event};
use server::shadows::SHADOWS_MAX;
use server::{Arena, ArenaHandle, ArenaOptions, SceneText};
use std::net::IpAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};
use viewer_bridge::bridge::{Bridge, Options, pump};
use viewer_bridge::demo::keys::{Keys, Wish};
use viewer_bridge::demo::pilot::Pilot;
use viewer_bridge::demo::screen::{self, LogLines, RawMode};
use viewer_bridge::demo::status::Status;
use viewer_bridge::live;
use viewer_bridge::named_view::NamedView;
use viewer_bridge::process;
use viewer_bridge::slot::Slot;

const KEYS: &str =
    "arrows drive your ball, space pauses, . steps, r resets, + and - change the speed, q quits";
const EXAMPLES: &str = "\
Keys: arrows drive your ball, space pauses, . steps, r resets, + and - change the speed, q quits.

Examples:
  ballroom-demo                          the original scene, and a viewer
  ballroom-demo thousand                 a thousand balls in a bowl
  ballroom-demo my_scene.toml --rate 240
  ballroom-demo --no-viewer --save ride.rrd --for 10

Without a terminal it runs until --for is over or a signal ends it. Exit codes: 0 ended as asked, 1 failed, 2 wrong
usage, 130 ended at once by a second signal.";

/// How often the status line is drawn, and how often it is logged where there is no terminal.
const DRAW_EVERY: Duration = Duration::from_millis(100);
const LOG_EVERY: Duration = Duration::from_secs(10);
/// Longest wait for a key before the rest is looked after.
const KEY_PATIENCE: Duration = Duration::from_millis(10);
/// How long the arena may take to end.
const ARENA_PATIENCE: Duration = Duration::from_secs(3);

/// Balls rolling on a Bezier floor: server, viewer and steering in one program.
#[derive(Parser)]
#[command(name = "ballroom-demo", version, after_help = EXAMPLES)]
struct Arguments {
    /// Name of a built-in scene, or a scene file
    #[arg(default_value = "original")]
    scene: String,
    /// Ticks per simulated second
    #[arg(long, value_name = "HZ", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rate: u32,
    /// Position error wanted over 10 s of smooth motion, 1e-13 to 1e-2 m, in place of the scene's accuracy
    #[arg(long, value_name = "METRES", value_parser = metres)]
    tolerance: Option<f64>,
    /// Balls whose error is estimated and plotted while they run; 8 at most
    #[arg(long, value_name = "BALLS", num_args = 0..=1, require_equals = true, default_value_t = 0, default_missing_value = "8")]
    #[arg(value_parser = clap::value_parser!(u8).range(0..=SHADOWS_MAX as i64))]
    estimate_error: u8,
    /// Write everything to this Rerun recording too
    #[arg(long, value_name = "FILE.rrd")]
    save: Option<PathBuf>,
    /// View to open with: overview, top, side, vectors, net, follow or follow:BALL
    #[arg(long, value_name = "VIEW", default_value = "overview")]
    view: NamedView,
    /// Let other machines watch: the address to serve viewers on, 0.0.0.0 for all this machine has
    #[arg(long, value_name = "ADDRESS", conflicts_with = "no_viewer")]
    listen: Option<IpAddr>,
    /// Serve no viewer and open none
    #[arg(long, visible_alias = "headless")]
    no_viewer: bool,
    /// End by itself after so many seconds
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    duration: Option<Duration>,
}

fn metres(text: &str) -> Result<f64, String> {
    let metres: f64 = text.parse().map_err(|fault| format!("{fault}"))?;
    if (1e-13..=1e-2).contains(&metres) { Ok(metres) } else { Err("use 1e-13 to 1e-2 metres".into()) }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let number: f64 = text.parse().map_err(|_| format!("{text} is not a number of seconds"))?;
    Duration::try_from_secs_f64(number).map_err(|fault| fault.to_string())
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    process::log_to(LogLines::default);
    server::begin_with_enough_threads();
    let result = run(&arguments);
    screen::restore();
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            tracing::error!("{fault:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let abort = Abort::default();
    process::on_signal(abort.clone(), screen::restore)?;

    let scene = SceneText::open(&arguments.scene)?.with_tolerance(arguments.tolerance);
    let options = ArenaOptions {
        tick_rate_hz: arguments.rate,
        shadows: usize::from(arguments.estimate_error),
        ..ArenaOptions::default()
    };
    let arena = Arena::start(&scene, &options)?;
    tracing::info!("scene {} at {} Hz on {}", arguments.scene, arguments.rate, arena.endpoint());
    let bridge = Bridge::start(&Options {
        serve: (!arguments.no_viewer).then(|| arguments.listen.unwrap_or(live::LOOPBACK)),
        connect: None,
        save: arguments.save.clone(),
        frames_per_second: 60,
        view: arguments.view.clone(),
    })?;
    let result = join(arguments, &abort, &arena, &bridge);
    abort.abort();

    let written = bridge.stop();
    if process::within(ARENA_PATIENCE, move || arena.join()).is_none() {
        tracing::warn!("the arena did not end within {ARENA_PATIENCE:?} and is left behind");
    }
    result?;
    if written { Ok(()) } else { bail!("the recording is incomplete") }
}

/// Joins the arena to the recordings through a session of its own, and gives the terminal to the player.
fn join(arguments: &Arguments, abort: &Abort, arena: &ArenaHandle, bridge: &Bridge) -> Result<()> {
    let client = Client::open(ClientOptions {
        endpoints: vec![arena.endpoint().to_owned()],
        patience: Patience::GiveUpAfter(Duration::from_secs(10)),
        role: protocol::keys::Role::Viewer,
        abort: abort.clone(),
        ..ClientOptions::default()
    })?;
    let own = Arc::new(Slot::default());
    let slots = [bridge.slots(), vec![own.clone()]].concat();
    let (carrier, end) = (client.clone(), abort.clone());
    let pumping = std::thread::Builder::new().name("pump".into()).spawn(move || {
        let result = pump(&carrier, &slots);
        end.abort();
        result
    })?;

    if let Some(live) = bridge.live() {
        live.announce();
    }
    let table = Table {
        abort: abort.clone(),
        arena,
        slot: own,
        deadline: arguments.duration.map(|d| Instant::now() + d),
    };
    let result = match RawMode::enter().context("cannot take the terminal over")? {
        Some(terminal) => table.play(&terminal, Pilot::new(client, "keyboard".parse()?)?, bridge),
        None => table.watch(),
    };
    abort.abort();
    let pumped = pumping.join().unwrap_or_else(|_| bail!("the bridge panicked"));
    result.and(pumped)
}

/// What both ways of sitting at the table look at.
struct Table<'a> {
    abort: Abort,
    arena: &'a ArenaHandle,
    slot: Arc<Slot>,
    deadline: Option<Instant>,
}

impl Table<'_> {
    /// Keys in, status line out, until someone wants the end.
    fn play(&self, terminal: &RawMode, mut pilot: Pilot, bridge: &Bridge) -> Result<()> {
        tracing::info!("{KEYS}");
        let viewer = bridge.live().map_or(String::new(), |live| format!(" | {}", live.web_url));
        let mut keys = Keys::new(terminal.reports_releases());
        let mut status = Status::default();
        let mut drawn = Instant::now();
        while self.goes_on()? {
            let wish = if event::poll(KEY_PATIENCE)? {
                match event::read()? {
                    Event::Key(key) => keys.wish(key),
                    Event::FocusLost => keys.let_go(),
                    _ => None,
                }
            } else {
                None
            };
            if let Some(wish) = wish {
                if wish == Wish::Quit {
                    return Ok(());
                }
                pilot.fulfil(wish, status.paused, status.speed_factor());
            }
            pilot.renew(keys.held(), status.speed_factor());
            self.update(&mut status, Duration::ZERO);
            if drawn.elapsed() >= DRAW_EVERY {
                drawn = Instant::now();
                terminal.show(&status.line(pilot.speed(status.speed_factor())), &viewer)?;
            }
        }
        Ok(())
    }

    /// No terminal: a line now and then.
    fn watch(&self) -> Result<()> {
        tracing::info!("no terminal here, so no keys: running until SIGINT or SIGTERM{}", self.or_deadline());
        let mut status = Status::default();
        let mut told = Instant::now();
        while self.goes_on()? {
            self.update(&mut status, DRAW_EVERY);
            if told.elapsed() >= LOG_EVERY {
                told = Instant::now();
                tracing::info!("{}", status.line(status.speed_factor()));
            }
        }
        tracing::info!("{}", status.line(status.speed_factor()));
        Ok(())
    }

    fn or_deadline(&self) -> String {
        let left =
            self.deadline.map(|deadline| deadline.saturating_duration_since(Instant::now()).as_secs_f64());
        left.map_or(String::new(), |left| format!(", or for {left:.0} s"))
    }

    fn update(&self, status: &mut Status, patience: Duration) {
        if let Some(news) = self.slot.take(patience) {
            status.update(&news);
        }
    }

    fn goes_on(&self) -> Result<bool> {
        if self.arena.has_quit() {
            return Ok(false);
        }
        if self.arena.is_finished() && !self.abort.is_aborted() {
            bail!("the arena ended by itself; its log tells why");
        }
        Ok(!self.abort.is_aborted() && self.deadline.is_none_or(|deadline| Instant::now() < deadline))
    }
}
