//! States, hits and statistics going out. Zenoh serves every link in the calling thread, so this one is its own.

use super::outlet::Outlet;
use super::{Latest, NetworkError};
use crate::handover::{Batch, Handover};
use crate::players::Players;
use crate::simulation::{NumberedHit, Stage};
use protocol::codec;
use protocol::event::Events;
use protocol::keys::Keys;
use protocol::stats::Streams;
use std::sync::Arc;
use std::time::{Duration, Instant};
use zenoh::bytes::Encoding;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::{Session, Wait};

/// Longest wait for something to publish.
const IDLE: Duration = Duration::from_millis(500);

/// The outgoing side of an arena.
pub struct Publisher {
    state: Outlet,
    event: Outlet,
    stats: Outlet,
    scene: Outlet,
    latest: Arc<Latest>,
    handover: Arc<Handover>,
    players: Arc<Players>,
    batch: Batch,
    /// Stages whose first state is still to come.
    stages: Vec<Stage>,
    epoch: Option<u64>,
    published: u64,
    /// When the figures of the streams begin.
    counted_from: Instant,
    /// Length of the last frame, to take room once.
    frame_bytes: usize,
}

impl Publisher {
    /// Declares the four publishers once for all.
    pub fn declare(
        session: &Session,
        keys: &Keys,
        latest: Arc<Latest>,
        handover: Arc<Handover>,
        players: Arc<Players>,
    ) -> Result<Self, NetworkError> {
        // Dropping keeps one slow reader from holding up the others; a state is soon followed by a newer one. Not
        // express: that would give up batching.
        let declare = |key: String, priority, encoding: Encoding| {
            let publisher = session.declare_publisher(key).priority(priority).encoding(encoding);
            publisher.congestion_control(CongestionControl::Drop).wait().map(Outlet::new)
        };
        Ok(Self {
            state: declare(keys.state(), Priority::DataHigh, Encoding::APPLICATION_CBOR)?,
            event: declare(keys.event(), Priority::Data, Encoding::APPLICATION_JSON)?,
            stats: declare(keys.stats(), Priority::DataLow, Encoding::APPLICATION_JSON)?,
            scene: declare(keys.meta_scene(), Priority::DataLow, Encoding::APPLICATION_JSON)?,
            latest,
            handover,
            players,
            batch: Batch::default(),
            stages: Vec::new(),
            epoch: None,
            published: 0,
            counted_from: Instant::now(),
            frame_bytes: 0,
        })
    }

    /// Publishes until the tick loop has ended.
    pub fn run(&mut self) {
        while !self.batch.ended {
            self.handover.take(&mut self.batch, IDLE);
            self.batch.ended_worlds.clear();
            self.stages.append(&mut self.batch.stages);
            self.publish_state();
            // After the state: whoever is told that something is done finds it done.
            for answered in self.batch.answers.drain(..) {
                (answered.answer)(&answered.reply);
            }
            self.publish_hits();
            self.publish_stats();
        }
    }

    fn publish_state(&mut self) {
        let Some(state) = self.batch.state.take() else { return };
        let frame = self.state.is_wanted().then(|| {
            let mut frame = Vec::with_capacity(self.frame_bytes);
            codec::encode_state(&state, &mut frame);
            self.frame_bytes = frame.len();
            frame
        });
        let is_new_epoch = self.epoch.replace(state.epoch) != Some(state.epoch);
        let stage = self.begin_stages(state.epoch);
        let wall_ns = state.wall_ns;
        // Before anybody hears of it: who sees a new epoch asks for its world.
        self.handover.recycle(self.latest.replace(stage, state));
        if let Some(frame) = frame {
            self.state.put_as_of(wall_ns, frame);
            self.published += 1;
        }
        if is_new_epoch && self.scene.is_wanted() {
            self.scene.put(codec::encode_json(&*self.latest.stage().scene));
        }
    }

    /// The last stage that has begun by `epoch`, if one has. Hits from before go out with the names they had.
    fn begin_stages(&mut self, epoch: u64) -> Option<Stage> {
        let mut last = None;
        while self.stages.first().is_some_and(|stage| stage.epoch <= epoch) {
            let stage = self.stages.remove(0);
            let later = self.batch.hits.partition_point(|hit| hit.epoch < stage.epoch);
            let before: Vec<_> = self.batch.hits.drain(..later).collect();
            self.publish(&before, last.as_ref().unwrap_or(&self.latest.stage()));
            last = Some(stage);
        }
        last
    }

    fn publish_hits(&mut self) {
        if !self.batch.hits.is_empty() {
            self.publish(&self.batch.hits, &self.latest.stage());
            self.batch.hits.clear();
        }
    }

    fn publish(&self, hits: &[NumberedHit], stage: &Stage) {
        self.players.count_hits(hits, &stage.roster);
        if self.event.is_wanted() {
            for hits in hits.chunks(codec::MAX_EVENTS) {
                let events = hits.iter().map(|hit| hit.to_event(&stage.roster)).collect();
                self.event.put(codec::encode_json(&Events { events, dropped: self.batch.hits_dropped }));
            }
        }
    }

    fn publish_stats(&mut self) {
        let Some(mut stats) = self.batch.stats.take() else { return };
        stats.states_published = self.published;
        stats.states_skipped = self.handover.skipped();
        let held = stats.fallbacks.saturating_sub(self.latest.stats().fallbacks);
        if held > 0 {
            tracing::warn!("a ball was held for a moment {held} times, for its hits piled up");
        }
        let over = std::mem::replace(&mut self.counted_from, Instant::now()).elapsed();
        stats.streams = Streams {
            state: self.state.figures(over),
            event: self.event.figures(over),
            stats: self.stats.figures(over),
            scene: self.scene.figures(over),
        };
        if stats.streams.stats.is_read {
            self.stats.put(codec::encode_json(&stats));
        }
        self.latest.set_stats(stats);
    }
}
