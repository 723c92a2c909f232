//! A session with a Ballroom server: blocking calls over Zenoh, for tools, the viewer bridge and tests.
//!
//! | file | what |
//! |---|---|
//! | `options` | where the server is, how long to wait for it, when to stop waiting |
//! | `client` | commands, questions, presses |
//! | `verbs` | each command as a method |
//! | `feed` | what the server publishes, newest first, never blocking the session |
//! | `meter` | how the states come, told to the server once a second |
//! | `follow` | the world and then its states, through late joins, resets and restarts of the server |
//! | `driver` | a claimed ball: commands go out again and again until they are acknowledged |
//! | `renewal` | how often a held force is renewed |
//! | `window` | what a player has sent and what came of it |
//!
//! No runtime is needed. The client must not be used inside a single-threaded tokio runtime.

mod client;
mod driver;
mod feed;
mod follow;
mod meter;
mod options;
mod renewal;
mod verbs;
mod window;

pub use client::{Client, ClientError};
pub use driver::{DriveFault, Driver};
pub use feed::{Feed, Presence, Presences};
pub use follow::{Follower, Update};
pub use options::{Abort, ClientOptions, DEFAULT_ENDPOINT, Patience, Setting};
pub use renewal::renew_every;
pub use window::Wanted;
pub use zenoh::liveliness::LivelinessToken;
