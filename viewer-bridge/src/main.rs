//! `ballroom-viewer`: shows a Ballroom server's arena in Rerun, and writes it to a file.

use anyhow::{Result, bail};
use ballroom_client::{Client, ClientOptions, DEFAULT_ENDPOINT, Patience, Setting};
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};
use protocol::keys::{DEFAULT_ARENA, Name, Role};
use rerun::external::re_uri::ProxyUri;
use std::net::IpAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use viewer_bridge::bridge::{Bridge, Options, pump};
use viewer_bridge::live;
use viewer_bridge::named_view::NamedView;
use viewer_bridge::process;

const EXAMPLES: &str = "\
Examples:
  ballroom-viewer                                   a server on this machine, a viewer beside it
  ballroom-viewer -e tcp/192.168.1.20:7447          a server elsewhere
  ballroom-viewer --view follow:red                 with the eye behind a ball
  ballroom-viewer --listen 0.0.0.0                  other machines may watch too
  ballroom-viewer --connect 192.168.1.30:9876       show it on a viewer elsewhere, started with plain `rerun`
  ballroom-viewer --save ride.rrd                   watch, and keep it
  ballroom-viewer --save ride.rrd --no-viewer       keep it only
  rerun ride.rrd                                    look at it later (pip install rerun-sdk==0.36.3)

It may be started before the server and outlives its restarts. Ctrl-C or SIGTERM ends it and completes the file; a
second one ends it at once. Exit codes: 0 ended as asked, 1 failed, 2 wrong usage, 130 ended at once.";

/// Shows a Ballroom server's arena in Rerun, and writes it to a file.
#[derive(Parser)]
#[command(name = "ballroom-viewer", version, after_help = EXAMPLES)]
struct Arguments {
    /// Zenoh endpoint of the server, for instance tcp/127.0.0.1:7447; may be repeated
    #[arg(short = 'e', long = "endpoint", value_name = "ENDPOINT")]
    endpoints: Vec<String>,
    /// Zenoh configuration file, JSON5 or YAML
    #[arg(short = 'c', long, value_name = "FILE", env = "ZENOH_CONFIG")]
    config: Option<PathBuf>,
    /// One setting of Zenoh, for instance transport/link/tx/lease:5000; may be repeated
    #[arg(long, value_name = "KEY:VALUE")]
    cfg: Vec<Setting>,
    /// Which of the server's arenas
    #[arg(long, default_value = DEFAULT_ARENA)]
    arena: Name,
    /// Write everything to this Rerun recording too
    #[arg(long, value_name = "FILE.rrd")]
    save: Option<PathBuf>,
    /// Send to a viewer elsewhere, for instance 192.168.1.30:9876
    #[arg(long, value_name = "URL", value_parser = live::viewer_address)]
    connect: Option<ProxyUri>,
    /// Let other machines watch: the address to serve viewers on, 0.0.0.0 for all this machine has
    #[arg(long, value_name = "ADDRESS", conflicts_with = "no_viewer")]
    listen: Option<IpAddr>,
    /// Serve no viewer and open none
    #[arg(long, visible_alias = "headless")]
    no_viewer: bool,
    /// Frames per second at most
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=1000))]
    fps: u32,
    /// View to open with: overview, top, side, vectors, net, follow or follow:BALL
    #[arg(long, value_name = "VIEW", default_value = "overview")]
    view: NamedView,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.no_viewer && arguments.save.is_none() && arguments.connect.is_none() {
        let mistake = "with --no-viewer nothing would be shown or kept: add --save FILE.rrd or --connect URL";
        Arguments::command().error(ErrorKind::MissingRequiredArgument, mistake).exit();
    }
    process::log_to_stderr();
    match run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            tracing::error!("{fault:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: Arguments) -> Result<()> {
    let options = ClientOptions {
        endpoints: arguments.endpoints,
        config: arguments.config,
        settings: arguments.cfg,
        arena: arguments.arena,
        patience: Patience::WaitForServer,
        role: Role::Viewer,
        ..ClientOptions::default()
    };
    process::on_signal(options.abort.clone(), || {})?;

    let bridge = Bridge::start(&Options {
        // Where a viewer elsewhere is named, none is served here unless that is asked for too.
        serve: match (arguments.listen, &arguments.connect) {
            (Some(listen), _) => Some(listen),
            (None, None) if !arguments.no_viewer => Some(live::LOOPBACK),
            (None, _) => None,
        },
        connect: arguments.connect,
        save: arguments.save,
        frames_per_second: arguments.fps,
        view: arguments.view,
    })?;
    if let Some(live) = bridge.live() {
        live.announce();
    }
    let result = follow(options, &bridge);
    if !bridge.stop() {
        bail!("the recording is incomplete");
    }
    result
}

fn follow(options: ClientOptions, bridge: &Bridge) -> Result<()> {
    let abort = options.abort.clone();
    let place = options.endpoints.first().map_or(DEFAULT_ENDPOINT, String::as_str);
    tracing::info!("following arena {} at {place}; waiting for it if it is not there yet", options.arena);
    let result = Client::open(options).map_err(Into::into).and_then(|client| {
        let result = pump(&client, &bridge.slots());
        process::within(process::CLOSE_PATIENCE, move || drop(client));
        result
    });
    // Being ended while waiting is what was asked for.
    if abort.is_aborted() { Ok(()) } else { result }
}
