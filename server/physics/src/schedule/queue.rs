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

/// Who meets: where there is no ball, a time after all times.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Match {
    rounded: [u64; FOUR],
    balls: [u32; FOUR],
}

impl Match {
    fn of(some: &[Entry]) -> Self {
        let mut all = Self { rounded: [u64::MAX; FOUR], balls: [u32::MAX; FOUR] };
        for (place, entry) in some.iter().enumerate() {
            (all.rounded[place], all.balls[place]) = (entry.rounded, entry.ball);
        }
        all
    }
}

impl Queue {
    /// A queue for `balls` balls, none of which has anything coming.
    pub fn new(balls: usize) -> Self {
        let (mut matches, mut rounds) = (Vec::new(), Vec::new());
        let rounded = Time::NEVER.rounded_down();
        let mut entries: Vec<Entry> = (0..balls.max(1) as u32).map(|ball| Entry { rounded, ball }).collect();
        loop {
            rounds.push(matches.len());
            matches.extend(entries.chunks(FOUR).map(Match::of));
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
            let all = &mut self.matches[self.rounds[round] + place / FOUR];
            let before = all.balls[place % FOUR];
            all.rounded[place % FOUR] = entry.rounded;
            all.balls[place % FOUR] = entry.ball;
            // Where another won and wins again, nothing changes farther up.
            if before == entry.ball && entry.ball != ball as u32 {
                return;
            }
            entry = self.winner_of(self.rounds[round] + place / FOUR);
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
    fn winner_of(&self, place: usize) -> Entry {
        let all = &self.matches[place];
        let low = usize::from(self.is_before(all, 1, 0));
        let high = 2 + usize::from(self.is_before(all, 3, 2));
        let first = if self.is_before(all, high, low) { high } else { low };
        Entry { rounded: all.rounded[first], ball: all.balls[first] }
    }

    #[inline]
    fn is_before(&self, all: &Match, a: usize, b: usize) -> bool {
        if all.rounded[a] == all.rounded[b] {
            return self.is_just_before(all.balls[a], all.balls[b]);
        }
        all.rounded[a] < all.rounded[b]
    }

    /// By everything that counts; nobody is before nobody.
    #[inline(never)]
    fn is_just_before(&self, a: u32, b: u32) -> bool {
        let key = |ball: u32| self.coming.get(ball as usize).map(|coming| coming.next.key(ball));
        key(a) < key(b)
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
