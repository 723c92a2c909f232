//! What the tests of the whole system stand on: programs as processes, a server with an address, recordings read back.
//!
//! | file | what |
//! |---|---|
//! | `process` | a program of this workspace, running; it cannot outlive its test |
//! | `screen` | a real viewer without a window, and its pictures |
//! | `camera` | what a bridge sends to whoever watches |
//! | `server` | `ballroom serve` on a free port, and its twin without a network |
//! | `ride` | a Rerun recording, read back |
//! | `crowd` | ten clients that misbehave, each a process |
//! | `noise` | bytes without meaning |
//! | `wait` | waiting with a bound, and taking turns |
//!
//! Every wait has a bound and says what it waited for. Signals make this Unix only.

#[path = "harness/camera.rs"]
mod camera;
#[path = "harness/crowd.rs"]
mod crowd;
#[path = "harness/noise.rs"]
mod noise;
#[path = "harness/process.rs"]
mod process;
#[path = "harness/ride.rs"]
mod ride;
#[path = "harness/screen.rs"]
mod screen;
#[path = "harness/server.rs"]
mod server;
#[path = "harness/wait.rs"]
mod wait;

pub use camera::{Camera, newest_tick_at};
pub use crowd::{Crowd, Kind};
pub use noise::Noise;
pub use process::{Output, Process, come_first, run};
pub use ride::{Ride, Row};
pub use screen::{Picture, Screen};
pub use server::{BallState, Server, State, connect, simulate};
pub use wait::{PATIENCE, in_one_of_three_tries, turn, until};
