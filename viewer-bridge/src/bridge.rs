//! The bridge as a whole: recordings that are drawn, and the network that feeds them.

use crate::live::{self, Live};
use crate::logger::Logger;
use crate::slot::Slot;
use anyhow::{Context, Result};
use ballroom_client::{Client, Update};
use protocol::keys::Role;
use rerun::RecordingStreamBuilder;
use rerun::log::ChunkBatcherConfig;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Rerun keeps one layout per application.
pub const APPLICATION: &str = "ballroom";

/// Longest wait for a state before hits, statistics and the end are looked for.
const LOOK_AROUND: Duration = Duration::from_millis(50);
/// Messages of a kind taken at one look; the rest waits for the next.
const MESSAGES_A_LOOK: usize = 64;

/// What a bridge shall write to.
#[derive(Clone, Debug)]
pub struct Options {
    /// Serve viewers.
    pub live: bool,
    /// Write a file.
    pub save: Option<PathBuf>,
    /// Frames per second at most, in either.
    pub frames_per_second: u32,
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
        let builder = || RecordingStreamBuilder::new(APPLICATION).recording_id(id.as_str());
        let mut loggers = Vec::new();
        if let Some(path) = &options.save {
            let stream = builder()
                .batcher_config(ChunkBatcherConfig::DEFAULT)
                .save(path)
                .with_context(|| format!("cannot write {}: choose a file in a directory that exists", path.display()))?;
            loggers.push(Logger::start("file", stream, options.frames_per_second)?);
        }
        let mut live = None;
        if options.live {
            let (stream, where_to) = live::serve(builder())?;
            loggers.push(Logger::start("live", stream, options.frames_per_second)?);
            live = Some(where_to);
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
        // One after the other; the file is first, and only a viewer can use up its time.
        self.loggers.into_iter().fold(true, |written, logger| logger.stop() && written)
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
                slots.iter().for_each(|slot| slot.world(world.clone()));
                if std::mem::take(&mut lost) {
                    tell(slots, false, "the server is back");
                }
            }
            Some(Update::State(state)) => {
                let state: Arc<_> = (*state).into();
                slots.iter().for_each(|slot| slot.state(state.clone()));
            }
            Some(Update::Gone) => {
                lost = true;
                tell(slots, true, "the server is gone, waiting for it");
            }
            None => {}
        }
        for _ in 0..MESSAGES_A_LOOK {
            let Some(batch) = events.try_recv()? else { break };
            slots.iter().for_each(|slot| slot.hits(batch.events.iter().cloned()));
        }
        for _ in 0..MESSAGES_A_LOOK {
            let Some(stats) = stats.try_recv()? else { break };
            slots.iter().for_each(|slot| slot.stats(stats.clone()));
        }
    }
    Ok(())
}

fn tell(slots: &[Arc<Slot>], warning: bool, text: &str) {
    slots.iter().for_each(|slot| slot.note(warning, text));
    if warning { tracing::warn!("{text}") } else { tracing::info!("{text}") }
}
