//! How the states come: measured where they arrive, and told to the server once a second.

use crate::client::ClientError;
use protocol::codec;
use protocol::report::{REPORT_EVERY, Report, Stamp};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime};
use zenoh::Wait;
use zenoh::handlers::{Callback, IntoHandler, RingChannel, RingChannelHandler};
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::sample::Sample;

/// Ages kept of one second; of more, the first ones speak for the rest.
const SAMPLES: usize = 4096;

/// Shared by the receiving thread and whoever reads.
#[derive(Clone, Default)]
pub struct Meter(Arc<Mutex<Counts>>);

#[derive(Default)]
struct Counts {
    /// Of the last message.
    stamp: Option<Stamp>,
    received: u64,
    lost: u64,
    overtaken: u64,
    /// Arrived and not read yet.
    waiting: usize,
    bytes: u64,
    ages_ms: Vec<f64>,
    counted: u64,
}

impl Meter {
    fn lock(&self) -> MutexGuard<'_, Counts> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A message arrived where `depth` have room to wait; false when it is the last one once more, which is passed over.
    fn arrived(&self, stamp: Option<Stamp>, bytes: usize, depth: usize, wall_ns: u64) -> bool {
        let mut counts = self.lock();
        if stamp.is_some() && stamp == counts.stamp {
            return false;
        }
        counts.received += 1;
        counts.bytes += bytes as u64;
        if counts.waiting < depth {
            counts.waiting += 1;
        } else {
            counts.overtaken += 1;
        }
        let Some(stamp) = stamp else { return true };
        // A number that is not larger is that of a server begun anew.
        if let Some(before) = counts.stamp.replace(stamp).filter(|before| before.sequence < stamp.sequence) {
            counts.lost += stamp.sequence - before.sequence - 1;
        }
        if counts.ages_ms.len() < SAMPLES {
            counts.ages_ms.push((wall_ns as f64 - stamp.wall_ns as f64) / 1e6);
        }
        true
    }

    /// A message was read.
    pub fn read(&self) {
        let mut counts = self.lock();
        counts.waiting = counts.waiting.saturating_sub(1);
    }

    /// What came over a time, which begins anew.
    fn report(&self, over: Duration) -> Report {
        let mut counts = self.lock();
        let per_s = |count: u64| count as f64 / over.as_secs_f64().max(1e-3);
        let ages = &mut counts.ages_ms;
        let steps = ages.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let jitter_ms = (ages.len() > 1).then(|| steps.sum::<f64>() / (ages.len() - 1) as f64);
        ages.sort_unstable_by(f64::total_cmp);
        let age_ms = ages.last().map(|largest| [ages[ages.len() / 2], *largest]);
        ages.clear();
        let came = counts.received - counts.counted;
        counts.counted = counts.received;
        Report {
            states_per_s: per_s(came),
            bytes_per_s: per_s(std::mem::take(&mut counts.bytes)),
            age_ms,
            jitter_ms,
            received: counts.received,
            lost: Some(counts.lost),
            overtaken: counts.overtaken,
        }
    }
}

/// A ring into which nothing comes unmeasured.
pub struct Metered {
    pub depth: usize,
    pub meter: Meter,
}

impl IntoHandler<Sample> for Metered {
    type Handler = RingChannelHandler<Sample>;

    fn into_handler(self) -> (Callback<Sample>, Self::Handler) {
        let Self { depth, meter } = self;
        let (ring, handler) = IntoHandler::<Sample>::into_handler(RingChannel::new(depth));
        let callback = move |sample: Sample| {
            let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
            let stamp = sample.attachment().and_then(|bytes| Stamp::from_bytes(&bytes.to_bytes()));
            if meter.arrived(stamp, sample.payload().len(), depth, now.as_nanos() as u64) {
                ring.call(sample);
            }
        };
        (Callback::from(callback), handler)
    }
}

/// Tells the server.
pub struct Reporter {
    meter: Meter,
    publisher: Publisher<'static>,
    since: Instant,
}

impl Reporter {
    pub fn new(session: &zenoh::Session, key: String, meter: Meter) -> Result<Self, ClientError> {
        // A lost report is followed by the next; nothing waits for it.
        let publisher = session
            .declare_publisher(key)
            .priority(Priority::Background)
            .congestion_control(CongestionControl::Drop)
            .wait()?;
        Ok(Self { meter, publisher, since: Instant::now() })
    }

    /// When the next report is due.
    pub fn due(&self) -> Instant {
        self.since + REPORT_EVERY
    }

    /// Reports if it is time.
    pub fn report(&mut self) {
        let over = self.since.elapsed();
        if over < REPORT_EVERY {
            return;
        }
        self.since = Instant::now();
        let report = codec::encode_json(&self.meter.report(over));
        if let Err(e) = self.publisher.put(report).wait() {
            tracing::debug!("{} could not be published: {e}", self.publisher.key_expr());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    const fn stamp(sequence: u64, wall_ns: u64) -> Stamp {
        Stamp { sequence, wall_ns }
    }

    #[test]
    fn gaps_in_the_numbers_are_losses_and_a_number_from_the_start_is_a_new_server() {
        let meter = Meter::default();
        for sequence in [40, 41, 44, 45, 0, 1, 3] {
            meter.arrived(Some(stamp(sequence, 0)), 10, 1, 0);
            meter.read();
        }
        let report = meter.report(Duration::from_secs(1));
        assert_eq!((report.received, report.lost, report.overtaken), (7, Some(3), 0));
        assert_eq!((report.states_per_s, report.bytes_per_s), (7.0, 70.0));
    }

    #[test]
    fn a_message_said_once_more_counts_once() {
        let meter = Meter::default();
        let came = [1, 1, 2, 2, 4].map(|sequence| meter.arrived(Some(stamp(sequence, 0)), 1, 8, 0));
        assert_eq!(came, [true, false, true, false, true]);
        let report = meter.report(Duration::from_secs(1));
        assert_eq!((report.received, report.lost), (3, Some(1)));
    }

    #[test]
    fn what_is_not_read_in_time_is_overtaken_and_not_lost() {
        let meter = Meter::default();
        for sequence in 0..10 {
            meter.arrived(Some(stamp(sequence, 0)), 1, 1, 0);
        }
        meter.read();
        let report = meter.report(Duration::from_secs(1));
        assert_eq!((report.received, report.lost, report.overtaken), (10, Some(0), 9));
    }

    #[test]
    fn jitter_is_the_same_whatever_the_clocks_differ_by() {
        let jitter = |offset: u64| {
            let meter = Meter::default();
            for (sequence, late) in [1, 3, 2, 2].into_iter().enumerate() {
                meter.arrived(Some(stamp(sequence as u64, 100 * MS)), 1, 8, (100 + late + offset) * MS);
            }
            let report = meter.report(Duration::from_secs(1));
            let [median, largest] = report.age_ms.unwrap();
            assert_eq!((median, largest), (2.0 + offset as f64, 3.0 + offset as f64));
            assert!(meter.report(Duration::from_secs(1)).age_ms.is_none());
            report.jitter_ms.unwrap()
        };
        assert_eq!((jitter(0), jitter(5000)), (1.0, 1.0));
    }
}
