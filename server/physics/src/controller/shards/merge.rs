//! One report and one list of hits of what several shards did, in the one order of all events.

use super::share::Share;
use super::{Shard, Shards};
use crate::controller::Controller;
use crate::schedule::time::Time;
use crate::tolerance::HITS_KEPT;

fn notes(shard: &Shard) -> Option<&Share> {
    shard.0.share.as_deref()
}

/// Calls `visit` for every place of every shard's list, instant by instant and ball by ball. No two shards list the same
/// ball.
fn in_order(
    list: &[Shard],
    key: impl Fn(&Shard, usize) -> Option<(Time, usize)>,
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
            whole.report.hits_dropped += notes(shard).map_or(0, |notes| notes.hits_dropped);
        }
        in_order(
            &self.list,
            |shard, place| Some((*notes(shard)?.hit_times.get(place)?, shard.0.hits[place].ball)),
            |shard, place| {
                if whole.hits.len() < HITS_KEPT {
                    whole.hits.push(shard.0.hits[place]);
                } else {
                    whole.report.hits_dropped += 1;
                }
            },
        );
        whole.keep_hits();
        in_order(
            &self.list,
            |shard, place| {
                let (time, addend) = notes(shard)?.addends.get(place)?;
                Some((*time, addend.ball as usize))
            },
            |shard, place| {
                if let Some((_, addend)) = notes(shard).and_then(|notes| notes.addends.get(place)) {
                    whole.add_up(*addend);
                }
            },
        );
    }
}
