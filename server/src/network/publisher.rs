//! States, hits and statistics going out. Zenoh serves every link in the calling thread, so this one is its own.

use super::outlet::Outlet;
use super::{Latest, NetworkError};
use crate::handover::{Batch, Handover};
use crate::players::Players;
use crate::simulation::{NumberedHit, Stage};
use protocol::codec;
use protocol::event::Events;
use protocol::keys::Keys;
use protocol::snapshot::Snapshot;
use protocol::stats::Streams;
use std::sync::Arc;
use std::time::{Duration, Instant};
use zenoh::bytes::Encoding;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::{Session, Wait};

/// Longest wait for something to publish.
const IDLE: Duration = Duration::from_millis(500);
/// Silence after which the last state is said once more: a link that was busy may have missed it.
const SILENCE: Duration = Duration::from_millis(100);

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
    /// Whether the last state went out once only.
    said_once: bool,
    /// When the last state went out.
    put_at: Instant,
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
        // Not express: that would give up batching.
        let declare = |key: String, priority, congestion, encoding: Encoding| {
            let publisher = session.declare_publisher(key).priority(priority).encoding(encoding);
            publisher.congestion_control(congestion).wait().map(Outlet::new)
        };
        let json = || Encoding::APPLICATION_JSON;
        Ok(Self {
            // Each link takes one state at a time, whole, on a thread of its own; a link that is not done with it misses the
            // next. With `Drop` every link that is full holds up this thread, and gets the beginnings of states.
            state: declare(
                keys.state(),
                Priority::DataHigh,
                CongestionControl::BlockFirst,
                Encoding::APPLICATION_CBOR,
            )?,
            event: declare(keys.event(), Priority::Data, CongestionControl::Drop, json())?,
            stats: declare(keys.stats(), Priority::DataLow, CongestionControl::Drop, json())?,
            scene: declare(keys.meta_scene(), Priority::DataLow, CongestionControl::Drop, json())?,
            latest,
            handover,
            players,
            batch: Batch::default(),
            stages: Vec::new(),
            epoch: None,
            said_once: false,
            put_at: Instant::now(),
            published: 0,
            counted_from: Instant::now(),
            frame_bytes: 0,
        })
    }

    /// Publishes until the tick loop has ended.
    pub fn run(&mut self) {
        while !self.batch.ended {
            self.handover.take(&mut self.batch, if self.said_once { SILENCE } else { IDLE });
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
        let Some(state) = self.batch.state.take() else { return self.repeat_state() };
        let frame = self.state.is_wanted().then(|| self.frame_of(&state));
        let is_new_epoch = self.epoch.replace(state.epoch) != Some(state.epoch);
        let stage = self.begin_stages(state.epoch);
        let wall_ns = state.wall_ns;
        // Before anybody hears of it: who sees a new epoch asks for its world.
        self.latest.replace(stage, state);
        self.said_once = frame.is_some();
        if let Some(frame) = frame {
            self.state.put_as_of(wall_ns, frame);
            self.published += 1;
            self.put_at = Instant::now();
        }
        if is_new_epoch && self.scene.is_wanted() {
            self.scene.put(codec::encode_json(&*self.latest.stage().scene));
        }
    }

    fn frame_of(&mut self, state: &Snapshot) -> Vec<u8> {
        let mut frame = Vec::with_capacity(self.frame_bytes);
        codec::encode_state(state, &mut frame);
        self.frame_bytes = frame.len();
        frame
    }

    /// Says the last state once more when no other has followed it. Readers who have it know it by its stamp.
    fn repeat_state(&mut self) {
        if self.said_once && self.put_at.elapsed() >= SILENCE {
            self.said_once = false;
            let (_, kept) = self.latest.now();
            let frame = self.frame_of(&kept.state);
            self.state.repeat_as_of(kept.state.wall_ns, frame);
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
