//! A thread that owns one Rerun stream and draws what its slot holds.
//!
//! Live and file have a thread each: a viewer that is slow holds its own thread up, and never the file.

use crate::hub::Hub;
use crate::slot::Slot;
use crate::view::View;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// How long the end of a stream is waited for; a viewer that hangs must not hold up a shutdown.
const FLUSH_PATIENCE: Duration = Duration::from_secs(2);
/// The same for drawing what waits in the slot, which is one frame, and for closing the stream.
const DRAW_PATIENCE: Duration = Duration::from_secs(1);
/// Failures that are told one by one; later ones are only counted.
const TOLD_FAILURES: u64 = 3;
/// Frames may come this part of a period early, so that a server at the same rate loses none to jitter.
const EARLY: f64 = 0.25;

/// A running logging thread.
pub struct Logger {
    name: &'static str,
    slot: Arc<Slot>,
    hub: Option<Arc<Hub>>,
    /// Says once whether everything was written, and hangs up when the stream is closed.
    done: Receiver<bool>,
}

impl Logger {
    /// Starts to draw a view, at about `frames_per_second` at most. What viewers at the `hub` miss is counted too.
    pub fn start(
        name: &'static str,
        view: View,
        frames_per_second: u32,
        hub: Option<Arc<Hub>>,
    ) -> std::io::Result<Self> {
        let slot = Arc::<Slot>::default();
        let (finished, done) = channel();
        let period = Duration::from_secs(1) / frames_per_second.max(1);
        let (inlet, watched) = (slot.clone(), hub.clone());
        std::thread::Builder::new().name(format!("rerun-{name}")).spawn(move || {
            let stream = view.recording().stream().clone();
            let drawn = draw(view, &slot, period.mul_f64(1.0 - EARLY), name, watched.as_deref());
            let flushed = stream.flush_with_timeout(FLUSH_PATIENCE);
            if let Err(fault) = &flushed {
                tracing::error!("the {name} recording is incomplete: {fault}");
            }
            // Before the stream is dropped, which completes a file, and flushes without any bound.
            finished.send(drawn && flushed.is_ok()).ok();
            drop(stream);
            drop(finished);
        })?;
        Ok(Self { name, slot: inlet, hub, done })
    }

    /// Where its news go.
    pub fn slot(&self) -> Arc<Slot> {
        self.slot.clone()
    }

    /// Ends the stream after what waits in the slot, and waits for that for four seconds at most. Returns whether
    /// everything was written.
    pub fn stop(self) -> bool {
        self.slot.close();
        let written = self.done.recv_timeout(DRAW_PATIENCE + FLUSH_PATIENCE);
        let closed =
            written.is_ok() && self.done.recv_timeout(DRAW_PATIENCE) != Err(RecvTimeoutError::Timeout);
        if !closed {
            tracing::warn!("the {} recording did not end in time and is left as it is", self.name);
        }
        let counts = self.slot.counts();
        tracing::info!(
            "{}: {} states received, {} shown, {} dropped, {} missed; {} hits dropped",
            self.name,
            counts.received,
            counts.shown,
            counts.dropped,
            counts.missed,
            counts.hits_dropped
        );
        if let Some(sent) = self.hub.map(|hub| hub.sent()) {
            tracing::info!(
                "viewers: {} messages sent, {} missed by viewers that were too slow, {} reconnects",
                sent.taken,
                sent.dropped,
                sent.reconnects
            );
        }
        closed && written.unwrap_or(false)
    }
}

/// Draws until the slot is closed and empty. A row that fails is lost, the next may not be. Returns whether none was.
fn draw(mut view: View, slot: &Slot, period: Duration, name: &str, hub: Option<&Hub>) -> bool {
    let mut failures: u64 = 0;
    while let Some(mut news) = slot.take(Duration::from_secs(1)) {
        let began = Instant::now();
        news.counts.rows_missed = hub.map_or(0, |hub| hub.sent().dropped);
        if let Err(fault) = view.show(&news) {
            failures += 1;
            if failures <= TOLD_FAILURES {
                tracing::warn!("a frame of the {name} recording is incomplete: {fault}");
            }
        }
        std::thread::sleep(period.saturating_sub(began.elapsed()));
    }
    if failures > TOLD_FAILURES {
        tracing::warn!("{failures} frames of the {name} recording are incomplete");
    }
    failures == 0
}
