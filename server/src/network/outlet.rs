//! One stream going out: numbered, stamped and counted.

use protocol::report::Stamp;
use protocol::stats::Stream;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime};
use zenoh::Wait;
use zenoh::pubsub::Publisher;

/// A key that is published, and what went out since it was last asked.
pub struct Outlet {
    publisher: Publisher<'static>,
    sequence: AtomicU64,
    counted_to: u64,
    bytes: AtomicU64,
}

impl Outlet {
    /// Nothing has gone out yet.
    pub const fn new(publisher: Publisher<'static>) -> Self {
        Self { publisher, sequence: AtomicU64::new(0), counted_to: 0, bytes: AtomicU64::new(0) }
    }

    /// Whether anybody listens; encoding for nobody is what there is to save.
    pub fn is_wanted(&self) -> bool {
        self.publisher.matching_status().wait().is_ok_and(|status| status.matching())
    }

    /// Publishes what is so now.
    pub fn put(&self, bytes: Vec<u8>) {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        self.put_as_of(now.as_nanos() as u64, bytes);
    }

    /// Publishes what was so at a wall time.
    pub fn put_as_of(&self, wall_ns: u64, bytes: Vec<u8>) {
        self.send(Stamp { sequence: self.sequence.fetch_add(1, Ordering::Relaxed), wall_ns }, bytes);
    }

    /// Publishes the last message once more, under its number.
    pub fn repeat_as_of(&self, wall_ns: u64, bytes: Vec<u8>) {
        self.send(
            Stamp { sequence: self.sequence.load(Ordering::Relaxed).saturating_sub(1), wall_ns },
            bytes,
        );
    }

    fn send(&self, stamp: Stamp, bytes: Vec<u8>) {
        self.bytes.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        if let Err(e) = self.publisher.put(bytes).attachment(stamp.to_bytes()).wait() {
            tracing::debug!("{} could not be published: {e}", self.publisher.key_expr());
        }
    }

    /// What went out over a time, which begins anew.
    pub fn figures(&mut self, over: Duration) -> Stream {
        let sequence = *self.sequence.get_mut();
        let messages = sequence - std::mem::replace(&mut self.counted_to, sequence);
        let bytes = std::mem::take(self.bytes.get_mut());
        let per_s = |count: u64| count as f64 / over.as_secs_f64().max(1e-3);
        Stream { messages_per_s: per_s(messages), bytes_per_s: per_s(bytes), is_read: self.is_wanted() }
    }
}
