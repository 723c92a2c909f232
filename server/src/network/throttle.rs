//! Back-pressure: whoever is refused is read more slowly.
//!
//! A refusal is cheap, a flood of them is not: reading it takes the core that ticks and states are waited for on. A link that
//! rests after each message that was refused fills up at its sender, where a flood costs nobody else anything. All that comes
//! over one link waits, so a router between clients and server is one sender.

use std::time::Duration;

/// Most messages of one link that are refused in a second.
pub const REFUSED_PER_S: f64 = 100.0;

/// To be called where Zenoh hands over what came on a link, on the thread that reads it. The other links that this thread
/// would read are handed to another.
pub fn hold_up() {
    tokio::task::block_in_place(|| std::thread::sleep(Duration::from_secs_f64(1.0 / REFUSED_PER_S)));
}
