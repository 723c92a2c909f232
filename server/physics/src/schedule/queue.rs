//! The first of all next events: a tournament with one leaf a ball. It never allocates after it is made.
//!
//! Four meet in a match, which fills one line of cache, and nearly all matches are decided by rounded times that are
//! compared as integers.

use super::clearance::Clearance;
use super::event::Next;
use super::time::Time;

/// Entries of a match.
const FOUR: usize = 4;

/// A tournament over the balls' next events.
#[derive(Clone, Debug)]
pub struct Queue {
    coming: Vec<Coming>,
    /// Round after round: of the balls, of the winners of their matches, and so on to one match.
    matches: Vec<Match>,
    /// Where each round begins.
    rounds: Vec<usize>,
    winner: Entry,
}

/// What comes for a ball.
#[derive(Clone, Copy, Debug)]
struct Coming {
    next: Next,
    alone: Clearance,
}

/// A ball and its time, rounded down.
#[derive(Clone, Copy, Debug)]
struct Entry {
    rounded: u64,
    ball: u32,
}

impl Entry {
    /// Where there is no ball: it never wins.
    const NOBODY: Self = Self { rounded: u64::MAX, ball: u32::MAX };
}

#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Match([Entry; FOUR]);

impl Queue {
    /// A queue for `balls` balls, none of which has anything coming.
    pub fn new(balls: usize) -> Self {
        let (mut matches, mut rounds) = (Vec::new(), Vec::new());
        let rounded = Time::NEVER.rounded_down();
        let mut entries: Vec<Entry> = (0..balls.max(1) as u32).map(|ball| Entry { rounded, ball }).collect();
        loop {
            rounds.push(matches.len());
            let round = entries.chunks(FOUR).map(|some| {
                let mut four = [Entry::NOBODY; FOUR];
                four[..some.len()].copy_from_slice(some);
                Match(four)
            });
            matches.extend(round);
            entries = entries.into_iter().step_by(FOUR).collect();
            if entries.len() == 1 {
                break;
            }
        }
        let coming = vec![Coming { next: Next::NEVER, alone: Clearance::UNKNOWN }; balls.max(1)];
        Self { coming, matches, rounds, winner: entries[0] }
    }

    /// What comes next for a ball.
    #[inline]
    pub fn of(&self, ball: usize) -> &Next {
        &self.coming[ball].next
    }

    /// When surely no ball touches this one on its present arc but the one of its next event.
    #[inline]
    pub fn alone(&self, ball: usize) -> Clearance {
        self.coming[ball].alone
    }

    /// Sets [`Self::alone`], of which nothing is known when another event is set.
    #[inline]
    pub fn set_alone(&mut self, ball: usize, alone: Clearance) {
        self.coming[ball].alone = alone;
    }

    /// Sets what comes next for a ball.
    pub fn set(&mut self, ball: usize, next: Next) {
        self.coming[ball] = Coming { next, alone: Clearance::UNKNOWN };
        let mut place = ball;
        let mut entry = Entry { rounded: next.time.rounded_down(), ball: ball as u32 };
        for round in 0..self.rounds.len() {
            let four = &mut self.matches[self.rounds[round] + place / FOUR].0;
            let before = std::mem::replace(&mut four[place % FOUR], entry);
            // Where another won and wins again, nothing changes farther up.
            if before.ball == entry.ball && entry.ball != ball as u32 {
                return;
            }
            let four = *four;
            entry = self.first_of(&four);
            place /= FOUR;
        }
        self.winner = entry;
    }

    /// The ball whose event is first, and the event.
    #[inline]
    pub fn first(&self) -> (usize, &Next) {
        let ball = self.winner.ball as usize;
        (ball, &self.coming[ball].next)
    }

    /// The winner of a match. Which one it is cannot be foretold, so nothing is jumped over.
    #[inline]
    fn first_of(&self, four: &[Entry; FOUR]) -> Entry {
        let of = |place: usize| four[place].rounded;
        let low = usize::from(of(1) < of(0));
        let high = 2 + usize::from(of(3) < of(2));
        let first = if of(high) < of(low) { high } else { low };
        let least = of(first);
        let alike: usize = four.iter().map(|entry| usize::from(entry.rounded == least)).sum();
        if alike > 1 { self.first_of_alike(four, least) } else { four[first] }
    }

    /// The first of those of one rounded time, by everything that counts.
    #[cold]
    fn first_of_alike(&self, four: &[Entry; FOUR], rounded: u64) -> Entry {
        let key = |entry: &&Entry| self.coming.get(entry.ball as usize).map(|c| c.next.key(entry.ball));
        let alike = four.iter().filter(|entry| entry.rounded == rounded && entry.ball != u32::MAX);
        *alike.min_by_key(key).unwrap_or(&four[0])
    }
}

#[cfg(test)]
mod tests {
    use super::super::event::What;
    use super::super::time::Time;
    use super::*;

    #[test]
    fn the_queue_agrees_with_a_search() {
        let n = 37;
        let mut queue = Queue::new(n);
        let mut plain = vec![Next::NEVER; n];
        let mut seed = 3_u64;
        for round in 0..2000_u32 {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let ball = (seed >> 33) as usize % n;
            // Few distinct times, so that ties are common.
            let time = Time::of_seconds(((seed >> 20) % 5) as f64);
            let what = match round % 3 {
                0 => What::Renew,
                1 => What::Wall { wall: round % 4 },
                _ => What::Ball { other: (seed >> 40) as u32 % n as u32, stamp: 0 },
            };
            plain[ball] = Next { time, what };
            queue.set(ball, plain[ball]);
            let want = (0..n).min_by_key(|i| (plain[*i].key(*i as u32), *i)).expect("balls");
            assert_eq!(queue.first().1.key(queue.first().0 as u32), plain[want].key(want as u32));
        }
    }
}
