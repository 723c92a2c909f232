//! One session that is its own router, on loopback unless told otherwise.

use super::NetworkError;
use crate::arena::NetworkOptions;
use std::net::{Ipv4Addr, TcpListener};
use zenoh::{Config, Session, Wait};

/// The port everybody tries first.
const FIRST_PORT: u16 = 7447;
/// How many ports after it are tried.
const MORE_PORTS: u16 = 20;

/// Most clients at once.
pub const MAX_SESSIONS: usize = 128;

/// Settings of a server without a configuration file, each with its reason.
const SETTINGS: [(&str, &str); 13] = [
    // Clients need no other process.
    ("mode", "\"router\""),
    // Nobody is found by shouting: endpoints are named.
    ("scouting/multicast/enabled", "false"),
    ("scouting/gossip/enabled", "false"),
    // The default waits half a second at the start.
    ("scouting/delay", "0"),
    ("connect/retry", "{ period_init_ms: 100, period_max_ms: 500, period_increase_factor: 1.5 }"),
    ("connect/timeout_ms", "0"),
    ("connect/exit_on_failure", "false"),
    // The most there is: a large state, or hits, need not wait for their own beginning to be sent.
    ("transport/link/tx/queue/size/data_high", "16"),
    ("transport/link/tx/queue/size/data", "16"),
    // Microseconds. The publisher may wait as long as this for every link that is full, one after another.
    ("transport/link/tx/queue/congestion_control/drop/wait_before_drop", "100"),
    ("transport/link/tx/queue/congestion_control/drop/max_wait_before_drop_fragments", "0"),
    // Nothing a client has to say to a server is longer.
    ("transport/link/rx/max_message_size", "1048576"),
    ("timestamping/enabled", "false"),
];

/// Opens the session and says where it listens.
pub fn open(options: &NetworkOptions) -> Result<(Session, Vec<String>), NetworkError> {
    let mut config = match &options.config {
        Some(file) => Config::from_file(file)
            .map_err(|e| NetworkError::Config { what: file.display().to_string(), why: e.to_string() })?,
        None => Config::default(),
    };
    if options.config.is_none() {
        for (key, value) in SETTINGS {
            set(&mut config, key, value)?;
        }
        set(&mut config, "transport/unicast/max_sessions", &MAX_SESSIONS.to_string())?;
    }
    if !options.connect.is_empty() {
        set(&mut config, "connect/endpoints", &list(&options.connect))?;
    }
    for setting in &options.settings {
        set(&mut config, &setting.key, &setting.value)?;
    }
    let session = match (&options.listen, &options.config) {
        (listen, _) if !listen.is_empty() => {
            set(&mut config, "listen/endpoints", &list(listen))?;
            zenoh::open(config).wait().map_err(|error| {
                let is_taken = error.to_string().contains("Address already in use");
                if is_taken { NetworkError::Taken(listen.join(", ")) } else { error.into() }
            })?
        }
        (_, Some(_)) => zenoh::open(config).wait()?,
        (_, None) => open_at_free_port(config)?,
    };
    // The true ports, also where port 0 was asked for.
    let endpoints: Vec<String> = session.info().locators().wait().iter().map(ToString::to_string).collect();
    if let Some(open) = endpoints.iter().find(|endpoint| !is_loopback(endpoint)) {
        tracing::warn!(
            "{open} is open to other machines: anyone there may steer, unless the configuration forbids it"
        );
    }
    Ok((session, endpoints))
}

fn is_loopback(endpoint: &str) -> bool {
    let address = endpoint.split_once('/').map_or(endpoint, |(_, address)| address);
    endpoint.starts_with("unixsock")
        || ["127.", "[::1]", "localhost"].iter().any(|host| address.starts_with(host))
}

/// Steps around ports that others hold, a router of another program for instance.
fn open_at_free_port(mut config: Config) -> Result<Session, NetworkError> {
    let ports = FIRST_PORT..=FIRST_PORT + MORE_PORTS;
    for port in ports.clone() {
        if TcpListener::bind((Ipv4Addr::LOCALHOST, port)).is_err() {
            tracing::debug!("port {port} is taken");
            continue;
        }
        set(&mut config, "listen/endpoints", &list(&[format!("tcp/127.0.0.1:{port}")]))?;
        match zenoh::open(config.clone()).wait() {
            Ok(session) => {
                if port != FIRST_PORT {
                    tracing::warn!(
                        "port {FIRST_PORT} is taken, listening on {port}: clients need -e tcp/127.0.0.1:{port}"
                    );
                }
                return Ok(session);
            }
            // Somebody may have taken the port in between.
            Err(e) => tracing::debug!("cannot listen on port {port}: {e}"),
        }
    }
    Err(NetworkError::NoPort { first: *ports.start(), last: *ports.end() })
}

fn set(config: &mut Config, key: &str, value: &str) -> Result<(), NetworkError> {
    config
        .insert_json5(key, value)
        .map_err(|e| NetworkError::Config { what: format!("{key} = {value}"), why: e.to_string() })
}

fn list(endpoints: &[String]) -> String {
    serde_json::to_string(endpoints).expect("a list of texts")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_setting_is_one_zenoh_knows() {
        let mut config = Config::default();
        for (key, value) in SETTINGS {
            set(&mut config, key, value).unwrap();
        }
    }

    #[test]
    fn only_this_machine_counts_as_loopback() {
        assert!(is_loopback("tcp/127.0.0.1:7447") && is_loopback("tcp/[::1]:7447"));
        assert!(!is_loopback("tcp/0.0.0.0:7447") && !is_loopback("tls/192.168.1.2:7447"));
    }
}
