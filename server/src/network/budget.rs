//! How many commands and questions one source may send: a token bucket each.

use protocol::keys::Name;
use std::collections::BTreeMap;
use std::time::Instant;

/// Commands a second, twice what a held key that repeats at 60 Hz needs.
const RATE_PER_S: f64 = 120.0;
/// Commands at once.
const BURST: f64 = 120.0;
/// Players remembered.
const MAX_PLAYERS: usize = 256;

/// Who sends. Commands that are answered and questions do not say whom they are from, so all of a kind share a bucket.
pub enum Source {
    /// Presses of one player.
    Player(Name),
    /// Commands that are answered.
    Commands,
    /// Questions.
    Questions,
}

/// The buckets of all sources.
#[derive(Default)]
pub struct Budget {
    players: BTreeMap<Name, Bucket>,
    commands: Bucket,
    questions: Bucket,
}

struct Bucket {
    tokens: f64,
    filled: Instant,
}

impl Default for Bucket {
    fn default() -> Self {
        Self { tokens: BURST, filled: Instant::now() }
    }
}

impl Bucket {
    fn level(&self, now: Instant) -> f64 {
        (self.tokens + now.saturating_duration_since(self.filled).as_secs_f64() * RATE_PER_S).min(BURST)
    }

    fn take(&mut self, now: Instant) -> bool {
        let level = self.level(now);
        let allowed = level >= 1.0;
        *self = Self { tokens: if allowed { level - 1.0 } else { level }, filled: now };
        allowed
    }
}

impl Budget {
    /// Whether `source` may send one more now.
    pub fn allows(&mut self, source: &Source, now: Instant) -> bool {
        match source {
            Source::Player(name) => self.bucket_of(name, now).is_some_and(|bucket| bucket.take(now)),
            Source::Commands => self.commands.take(now),
            Source::Questions => self.questions.take(now),
        }
    }

    fn bucket_of(&mut self, player: &Name, now: Instant) -> Option<&mut Bucket> {
        if !self.players.contains_key(player) {
            if self.players.len() >= MAX_PLAYERS {
                // A full bucket remembers nothing.
                self.players.retain(|_, bucket| bucket.level(now) < BURST);
            }
            if self.players.len() >= MAX_PLAYERS {
                return None;
            }
        }
        Some(self.players.entry(player.clone()).or_insert(Bucket { tokens: BURST, filled: now }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn a_flood_is_cut_to_the_rate_and_spares_the_others() {
        let (mut budget, start) = (Budget::default(), Instant::now());
        let [loud, quiet] = ["loud", "quiet"].map(|name| Source::Player(name.parse().unwrap()));
        let flood =
            (0..10_000).filter(|i| budget.allows(&loud, start + Duration::from_micros(100 * i))).count();
        // One second of it: the burst and a second's worth.
        assert!((239..=241).contains(&flood), "{flood}");
        assert!(budget.allows(&quiet, start));
    }

    #[test]
    fn the_memory_for_players_is_bounded_and_forgets_the_idle() {
        let (mut budget, start) = (Budget::default(), Instant::now());
        let source = |i: usize| Source::Player(format!("s{i}").parse().unwrap());
        assert!((0..MAX_PLAYERS).all(|i| budget.allows(&source(i), start)));
        assert!(!budget.allows(&source(MAX_PLAYERS), start));
        assert!(budget.allows(&Source::Commands, start) && budget.allows(&Source::Questions, start));
        assert!(budget.allows(&source(MAX_PLAYERS), start + Duration::from_secs(2)));
    }
}
