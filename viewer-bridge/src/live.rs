//! Serving viewers on this machine: the data over gRPC, and the web viewer that is built into the program.
//!
//! Viewers come, go and join late; the server holds a bounded history for them and never waits for one to come.

use anyhow::{Context, Result, bail};
use rerun::grpc_server::GrpcServerSink;
use rerun::sink::LogSink;
use rerun::web_viewer::WebViewerConfig;
use rerun::{MemoryLimit, ServerOptions};
use std::net::{Ipv4Addr, TcpListener};
use std::process::{Command, Stdio};

/// The viewer must match this version exactly.
pub const RERUN_VERSION: &str = "0.36.3";

/// Nobody else's machine: there is no password on this door.
const LOOPBACK: Ipv4Addr = Ipv4Addr::LOCALHOST;
const GRPC_PORT: u16 = 9876;
const WEB_PORT: u16 = 9090;
/// Ports tried in a row before giving up.
const PORTS_TRIED: u16 = 32;
/// History kept for viewers that join late, bytes. The oldest goes first, static data stays.
const HISTORY_BYTES: u64 = 256 << 20;

/// Where viewers find the data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Live {
    /// For a native viewer: `rerun --connect URL`.
    pub grpc_url: String,
    /// For a browser.
    pub web_url: String,
}

/// Serves what goes into the sink to viewers, until the sink is dropped.
pub fn serve() -> Result<(Box<dyn LogSink>, Live)> {
    let port = free_port(GRPC_PORT)?;
    let limits =
        ServerOptions { memory_limit: MemoryLimit::from_bytes(HISTORY_BYTES), ..ServerOptions::default() };
    let sink = GrpcServerSink::new(&LOOPBACK.to_string(), port, limits)
        .with_context(|| format!("cannot serve viewers on port {port}"))?;
    let grpc_url = format!("rerun+http://{LOOPBACK}:{port}/proxy");
    let web_url = serve_web_viewer(&grpc_url)?;
    Ok((Box::new(sink), Live { grpc_url, web_url }))
}

/// Serves the built-in web viewer and returns the address that opens it on the data.
fn serve_web_viewer(grpc_url: &str) -> Result<String> {
    let port = free_port(WEB_PORT)?;
    let config = WebViewerConfig {
        bind_ip: LOOPBACK.to_string(),
        web_port: port.into(),
        open_browser: false,
        ..WebViewerConfig::default()
    };
    let server = rerun::serve_web_viewer(config)
        .with_context(|| format!("cannot serve the web viewer on port {port}"))?;
    let url = format!(
        "{}?url={}",
        server.server_url(),
        grpc_url.replace('+', "%2B").replace(':', "%3A").replace('/', "%2F")
    );
    // It serves until the program ends.
    server.detach();
    Ok(url)
}

/// The first free port from `wanted` on; a step aside is told.
fn free_port(wanted: u16) -> Result<u16> {
    let mut ports = wanted..wanted.saturating_add(PORTS_TRIED);
    let Some(port) = ports.find(|port| TcpListener::bind((LOOPBACK, *port)).is_ok()) else {
        bail!("ports {wanted} to {} are all taken: end what listens there", wanted + PORTS_TRIED - 1);
    };
    if port != wanted {
        tracing::info!("port {wanted} is taken, using {port}");
    }
    Ok(port)
}

impl Live {
    /// Tells where viewers find the data, and opens one.
    pub fn announce(&self) {
        tracing::info!("in a browser: {}", self.web_url);
        tracing::info!("natively:     rerun --connect {}", self.grpc_url);
        self.open();
    }

    /// Opens a viewer where there is a screen: the native one if its version matches, else the browser. It happens
    /// in the background, for starting either may take seconds.
    pub fn open(&self) {
        if !has_screen() {
            tracing::info!("no screen here, so no viewer is opened");
            return;
        }
        let live = self.clone();
        let opened = std::thread::Builder::new().name("open-viewer".into()).spawn(move || live.open_now());
        if let Err(fault) = opened {
            tracing::warn!("cannot open a viewer: {fault}; open {} yourself", self.web_url);
        }
    }

    fn open_now(&self) {
        match native_version() {
            Some(version) if version == RERUN_VERSION => match spawn_native(&self.grpc_url) {
                Ok(()) => return,
                Err(fault) => tracing::warn!("the native viewer does not start: {fault}"),
            },
            Some(version) => tracing::info!(
                "the installed rerun {version} does not match {RERUN_VERSION}, using the browser \
                 (`pip install rerun-sdk=={RERUN_VERSION}` brings the native viewer)"
            ),
            None => {}
        }
        if let Err(fault) = webbrowser::open(&self.web_url) {
            tracing::info!("no browser opens here ({fault}): open {} yourself", self.web_url);
        }
    }
}

/// Whether a window could be seen.
pub fn has_screen() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(any(target_os = "macos", target_os = "windows")) || set("DISPLAY") || set("WAYLAND_DISPLAY")
}

/// Version of the `rerun` program in the path, if there is one.
fn native_version() -> Option<String> {
    let output =
        Command::new("rerun").arg("--version").stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
    version_in(&String::from_utf8_lossy(&output.stdout))
}

/// `rerun-cli 0.36.3 (features) [compiler] …`
fn version_in(line: &str) -> Option<String> {
    let mut words = line.split_whitespace();
    words.find(|word| *word == "rerun-cli")?;
    words.next().map(str::to_owned)
}

/// Its own words would run into the status line; the window stays when this program ends, with what it has shown.
fn spawn_native(grpc_url: &str) -> std::io::Result<()> {
    let mut viewer = Command::new("rerun");
    viewer.args(["--connect", grpc_url, "--hide-welcome-screen"]);
    viewer.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    viewer.spawn().map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_taken_port_is_stepped_around() {
        let taken = TcpListener::bind((LOOPBACK, 0)).unwrap();
        let port = taken.local_addr().unwrap().port();
        if port < u16::MAX - PORTS_TRIED {
            assert!(free_port(port).unwrap() > port);
        }
    }

    #[test]
    fn the_version_is_read_from_the_programs_own_line() {
        let line =
            "rerun-cli 0.36.3 (base map_view) [rustc 1.95.0] x86_64-unknown-linux-gnu, built 2026-08-24";
        assert_eq!(version_in(line).as_deref(), Some(RERUN_VERSION));
        assert_eq!(version_in("GNU rerun"), None);
    }
}
