//! A thread that owns one Rerun stream and draws what its slot holds.
//!
//! Live and file have a thread each: a viewer that is slow holds its own thread up, and never the file.

use crate::recording::Recording;
use crate::slot::Slot;
use crate::view::View;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// How long the end of a stream is waited for; a viewer that hangs must not hold up a shutdown.
const FLUSH_PATIENCE: Duration = Duration::from_secs(2);
/// Failures that are told one by one; later ones are only counted.
const TOLD_FAILURES: u64 = 3;
/// Frames may come this part of a period early, so that a server at the same rate loses none to jitter.
const EARLY: f64 = 0.25;

/// A running logging thread.
pub struct Logger {
    name: &'static str,
    slot: Arc<Slot>,
    done: Receiver<()>,
}

impl Logger {
    /// Starts to draw into `recording`, at about `frames_per_second` at most.
    pub fn start(name: &'static str, recording: Recording, frames_per_second: u32) -> std::io::Result<Self> {
        let slot = Arc::<Slot>::default();
        let (finished, done) = channel();
        let period = Duration::from_secs(1) / frames_per_second.max(1);
        let inlet = slot.clone();
        std::thread::Builder::new().name(format!("rerun-{name}")).spawn(move || {
            let stream = recording.stream().clone();
            draw(recording, &slot, period.mul_f64(1.0 - EARLY), name);
            if let Err(fault) = stream.flush_with_timeout(FLUSH_PATIENCE) {
                tracing::error!("the {name} recording is incomplete: {fault}");
            }
            // Dropping the stream flushes without any bound; whoever stops this thread does not wait for ever.
            drop(stream);
            finished.send(()).ok();
        })?;
        Ok(Self { name, slot: inlet, done })
    }

    /// Where its news go.
    pub fn slot(&self) -> Arc<Slot> {
        self.slot.clone()
    }

    /// Ends the stream after what waits in the slot, and waits for that for two seconds at most. Returns whether
    /// everything was written.
    pub fn stop(self) -> bool {
        self.slot.close();
        let written = self.done.recv_timeout(FLUSH_PATIENCE).is_ok();
        if !written {
            tracing::warn!(
                "the {} recording did not end within {FLUSH_PATIENCE:?} and is left as it is",
                self.name
            );
        }
        let counts = self.slot.counts();
        tracing::info!(
            "{}: {} states received, {} shown, {} dropped; {} hits dropped",
            self.name,
            counts.received,
            counts.shown,
            counts.dropped,
            counts.hits_dropped
        );
        written
    }
}

/// Draws until the slot is closed and empty. A row that fails is lost, the next may not be.
fn draw(recording: Recording, slot: &Slot, period: Duration, name: &str) {
    let mut view = View::new(recording);
    let mut failures: u64 = 0;
    while let Some(news) = slot.take(Duration::from_secs(1)) {
        let began = Instant::now();
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
}
