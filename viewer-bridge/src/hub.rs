//! What viewers are sent: one bounded ring of messages that all of them read, each at its own pace.
//!
//! A viewer is two places in the ring, so that neither its number nor its slowness costs memory. It gets, in this
//! order: what stands for all time (layout, scene, meshes), what happens from now on, and, while that leaves room,
//! what went before, the newest first. One that falls behind is taken to the present, and what it missed is counted.
//! Of what stands only the newest is kept, so that a floor edited a thousand times is held once.

use rerun::external::re_log_encoding::ToTransport;
use rerun::external::re_log_encoding::rrd::Compression;
use rerun::log::{Chunk, LogMsg};
use rerun::sink::{LogSink, SinkFlushError};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::Notify;

pub use re_protos::log_msg::v1alpha1::LogMsg as Message;

/// Bytes of the past that are kept; the oldest goes first. All that stands comes on top, once.
pub const HISTORY_BYTES: usize = 256 << 20;
/// A viewer that is further behind than this is taken to the present.
pub const MOST_BEHIND: Duration = Duration::from_secs(2);
/// How long the end waits for viewers to get the last of it.
const FLUSH_PATIENCE: Duration = Duration::from_millis(250);
/// What a message takes beside its payload, about.
const OVERHEAD_BYTES: usize = 512;

/// Counts since a hub was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sent {
    /// Viewers that are there.
    pub viewers: usize,
    /// Messages that viewers took.
    pub taken: u64,
    /// Messages that a viewer never got, for it was too slow.
    pub dropped: u64,
    /// Times that a viewer elsewhere was lost and looked for again.
    pub reconnects: u64,
}

/// One writer, any number of viewers.
pub struct Hub {
    inside: Mutex<Inside>,
    changed: Notify,
    history_bytes: usize,
}

#[derive(Default)]
struct Inside {
    /// The newest layout, complete with what makes it one.
    layout: Vec<Numbered>,
    /// Who the recording is.
    store: Option<Numbered>,
    /// The newest of what is logged for all time, by entity and components.
    statics: BTreeMap<String, Numbered>,
    ring: VecDeque<Entry>,
    /// Number of the ring's first entry.
    first: u64,
    bytes: usize,
    sent: Sent,
    closed: bool,
}

/// A message that stands, with its number in the ring.
struct Numbered(u64, Message);

struct Entry {
    message: Message,
    bytes: usize,
    /// Whether it is among what stands too, which a viewer that joins later gets from there.
    stands: bool,
    came: Instant,
}

/// What a message is to those who join later.
enum Kind {
    LayoutBegins,
    Layout,
    Store,
    Static(String),
    Passing,
}

impl Kind {
    fn of(message: &LogMsg) -> Self {
        match message {
            LogMsg::SetStoreInfo(info) if info.info.store_id.is_blueprint() => Self::LayoutBegins,
            LogMsg::SetStoreInfo(_) => Self::Store,
            LogMsg::BlueprintActivationCommand(_) => Self::Layout,
            LogMsg::ArrowMsg(store, _) if store.is_blueprint() => Self::Layout,
            LogMsg::ArrowMsg(_, arrow) => match Chunk::from_arrow_msg(arrow) {
                Ok(chunk) if chunk.is_static() => {
                    let mut components: Vec<_> =
                        chunk.components_identifiers().map(|c| c.to_string()).collect();
                    components.sort_unstable();
                    Self::Static(format!("{} {}", chunk.entity_path(), components.join(" ")))
                }
                _ => Self::Passing,
            },
        }
    }
}

impl Inside {
    fn end(&self) -> u64 {
        self.first + self.ring.len() as u64
    }

    fn add(&mut self, kind: Kind, message: Message, limit: usize) {
        let stands = !matches!(kind, Kind::Passing);
        let number = self.end();
        let numbered = || Numbered(number, message.clone());
        match kind {
            Kind::LayoutBegins => self.layout = vec![numbered()],
            Kind::Layout => self.layout.push(numbered()),
            Kind::Store => self.store = Some(numbered()),
            Kind::Static(key) => drop(self.statics.insert(key, numbered())),
            Kind::Passing => {}
        }
        let bytes = payload_bytes(&message) + OVERHEAD_BYTES;
        self.bytes += bytes;
        self.ring.push_back(Entry { message, bytes, stands, came: Instant::now() });
        while self.bytes > limit && self.ring.len() > 1 {
            self.bytes -= self.ring.pop_front().map_or(0, |entry| entry.bytes);
            self.first += 1;
        }
    }

    /// What stands and came from `since` on. A viewer that hears of a recording before its layout makes up one of
    /// its own: the layout comes first.
    fn standing(&self, since: u64) -> VecDeque<Message> {
        let all = self.layout.iter().chain(&self.store).chain(self.statics.values());
        all.filter(|Numbered(number, _)| *number >= since)
            .map(|Numbered(_, message)| message.clone())
            .collect()
    }
}

fn payload_bytes(message: &Message) -> usize {
    use re_protos::log_msg::v1alpha1::log_msg::Msg;
    match &message.msg {
        Some(Msg::ArrowMsg(arrow)) => arrow.payload.len(),
        _ => 0,
    }
}

impl Hub {
    /// A hub that keeps so many bytes of the past; [`HISTORY_BYTES`] is usual.
    pub fn new(history_bytes: usize) -> Arc<Self> {
        Arc::new(Self { inside: Mutex::default(), changed: Notify::new(), history_bytes })
    }

    /// What it has sent.
    pub fn sent(&self) -> Sent {
        self.lock().sent
    }

    /// Bytes of the past that it holds.
    pub fn held_bytes(&self) -> usize {
        self.lock().bytes
    }

    /// A new viewer.
    pub fn join(self: &Arc<Self>) -> Viewer {
        let mut inside = self.lock();
        inside.sent.viewers += 1;
        let now = inside.end();
        Viewer { hub: self.clone(), standing: inside.standing(0), next: now, older: now }
    }

    /// A viewer elsewhere was lost.
    pub fn count_reconnect(&self) {
        self.lock().sent.reconnects += 1;
    }

    /// Whether no more will come.
    pub fn is_closed(&self) -> bool {
        self.lock().closed
    }

    /// No more will come.
    pub fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_waiters();
    }

    fn add(&self, message: &LogMsg) {
        let kind = Kind::of(message);
        match message.to_transport(Compression::LZ4) {
            Ok(encoded) => self.lock().add(kind, Message { msg: Some(encoded) }, self.history_bytes),
            Err(fault) => tracing::warn!("a row cannot be encoded for viewers: {fault}"),
        }
        self.changed.notify_waiters();
    }

    /// Every change of the inside is complete on its own, so a panic elsewhere leaves nothing half done.
    fn lock(&self) -> MutexGuard<'_, Inside> {
        self.inside.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A viewer's places in the ring.
pub struct Viewer {
    hub: Arc<Hub>,
    standing: VecDeque<Message>,
    /// The entry it takes next.
    next: u64,
    /// All from here to where it joined it has taken, going back.
    older: u64,
}

impl Viewer {
    /// The next message, when there is one; None when no more will come.
    pub async fn next(&mut self) -> Option<Message> {
        let hub = self.hub.clone();
        loop {
            let changed = hub.changed.notified();
            if let Some(message) = self.take() {
                return Some(message);
            }
            if hub.is_closed() {
                return None;
            }
            changed.await;
        }
    }

    /// The next message, if there is one now.
    pub fn take(&mut self) -> Option<Message> {
        let hub = self.hub.clone();
        let mut inside = hub.lock();
        self.catch_up(&mut inside);
        let message =
            self.standing.pop_front().or_else(|| self.newer(&inside)).or_else(|| self.older(&inside));
        inside.sent.taken += u64::from(message.is_some());
        message
    }

    /// Takes a viewer that is too far behind to the present; what stands may have changed meanwhile.
    fn catch_up(&mut self, inside: &mut Inside) {
        let place = self.next.checked_sub(inside.first).map(|place| place as usize);
        let late = match place {
            None => true,
            Some(place) => inside.ring.get(place).is_some_and(|entry| entry.came.elapsed() > MOST_BEHIND),
        };
        // While it still gets what stands, nothing else was promised to it.
        if !late || !self.standing.is_empty() {
            return;
        }
        self.standing = inside.standing(self.next);
        inside.sent.dropped += (inside.end() - self.next).saturating_sub(self.standing.len() as u64);
        self.next = inside.end();
    }

    fn newer(&mut self, inside: &Inside) -> Option<Message> {
        let entry = inside.ring.get(usize::try_from(self.next.checked_sub(inside.first)?).ok()?)?;
        self.next += 1;
        Some(entry.message.clone())
    }

    fn older(&mut self, inside: &Inside) -> Option<Message> {
        while self.older > inside.first {
            self.older -= 1;
            let entry = inside.ring.get((self.older - inside.first) as usize)?;
            if !entry.stands {
                return Some(entry.message.clone());
            }
        }
        None
    }
}

impl Drop for Viewer {
    /// One that stood still until it was let go of missed all that came meanwhile.
    fn drop(&mut self) {
        let mut inside = self.hub.lock();
        inside.sent.viewers -= 1;
        inside.sent.dropped += inside.end() - self.next;
    }
}

/// The hub as a place that a recording goes to.
pub struct HubSink(pub Arc<Hub>);

impl LogSink for HubSink {
    fn send(&self, message: LogMsg) {
        self.0.add(&message);
    }

    /// Gives viewers a moment to take the last of it. What they do not take is theirs to miss, and no failure.
    fn flush_blocking(&self, timeout: Duration) -> Result<(), SinkFlushError> {
        std::thread::sleep(if self.0.sent().viewers > 0 {
            timeout.min(FLUSH_PATIENCE)
        } else {
            Duration::ZERO
        });
        Ok(())
    }
}

impl Drop for HubSink {
    fn drop(&mut self) {
        self.0.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::named_view::NamedView;
    use crate::recording::Recording;
    use crate::slot::News;
    use crate::testing::{self, Ride};
    use crate::view::View;
    use re_protos::common::v1alpha1::StoreKind;
    use re_protos::log_msg::v1alpha1::log_msg::Msg;
    use rerun::RecordingStreamBuilder;
    use rerun::log::ChunkBatcherConfig;

    /// A hub into which a ride of so many ticks was drawn.
    fn ridden(history_bytes: usize, ticks: u64) -> (Arc<Hub>, View) {
        let hub = Hub::new(history_bytes);
        // A chunk a row, as when time goes by.
        let builder =
            RecordingStreamBuilder::new("ballroom_test").batcher_config(ChunkBatcherConfig::ALWAYS_TEST_ONLY);
        let stream = builder.buffered().unwrap();
        let recording = Recording::into_sink(stream, Box::new(HubSink(hub.clone())));
        let mut view = View::new(recording, NamedView::default());
        let world = testing::original();
        view.show(&News { world: Some(Arc::new(world.clone())), ..News::default() }).unwrap();
        let mut ride = Ride::new(&world);
        for tick in 1..ticks {
            view.show(&News { state: Some(Arc::new(ride.state(tick))), ..News::default() }).unwrap();
        }
        view.recording().stream().flush_blocking().unwrap();
        (hub, view)
    }

    fn all(viewer: &mut Viewer) -> Vec<Message> {
        std::iter::from_fn(|| viewer.take()).collect()
    }

    fn is_layout(message: &Message) -> bool {
        let store = match message.msg.as_ref().unwrap() {
            Msg::SetStoreInfo(info) => info.info.as_ref().unwrap().store_id.as_ref(),
            Msg::ArrowMsg(arrow) => arrow.store_id.as_ref(),
            Msg::BlueprintActivationCommand(_) => return true,
        };
        store.unwrap().kind() == StoreKind::Blueprint
    }

    fn is_static(message: &Message) -> bool {
        matches!(&message.msg, Some(Msg::ArrowMsg(arrow)) if arrow.is_static == Some(true))
    }

    #[test]
    fn a_late_viewer_gets_layout_recording_and_what_stands_before_the_past() {
        let (hub, _view) = ridden(HISTORY_BYTES, 60);
        let messages = all(&mut hub.join());
        let layout = messages.iter().take_while(|message| is_layout(message)).count();
        assert!(layout > 10 && matches!(messages[layout - 1].msg, Some(Msg::BlueprintActivationCommand(_))));
        assert!(matches!(messages[layout].msg, Some(Msg::SetStoreInfo(_))));
        let standing = messages[layout + 1..].iter().take_while(|message| is_static(message)).count();
        let past = &messages[layout + 1 + standing..];
        assert!(standing > 10 && past.len() > 300, "{standing} stand, {} passed", past.len());
        assert!(!past.iter().any(|message| is_layout(message) || is_static(message)));
    }

    #[test]
    fn what_stands_is_held_once_however_often_it_changes() {
        let (hub, mut view) = ridden(HISTORY_BYTES, 2);
        let standing = all(&mut hub.join()).iter().filter(|message| is_static(message)).count();
        let mut world = testing::original();
        for epoch in 2..20 {
            world.snapshot.epoch = epoch;
            world.scene.description = epoch.to_string();
            let protocol::scene::Floor::Grid { control_heights_m, .. } = &mut world.scene.floor else {
                panic!()
            };
            control_heights_m[5][5] += 0.01;
            view.show(&News { world: Some(Arc::new(world.clone())), ..News::default() }).unwrap();
        }
        view.recording().stream().flush_blocking().unwrap();
        let after = all(&mut hub.join()).iter().filter(|message| is_static(message)).count();
        assert_eq!(after, standing);
    }

    #[test]
    fn the_past_is_bounded_and_a_viewer_that_it_overtakes_is_taken_to_the_present() {
        let bytes = 200_000;
        let (hub, mut view) = ridden(bytes, 2);
        let mut slow = hub.join();
        all(&mut slow);
        let mut ride = Ride::new(&testing::original());
        for tick in 2..300 {
            view.show(&News { state: Some(Arc::new(ride.state(tick))), ..News::default() }).unwrap();
        }
        view.recording().stream().flush_blocking().unwrap();
        assert!(hub.held_bytes() <= bytes, "{}", hub.held_bytes());
        assert_eq!(all(&mut slow).len(), 0);
        let dropped = hub.sent().dropped;
        assert!(dropped > 1000, "{dropped} dropped");
        view.show(&News { state: Some(Arc::new(ride.state(300))), ..News::default() }).unwrap();
        view.recording().stream().flush_blocking().unwrap();
        assert!(!all(&mut slow).is_empty() && hub.sent().dropped == dropped);
    }

    fn layout_id() -> rerun::StoreId {
        rerun::StoreId::random(rerun::StoreKind::Blueprint, "ballroom_test")
    }

    #[test]
    fn viewers_are_counted_while_they_are_there() {
        let hub = Hub::new(HISTORY_BYTES);
        let (one, two) = (hub.join(), hub.join());
        assert_eq!(hub.sent().viewers, 2);
        drop(one);
        assert_eq!(hub.sent().viewers, 1);
        drop(two);
        assert_eq!(hub.sent(), Sent::default());
        let (hub, _view) = ridden(HISTORY_BYTES, 2);
        let stalled = hub.join();
        let sink = HubSink(hub.clone());
        sink.send(
            rerun::external::re_log_types::BlueprintActivationCommand::make_default(layout_id()).into(),
        );
        drop(stalled);
        assert_eq!(hub.sent().dropped, 1, "what came while it stood still");
    }
}
