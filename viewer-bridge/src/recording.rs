//! One Rerun stream and where it stands in time.

use protocol::snapshot::Snapshot;
use rerun::AsComponents;
use rerun::external::re_log_types::BlueprintActivationCommand;
use rerun::log::LogMsg;
use rerun::sink::LogSink;
use rerun::{EntityPath, RecordingStream, RecordingStreamResult};

/// Ticks since the epoch began; starts over with an epoch.
pub const TICK: &str = "tick";
/// Simulated time since the epoch began; starts over with an epoch.
pub const SIM_TIME: &str = "sim_time";
/// The server's clock; never goes back, so it is the one to follow live.
pub const WALL_TIME: &str = "wall_time";

/// A point on the three timelines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// On [`TICK`].
    pub tick: u64,
    /// On [`SIM_TIME`], s.
    pub time_s: f64,
    /// On [`WALL_TIME`], ns since 1970.
    pub wall_ns: u64,
}

impl From<&Snapshot> for Moment {
    fn from(state: &Snapshot) -> Self {
        Self { tick: state.tick, time_s: state.time_s, wall_ns: state.wall_ns }
    }
}

/// A Rerun stream that is logged to from one thread only: Rerun keeps the time per thread.
pub struct Recording {
    stream: RecordingStream,
    /// Where the stream will go once there is a layout.
    waiting: Option<Box<dyn LogSink>>,
}

impl Recording {
    /// Takes a stream over. Its automatic timelines are switched off: they would say when a row was logged, which
    /// is neither the server's time nor repeatable.
    pub fn new(stream: RecordingStream) -> Self {
        stream.set_log_time_enabled(false);
        Self { stream, waiting: None }
    }

    /// Takes a buffered stream over that goes into `sink` as soon as there is a layout.
    ///
    /// A viewer that hears of a recording before its default layout makes up one of its own, and keeps that.
    pub fn into_sink(stream: RecordingStream, sink: Box<dyn LogSink>) -> Self {
        Self { waiting: Some(sink), ..Self::new(stream) }
    }

    /// Sends a layout; the first comes before everything else.
    pub fn send_layout(&mut self, messages: Vec<LogMsg>, activation: BlueprintActivationCommand) {
        let Some(sink) = self.waiting.take() else {
            self.stream.send_blueprint(messages, activation);
            return;
        };
        for message in messages {
            sink.send(message);
        }
        sink.send(activation.into());
        self.stream.set_sink(sink);
    }

    /// The stream itself, for what concerns the whole of it.
    pub const fn stream(&self) -> &RecordingStream {
        &self.stream
    }

    /// What is logged from here on belongs to this moment.
    pub fn at(&self, moment: Moment) {
        self.stream.set_time_sequence(TICK, i64::try_from(moment.tick).unwrap_or(i64::MAX));
        self.stream.set_duration_secs(SIM_TIME, moment.time_s);
        self.stream
            .set_timestamp_nanos_since_epoch(WALL_TIME, i64::try_from(moment.wall_ns).unwrap_or(i64::MAX));
    }

    /// Logs at the current moment.
    pub fn log(&self, path: impl Into<EntityPath>, what: &impl AsComponents) -> RecordingStreamResult<()> {
        self.stream.log(path, what)
    }

    /// Logs for all time. Servers keep every static row for late viewers, so this is for what changes with a scene.
    pub fn log_static(
        &self,
        path: impl Into<EntityPath>,
        what: &impl AsComponents,
    ) -> RecordingStreamResult<()> {
        self.stream.log_static(path, what)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blueprint;
    use crate::named_view::{NamedView, Sights};
    use crate::scene_view::Extent;
    use rerun::RecordingStreamBuilder;
    use rerun::sink::CallbackSink;
    use std::sync::{Arc, Mutex};

    #[test]
    fn a_viewer_hears_of_the_layout_before_the_recording() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let ears = heard.clone();
        let sink =
            CallbackSink::new(move |messages: &[LogMsg]| ears.lock().unwrap().extend_from_slice(messages));
        let stream = RecordingStreamBuilder::new("ballroom_test").buffered().unwrap();
        let mut recording = Recording::into_sink(stream, Box::new(sink));
        recording.log("early", &rerun::TextLog::new("before the layout")).unwrap();
        assert!(heard.lock().unwrap().is_empty());

        let room = Extent { lowest: [0.0; 3], highest: [1.0; 3] };
        let sights = Sights { room, net: room, followed: None };
        blueprint::send(&mut recording, &sights, &NamedView::default(), false).unwrap();
        recording.stream().flush_blocking().unwrap();
        let heard = heard.lock().unwrap();
        let first = heard.iter().position(|message| message.store_id().is_recording()).unwrap();
        let (layout, data) = heard.split_at(first);
        assert!(matches!(layout.last(), Some(LogMsg::BlueprintActivationCommand(_))));
        assert!(matches!(data.first(), Some(LogMsg::SetStoreInfo(_))) && data.len() > 1);
        assert!(data.iter().all(|message| message.store_id().is_recording()));
    }
}
