//! The bridge as a whole: recordings that are drawn, and the network that feeds them.

use crate::hub::{HISTORY_BYTES, Hub, HubSink};
use crate::live::{self, Live};
use crate::logger::Logger;
use crate::named_view::NamedView;
use crate::push;
use crate::recording::Recording;
use crate::slot::Slot;
use crate::view::View;
use anyhow::{Context, Result};
use ballroom_client::{Client, Update};
use protocol::keys::Role;
use rerun::RecordingStreamBuilder;
use rerun::external::re_uri::ProxyUri;
use rerun::log::ChunkBatcherConfig;
use rerun::sink::{FileSink, LogSink};
use std::net::IpAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Rerun keeps one layout per application.
pub const APPLICATION: &str = "ballroom";

/// How long rows wait for company on their way to a viewer: below one frame at 60 Hz.
const LIVE_FLUSH: Duration = Duration::from_millis(12);
/// The same on their way to a file: fewer, larger chunks take a tenth of the room.
const FILE_FLUSH: Duration = Duration::from_millis(200);

/// Longest wait for a state before hits, statistics and the end are looked for.
const LOOK_AROUND: Duration = Duration::from_millis(50);
/// Messages of a kind taken at one look; the rest waits for the next.
const MESSAGES_A_LOOK: usize = 64;

/// What a bridge shall write to.
#[derive(Clone, Debug)]
pub struct Options {
    /// Serve viewers, on this address.
    pub serve: Option<IpAddr>,
    /// Send to a viewer elsewhere.
    pub connect: Option<ProxyUri>,
    /// Write a file.
    pub save: Option<PathBuf>,
    /// Frames per second at most, in either.
    pub frames_per_second: u32,
    /// The view to open with.
    pub view: NamedView,
}

/// Recordings being drawn.
pub struct Bridge {
    loggers: Vec<Logger>,
    live: Option<Live>,
}

impl Bridge {
    /// Opens what the options name. Live and file are two streams of one recording.
    pub fn start(options: &Options) -> Result<Self> {
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let id = format!("ballroom-{}-{}", since_1970.as_millis(), std::process::id());
        let recording = |flush_tick: Duration, sink: Box<dyn LogSink>| -> Result<Recording> {
            let batching = ChunkBatcherConfig { flush_tick, ..ChunkBatcherConfig::DEFAULT };
            let builder = RecordingStreamBuilder::new(APPLICATION).recording_id(id.as_str());
            Ok(Recording::into_sink(builder.batcher_config(batching).buffered()?, sink))
        };
        let mut loggers = Vec::new();
        if let Some(path) = &options.save {
            let sink = FileSink::new(path).with_context(|| {
                format!("cannot write {}: choose a file in a directory that exists", path.display())
            })?;
            let view = View::new(recording(FILE_FLUSH, Box::new(sink))?, options.view.clone());
            loggers.push(Logger::start("file", view, options.frames_per_second, None)?);
        }
        let mut live = None;
        if options.serve.is_some() || options.connect.is_some() {
            let hub = Hub::new(HISTORY_BYTES);
            live = options.serve.map(|listen| live::serve(hub.clone(), listen)).transpose()?;
            if let Some(viewer) = &options.connect {
                push::start(hub.clone(), viewer.clone())?;
            }
            let sink = Box::new(HubSink(hub.clone()));
            let view = View::new(recording(LIVE_FLUSH, sink)?, options.view.clone());
            loggers.push(Logger::start("live", view, options.frames_per_second, Some(hub))?);
        }
        Ok(Self { loggers, live })
    }

    /// Where viewers find it, if it serves any.
    pub const fn live(&self) -> Option<&Live> {
        self.live.as_ref()
    }

    /// Where news go, one slot a recording.
    pub fn slots(&self) -> Vec<Arc<Slot>> {
        self.loggers.iter().map(Logger::slot).collect()
    }

    /// Ends all recordings within a bound. Returns whether all of it was written.
    pub fn stop(self) -> bool {
        // Every one is stopped, in turn; the file is first, and only a viewer can use up its time.
        let written: Vec<bool> = self.loggers.into_iter().map(Logger::stop).collect();
        !written.contains(&false)
    }
}

/// Carries everything from a session into the slots, until the client's options are aborted.
pub fn pump(client: &Client, slots: &[Arc<Slot>]) -> Result<()> {
    let id = format!("rerun-{}", std::process::id()).parse()?;
    let _token = client.announce(Role::Viewer, &id)?;
    let mut follower = client.follow()?;
    let (mut events, mut stats) = (client.subscribe_events()?, client.subscribe_stats()?);
    let mut lost = false;
    while !client.options().abort.is_aborted() {
        match follower.next_within(LOOK_AROUND)? {
            Some(Update::World(world)) => {
                let world: Arc<_> = (*world).into();
                for slot in slots {
                    slot.world(world.clone());
                }
                if std::mem::take(&mut lost) {
                    tell(slots, false, "the server is back");
                }
            }
            Some(Update::State(state)) => {
                let state: Arc<_> = (*state).into();
                for slot in slots {
                    slot.state(state.clone());
                }
            }
            Some(Update::Gone) => {
                lost = true;
                tell(slots, true, "the server is gone, waiting for it");
            }
            None => {}
        }
        for _ in 0..MESSAGES_A_LOOK {
            let Some(batch) = events.try_recv()? else { break };
            for slot in slots {
                slot.hits(batch.events.iter().cloned());
            }
        }
        for _ in 0..MESSAGES_A_LOOK {
            let Some(stats) = stats.try_recv()? else { break };
            for slot in slots {
                slot.stats(stats.clone());
            }
        }
    }
    Ok(())
}

fn tell(slots: &[Arc<Slot>], warning: bool, text: &str) {
    for slot in slots {
        slot.note(warning, text);
    }
    if warning { tracing::warn!("{text}") } else { tracing::info!("{text}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn a_stopped_bridge_leaves_a_complete_file() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("ride.rrd");
        let options = Options {
            serve: None,
            connect: None,
            save: Some(path.clone()),
            frames_per_second: 1000,
            view: NamedView::default(),
        };
        let bridge = Bridge::start(&options).unwrap();
        let slots = bridge.slots();
        slots[0].world(Arc::new(testing::original()));
        tell(&slots, true, "the server is gone, waiting for it");
        assert!(bridge.stop());
        let size = std::fs::metadata(&path).unwrap().len();
        assert!(size > 10_000, "the floor alone is larger than {size} bytes");
    }

    #[test]
    fn a_file_that_cannot_be_written_is_named() {
        let options = Options {
            serve: None,
            connect: None,
            save: Some("/nowhere/at/all.rrd".into()),
            frames_per_second: 60,
            view: NamedView::default(),
        };
        let fault = Bridge::start(&options).err().unwrap();
        assert!(fault.to_string().contains("/nowhere/at/all.rrd"), "{fault}");
    }
}
