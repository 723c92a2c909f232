//! Where viewers find the data: ports, the web viewer that is built into the program, and the native one.

use crate::hub::Hub;
use crate::watch;
use anyhow::{Context, Result, bail};
use rerun::external::re_uri::ProxyUri;
use rerun::web_viewer::WebViewerConfig;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, UdpSocket};
use std::process::{Command, Stdio};
use std::sync::Arc;

/// The viewer must match this version exactly.
pub const RERUN_VERSION: &str = "0.36.3";

/// Nobody else's machine, unless asked for: there is no password on this door.
pub const LOOPBACK: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);
const GRPC_PORT: u16 = 9876;
const WEB_PORT: u16 = 9090;
/// Ports tried in a row before giving up.
const PORTS_TRIED: u16 = 32;

/// Where viewers find the data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Live {
    /// For a native viewer: `rerun --connect URL`.
    pub grpc_url: String,
    /// For a browser.
    pub web_url: String,
    /// Whether other machines may watch.
    pub open: bool,
}

/// A viewer's address as people write it: the whole URL, or HOST:PORT.
pub fn viewer_address(text: &str) -> Result<ProxyUri, String> {
    let refused = |why: &str| {
        format!(
            "{why}; write rerun+http://HOST:9876/proxy or HOST:9876 (a Ballroom server's endpoint goes to -e)"
        )
    };
    let port = text.rsplit_once(':').map(|(_, port)| port.parse::<u16>());
    let url = match port {
        _ if text.contains("://") => text.to_owned(),
        Some(Ok(_)) if !text.contains('/') => format!("rerun+http://{text}/proxy"),
        _ => return Err(refused("no viewer's address")),
    };
    url.parse().map_err(|fault: rerun::external::re_uri::Error| refused(&fault.to_string()))
}

/// Serves what the hub holds on an address of this machine, until the process ends.
pub fn serve(hub: Arc<Hub>, listen: IpAddr) -> Result<Live> {
    let grpc = free_port(listen, GRPC_PORT)?;
    let host = reachable(listen);
    let grpc_url = format!("rerun+http://{}/proxy", SocketAddr::new(host, grpc.local_addr()?.port()));
    let web_port = free_port(listen, WEB_PORT)?.local_addr()?.port();
    // A page that came from this machine may ask it, by whatever name the machine was called.
    let origins = if listen.is_loopback() { vec![] } else { vec![format!("http://*:{web_port}")] };
    watch::serve(hub, grpc, &origins).context("cannot serve viewers")?;
    serve_web_viewer(listen, web_port)?;
    let web_url = format!(
        "http://{}/?url={}",
        SocketAddr::new(host, web_port),
        grpc_url.replace('+', "%2B").replace(':', "%3A").replace('/', "%2F")
    );
    Ok(Live { grpc_url, web_url, open: !listen.is_loopback() })
}

/// Serves the built-in web viewer until the process ends.
fn serve_web_viewer(listen: IpAddr, port: u16) -> Result<()> {
    let config = WebViewerConfig {
        bind_ip: listen.to_string(),
        web_port: port.into(),
        open_browser: false,
        ..WebViewerConfig::default()
    };
    let server = rerun::serve_web_viewer(config)
        .with_context(|| format!("cannot serve the web viewer on port {port}"))?;
    server.detach();
    Ok(())
}

/// The first free port from `wanted` on, taken; a step aside is told.
fn free_port(listen: IpAddr, wanted: u16) -> Result<TcpListener> {
    for port in wanted..wanted.saturating_add(PORTS_TRIED) {
        match TcpListener::bind((listen, port)) {
            Ok(listener) => {
                if port != wanted {
                    tracing::info!("port {wanted} is taken, using {port}");
                }
                return Ok(listener);
            }
            Err(fault) if fault.kind() == std::io::ErrorKind::AddrInUse => {}
            Err(fault) => {
                bail!(
                    "cannot listen on {listen}: {fault}; name an address of this machine, or 0.0.0.0 for all"
                )
            }
        }
    }
    bail!("ports {wanted} to {} are all taken: end what listens there", wanted + PORTS_TRIED - 1)
}

/// The address that others use: where all are listened on, that of the interface towards the outside.
fn reachable(listen: IpAddr) -> IpAddr {
    if !listen.is_unspecified() {
        return listen;
    }
    // Connecting a datagram socket sends nothing; 192.0.2.1 is an address for documentation.
    let outward = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))
        .and_then(|socket| socket.connect(("192.0.2.1", 9)).and_then(|()| socket.local_addr()));
    outward.map_or(LOOPBACK, |address| address.ip())
}

impl Live {
    /// Tells where viewers find the data, and opens one.
    pub fn announce(&self) {
        if self.open {
            tracing::warn!("whoever reaches these ports can watch; nobody can draw or steer through them");
        }
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
            assert!(free_port(LOOPBACK, port).unwrap().local_addr().unwrap().port() > port);
        }
    }

    #[test]
    fn an_address_of_another_machine_is_refused_and_named() {
        let elsewhere = "192.0.2.1".parse().unwrap();
        assert!(free_port(elsewhere, 9876).unwrap_err().to_string().contains("192.0.2.1"));
    }

    #[test]
    fn a_viewers_address_may_be_short_and_an_endpoint_is_none() {
        let whole = viewer_address("rerun+http://10.0.0.7:9876/proxy").unwrap();
        assert_eq!(viewer_address("10.0.0.7:9876").unwrap(), whole);
        for wrong in ["tcp/127.0.0.1:7447", "10.0.0.7", "http://x y"] {
            assert!(viewer_address(wrong).unwrap_err().contains("write rerun+http://"), "{wrong}");
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
