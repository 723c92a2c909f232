//! The whole system: real sessions, real processes, no display. Each test's name is what it claims.

#[path = "system/commands.rs"]
mod commands;
#[path = "system/error_estimate.rs"]
mod error_estimate;
#[path = "system/hostile.rs"]
mod hostile;
#[path = "system/isolation.rs"]
mod isolation;
#[path = "system/processes.rs"]
mod processes;
#[path = "system/recordings.rs"]
mod recordings;
#[path = "system/replays.rs"]
mod replays;
#[path = "system/states.rs"]
mod states;
#[path = "system/viewers.rs"]
mod viewers;
