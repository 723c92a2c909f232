//! Where the server is, how long to wait for it, and when to stop waiting.

use crate::client::ClientError;
use protocol::keys::{DEFAULT_ARENA, Name, Role};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Where a server listens unless told otherwise.
pub const DEFAULT_ENDPOINT: &str = "tcp/127.0.0.1:7447";

/// How to reach a server.
#[derive(Clone, Debug)]
pub struct ClientOptions {
    /// Endpoints to connect to; with none, those of `config`, or [`DEFAULT_ENDPOINT`].
    pub endpoints: Vec<String>,
    /// A Zenoh configuration file (JSON5 or YAML); it is taken as it stands, but for the endpoints above.
    pub config: Option<PathBuf>,
    /// Single settings of Zenoh, applied last.
    pub settings: Vec<Setting>,
    /// Which arena.
    pub arena: Name,
    /// How long to wait for a server.
    pub patience: Patience,
    /// How long to wait for one answer.
    pub timeout: Duration,
    /// Ends waiting and following from another thread.
    pub abort: Abort,
    /// As what it tells the server how it reads.
    pub role: Role,
    /// Under which name; the session's own number when absent.
    pub id: Option<Name>,
}

impl Default for ClientOptions {
    /// As for a tool on the server's machine.
    fn default() -> Self {
        Self {
            endpoints: Vec::new(),
            config: None,
            settings: Vec::new(),
            arena: DEFAULT_ARENA.parse().expect("a valid name"),
            patience: Patience::default(),
            timeout: Duration::from_secs(5),
            abort: Abort::default(),
            role: Role::default(),
            id: None,
        }
    }
}

/// A setting of Zenoh as its own tools take it: `KEY:VALUE`, the value in JSON5.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Path in Zenoh's configuration, for instance `transport/link/tx/lease`.
    pub key: String,
    /// Its value in JSON5.
    pub value: String,
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            Some((key, value)) if !key.is_empty() && !value.is_empty() => {
                Ok(Self { key: key.to_owned(), value: value.to_owned() })
            }
            _ => Err("write KEY:VALUE, for instance transport/link/tx/lease:5000".into()),
        }
    }
}

/// How long to wait for a server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Patience {
    /// As a tool does.
    GiveUpAfter(Duration),
    /// As a daemon does, until aborted.
    WaitForServer,
}

impl Default for Patience {
    fn default() -> Self {
        Self::GiveUpAfter(Duration::from_secs(3))
    }
}

/// A switch that ends waiting, shared by its clones.
#[derive(Clone, Debug, Default)]
pub struct Abort(Arc<AtomicBool>);

impl Abort {
    /// Throws the switch, for ever.
    pub fn abort(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it has been thrown.
    pub fn is_aborted(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

impl ClientOptions {
    /// The endpoints in words, for messages.
    pub(crate) fn whereabouts(&self) -> String {
        match (self.endpoints.as_slice(), &self.config) {
            ([], Some(file)) => format!("the endpoints of {}", file.display()),
            ([], None) => DEFAULT_ENDPOINT.to_owned(),
            (endpoints, _) => endpoints.join(", "),
        }
    }

    /// Zenoh's configuration of a client: it speaks with the named endpoints and looks for no others.
    pub(crate) fn zenoh_config(&self) -> Result<zenoh::Config, ClientError> {
        let mut config = match &self.config {
            Some(file) => zenoh::Config::from_file(file)
                .map_err(|e| ClientError::Config { what: file.display().to_string(), why: e.to_string() })?,
            None => zenoh::Config::default(),
        };
        let mut set = |key: &str, value: &str| {
            config
                .insert_json5(key, value)
                .map_err(|e| ClientError::Config { what: format!("{key} = {value}"), why: e.to_string() })
        };
        if self.config.is_none() {
            set("mode", "\"client\"")?;
            set("scouting/multicast/enabled", "false")?;
            set("scouting/gossip/enabled", "false")?;
            set("listen/endpoints", "[]")?;
            // After a restart of the server the first state is there within this period.
            set("connect/retry", "{ period_init_ms: 100, period_max_ms: 500, period_increase_factor: 1.5 }")?;
            // A frozen client is missed after its own lease.
            set("transport/link/tx/lease", "2000")?;
        }
        let default = [DEFAULT_ENDPOINT.to_owned()];
        let endpoints = match (self.endpoints.as_slice(), &self.config) {
            ([], Some(_)) => None,
            ([], None) => Some(default.as_slice()),
            (endpoints, _) => Some(endpoints),
        };
        if let Some(endpoints) = endpoints {
            set("connect/endpoints", &serde_json::to_string(endpoints).expect("a list of texts"))?;
        }
        for setting in &self.settings {
            set(&setting.key, &setting.value)?;
        }
        Ok(config)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Client;
    use std::time::Instant;

    #[test]
    fn a_tool_without_a_server_gives_up_in_time_and_says_where_it_looked() {
        // Nothing listens on port 1.
        let options = ClientOptions {
            endpoints: vec!["tcp/127.0.0.1:1".into()],
            patience: Patience::GiveUpAfter(Duration::from_millis(300)),
            ..ClientOptions::default()
        };
        let began = Instant::now();
        let error = Client::open(options).err().unwrap();
        assert!(error.is_no_server() && error.to_string().contains("tcp/127.0.0.1:1 "), "{error}");
        assert!(began.elapsed() < Duration::from_secs(3));
    }

    #[test]
    fn a_waiting_daemon_can_be_aborted() {
        let abort = Abort::default();
        let options = ClientOptions {
            endpoints: vec!["tcp/127.0.0.1:1".into()],
            patience: Patience::WaitForServer,
            abort: abort.clone(),
            ..ClientOptions::default()
        };
        let waiting = std::thread::spawn(move || Client::open(options).err().unwrap());
        std::thread::sleep(Duration::from_millis(200));
        abort.abort();
        assert!(matches!(waiting.join().unwrap(), ClientError::Aborted));
    }

    #[test]
    fn a_setting_is_applied_and_an_unknown_one_is_named() {
        let with =
            |text: &str| ClientOptions { settings: vec![text.parse().unwrap()], ..ClientOptions::default() };
        let config = with("transport/link/tx/lease:4321").zenoh_config().unwrap();
        assert_eq!(config.get_json("transport/link/tx/lease").unwrap(), "4321");
        let error = with("no/such/key:1").zenoh_config().unwrap_err().to_string();
        assert!(error.contains("no/such/key"), "{error}");
        assert!("lease".parse::<Setting>().is_err());
    }

    #[test]
    fn a_missing_configuration_file_is_named() {
        let options = ClientOptions { config: Some("no/such.json5".into()), ..ClientOptions::default() };
        assert!(options.zenoh_config().unwrap_err().to_string().contains("no/such.json5"));
    }
}
