//! How many commands one source may send: a token bucket each.

use protocol::keys::Name;
use std::collections::BTreeMap;
use std::time::Instant;

/// Commands a second, twice what a held key that repeats at 60 Hz needs.
const RATE_PER_S: f64 = 120.0;
/// Commands at once.
const BURST: f64 = 120.0;
/// Sources remembered.
const MAX_SOURCES: usize = 256;

/// The buckets of all sources.
#[derive(Default)]
pub struct Budget {
    buckets: BTreeMap<Name, Bucket>,
}

struct Bucket {
    tokens: f64,
    filled: Instant,
}

impl Bucket {
    fn level(&self, now: Instant) -> f64 {
        (self.tokens + now.saturating_duration_since(self.filled).as_secs_f64() * RATE_PER_S).min(BURST)
    }
}

impl Budget {
    /// Whether `source` may send one more command now.
    pub fn allows(&mut self, source: &Name, now: Instant) -> bool {
        if !self.buckets.contains_key(source) {
            if self.buckets.len() >= MAX_SOURCES {
                // A full bucket remembers nothing.
                self.buckets.retain(|_, bucket| bucket.level(now) < BURST);
            }
            if self.buckets.len() >= MAX_SOURCES {
                return false;
            }
        }
        let bucket = self.buckets.entry(source.clone()).or_insert(Bucket { tokens: BURST, filled: now });
        let level = bucket.level(now);
        let allowed = level >= 1.0;
        *bucket = Bucket { tokens: if allowed { level - 1.0 } else { level }, filled: now };
        allowed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn a_flood_is_cut_to_the_rate_and_spares_the_others() {
        let (mut budget, start) = (Budget::default(), Instant::now());
        let (loud, quiet): (Name, Name) = ("loud".parse().unwrap(), "quiet".parse().unwrap());
        let flood =
            (0..10_000).filter(|i| budget.allows(&loud, start + Duration::from_micros(100 * i))).count();
        // One second of it: the burst and a second's worth.
        assert!((239..=241).contains(&flood), "{flood}");
        assert!(budget.allows(&quiet, start));
    }

    #[test]
    fn the_memory_for_sources_is_bounded_and_forgets_the_idle() {
        let (mut budget, start) = (Budget::default(), Instant::now());
        let source = |i: usize| -> Name { format!("s{i}").parse().unwrap() };
        assert!((0..MAX_SOURCES).all(|i| budget.allows(&source(i), start)));
        assert!(!budget.allows(&source(MAX_SOURCES), start));
        assert!(budget.allows(&source(MAX_SOURCES), start + Duration::from_secs(2)));
    }
}
