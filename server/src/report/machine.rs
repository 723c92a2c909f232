//! What a report was measured on.

use serde::Serialize;
use std::fs::read_to_string;

/// The machine and the program, as far as the system tells.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// The processor's name for itself.
    pub processor: String,
    /// Threads that may run at once.
    pub threads: usize,
    /// System and its version.
    pub system: String,
    /// Other work on the machine when the report was begun: the load average of one minute, where there is one.
    pub load: Option<f64>,
    /// Version of the program.
    pub version: String,
    /// Target and how it was compiled.
    pub build: String,
}

impl Machine {
    /// This one, now.
    pub fn here() -> Self {
        let field = |file: &str, name: &str| {
            let text = read_to_string(file).unwrap_or_default();
            let line = text.lines().find(|line| line.starts_with(name))?;
            line.split_once([':', '=']).map(|(_, value)| value.trim().trim_matches('"').to_owned())
        };
        let kernel = read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default();
        let system =
            field("/etc/os-release", "PRETTY_NAME").unwrap_or_else(|| std::env::consts::OS.to_owned());
        let load = read_to_string("/proc/loadavg").unwrap_or_default();
        Self {
            processor: field("/proc/cpuinfo", "model name")
                .unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            threads: std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            system: [system.as_str(), kernel.trim()].join(" ").trim().to_owned(),
            load: load.split_whitespace().next().and_then(|first| first.parse().ok()),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            build: format!(
                "{} {}, Rust {} or newer, {}",
                std::env::consts::ARCH,
                std::env::consts::OS,
                env!("CARGO_PKG_RUST_VERSION"),
                if cfg!(debug_assertions) { "not optimised: costs mean nothing" } else { "optimised" }
            ),
        }
    }
}
