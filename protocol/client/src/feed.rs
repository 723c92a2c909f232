//! What the server publishes. Everything goes through rings that drop the oldest: a full queue of the other kind
//! would stall the whole session.

use crate::client::ClientError;
use crate::meter::{Meter, Metered, Reporter};
use protocol::codec::CodecError;
use protocol::keys::Name;
use std::time::{Duration, Instant};
use zenoh::Wait;
use zenoh::handlers::{RingChannel, RingChannelHandler};
use zenoh::pubsub::Subscriber;
use zenoh::sample::{Sample, SampleKind};

type RingSubscriber = Subscriber<RingChannelHandler<Sample>>;

/// One kind of message as it comes in.
pub struct Feed<T> {
    subscriber: RingSubscriber,
    decode: fn(&[u8]) -> Result<T, CodecError>,
    unreadable: u64,
    meter: Meter,
    reporter: Option<Reporter>,
}

impl<T> Feed<T> {
    pub(crate) fn subscribe(
        session: &zenoh::Session,
        key: &str,
        depth: usize,
        decode: fn(&[u8]) -> Result<T, CodecError>,
    ) -> Result<Self, ClientError> {
        let meter = Meter::default();
        let ring = Metered { depth, meter: meter.clone() };
        let subscriber = session.declare_subscriber(key.to_owned()).with(ring).wait()?;
        Ok(Self { subscriber, decode, unreadable: 0, meter, reporter: None })
    }

    /// The same; how it comes is told under `key`.
    pub(crate) fn reporting(mut self, session: &zenoh::Session, key: String) -> Result<Self, ClientError> {
        self.reporter = Some(Reporter::new(session, key, self.meter.clone())?);
        Ok(self)
    }

    /// The next message, waiting at most `timeout`. Messages that cannot be read are counted and passed over.
    pub fn recv_timeout(&mut self, timeout: Duration) -> Result<Option<T>, ClientError> {
        let deadline = Instant::now() + timeout;
        loop {
            let until = self.reporter.as_ref().map_or(deadline, |reporter| reporter.due().min(deadline));
            let sample = self.subscriber.recv_deadline(until)?;
            if let Some(reporter) = &mut self.reporter {
                reporter.report();
            }
            let Some(sample) = sample else {
                if until < deadline {
                    continue;
                }
                return Ok(None);
            };
            self.meter.read();
            match (self.decode)(&sample.payload().to_bytes()) {
                Ok(message) => return Ok(Some(message)),
                Err(e) => {
                    self.unreadable += 1;
                    tracing::warn!("{} cannot be read: {e}", sample.key_expr());
                }
            }
        }
    }

    /// The next message if it is already here.
    pub fn try_recv(&mut self) -> Result<Option<T>, ClientError> {
        self.recv_timeout(Duration::ZERO)
    }

    /// Messages that could not be read so far.
    pub const fn unreadable(&self) -> u64 {
        self.unreadable
    }
}

/// Someone came or went.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Presence {
    /// There now.
    Here(Name),
    /// No more.
    Gone(Name),
}

/// Who comes and goes, beginning with those already there.
pub struct Presences {
    subscriber: RingSubscriber,
}

impl Presences {
    pub(crate) fn watch(session: &zenoh::Session, key: &str) -> Result<Self, ClientError> {
        let subscriber = session
            .liveliness()
            .declare_subscriber(key.to_owned())
            .history(true)
            .with(RingChannel::new(64))
            .wait()?;
        Ok(Self { subscriber })
    }

    /// The next change, waiting at most `timeout`.
    pub fn recv_timeout(&self, timeout: Duration) -> Result<Option<Presence>, ClientError> {
        let deadline = Instant::now() + timeout;
        while let Some(sample) = self.subscriber.recv_deadline(deadline)? {
            // A token under a name of another kind is none of ours.
            let Some(id) = sample.key_expr().as_str().rsplit('/').next().and_then(|id| id.parse().ok())
            else {
                continue;
            };
            return Ok(Some(match sample.kind() {
                SampleKind::Put => Presence::Here(id),
                SampleKind::Delete => Presence::Gone(id),
            }));
        }
        Ok(None)
    }
}
