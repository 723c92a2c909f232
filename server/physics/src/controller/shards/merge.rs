//! One report and one list of hits of what several shards did, in the one order of all events.

use super::share::{Key, Share};
use super::{Shard, Shards};
use crate::controller::Controller;
use crate::tolerance::HITS_KEPT;

fn notes(shard: &Shard) -> Option<&Share> {
    shard.0.share.as_deref()
}

/// Calls `visit` for every place of every shard's sorted keys, first keys first.
fn in_order(
    list: &[Shard],
    key: impl Fn(&Shard, usize) -> Option<Key>,
    mut visit: impl FnMut(&Shard, usize),
) {
    let mut places = [0; super::SHARDS_MAX];
    loop {
        let heads = list.iter().zip(&places).enumerate();
        let first = heads.filter_map(|(s, (shard, place))| Some((key(shard, *place)?, s))).min();
        let Some((_, s)) = first else { return };
        visit(&list[s], places[s]);
        places[s] += 1;
    }
}

impl Shards {
    /// Adds what the shards did in this phase to the whole's accounts.
    pub(super) fn merge(&self, whole: &mut Controller) {
        for shard in &self.list {
            whole.report.add_counts(&shard.0.report);
            whole.now = whole.now.max(shard.0.now);
        }
        in_order(
            &self.list,
            |shard, place| Some(*notes(shard)?.hit_keys.get(place)?),
            |shard, place| {
                if whole.hits.len() < HITS_KEPT {
                    whole.hits.push(shard.0.hits[place]);
                } else {
                    whole.report.hits_dropped += 1;
                }
            },
        );
        in_order(
            &self.list,
            |shard, place| Some(notes(shard)?.bookings.get(place)?.key),
            |shard, place| {
                if let Some(booking) = notes(shard).and_then(|notes| notes.bookings.get(place)) {
                    whole.report.steering_work += booking.work;
                    whole.report.negative_reaction += booking.pulled;
                }
            },
        );
    }
}
