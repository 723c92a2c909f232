//! How many commands and questions one source may send: a token bucket each.

use crate::bucket::Bucket;
use protocol::keys::Name;
use std::collections::BTreeMap;
use std::time::Instant;

/// Presses of one player a second, and at once: twice what a held key that repeats at 60 Hz needs.
pub const PRESSES_PER_S: f64 = 120.0;
/// Answered commands of all senders a second, questions of all, and either at once: a script that steps and looks
/// has room, and their cost stays a small part of a core.
pub const ANSWERS_PER_S: f64 = 2000.0;
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
pub struct Budget {
    players: BTreeMap<Name, Bucket>,
    commands: Bucket,
    questions: Bucket,
}

impl Default for Budget {
    fn default() -> Self {
        let full = || Bucket::full(ANSWERS_PER_S, Instant::now());
        Self { players: BTreeMap::new(), commands: full(), questions: full() }
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
                self.players.retain(|_, bucket| bucket.level(now) < PRESSES_PER_S);
            }
            if self.players.len() >= MAX_PLAYERS {
                return None;
            }
        }
        Some(self.players.entry(player.clone()).or_insert(Bucket::full(PRESSES_PER_S, now)))
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
