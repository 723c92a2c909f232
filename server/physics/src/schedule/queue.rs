//! The first of all next events: a tournament with one leaf a ball. It never allocates after it is made.
//!
//! Four meet in a match, which fills one line of cache, and nearly all matches are decided by rounded times that are
//! compared as integers.

use super::clearance::Clearance;
use super::event::Next;
use super::time::Time;
use prefetch_index::prefetch_index;

/// Entries of a match.
const FOUR: usize = 4;

/// Rounds that [`Queue::between`] leaves: 64 to 256 take part in the first of them.
const LAST_ROUNDS: usize = 4;

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

/// Who meets: where there is no ball, a time after all times, and no two of them alike.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Match {
    rounded: [u64; FOUR],
    balls: [u32; FOUR],
}

impl Match {
    fn of(some: &[Entry]) -> Self {
        let mut all =
            Self { rounded: std::array::from_fn(|place| u64::MAX - place as u64), balls: [u32::MAX; FOUR] };
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

    /// Asks memory for what comes for a ball, and for its first matches.
    #[inline]
    pub fn prefetch(&self, ball: usize) {
        prefetch_index(&self.coming, ball);
        prefetch_index(&self.matches, ball / FOUR);
        if let Some(round) = self.rounds.get(1) {
            prefetch_index(&self.matches, round + ball / (FOUR * FOUR));
        }
    }

    /// Those who may be next when the first has had its turn: who met in the last match. Some may be nobody.
    #[inline]
    pub fn finalists(&self) -> [u32; FOUR] {
        self.matches.last().map_or([u32::MAX; FOUR], |all| all.balls)
    }

    /// Visits those whose events come after one time and up to another, both rounded down, but for who is beaten by one of
    /// them before the last rounds: of a few events among many balls nearly all.
    pub fn between(&self, after: u64, until: u64, mut visit: impl FnMut(usize)) {
        let round = self.rounds.len().saturating_sub(LAST_ROUNDS);
        let end = self.rounds.get(round + 1).copied().unwrap_or(self.matches.len());
        for all in &self.matches[self.rounds[round]..end] {
            for (rounded, ball) in all.rounded.iter().zip(&all.balls) {
                if after < *rounded && *rounded <= until && *ball != u32::MAX {
                    visit(*ball as usize);
                }
            }
        }
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
    use super::super::time::{QUANTUM, Time};
    use super::*;
    use std::collections::BTreeSet;

    /// Numbers from a seed (Marsaglia's xorshift).
    struct Random(u64);

    impl Random {
        fn below(&mut self, count: usize) -> usize {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            ((self.0 >> 33) % count as u64) as usize
        }

        /// Few quanta and few offsets, down to neighbouring numbers, so that ties are common and near ties too; sometimes never.
        fn time(&mut self) -> Time {
            if self.below(8) == 0 {
                return Time::NEVER;
            }
            let offset = match self.below(6) {
                0 => 0.0,
                1 => f64::MIN_POSITIVE,
                2 => 0.5 * QUANTUM,
                3 => (0.5 * QUANTUM).next_up(),
                4 => QUANTUM.next_down(),
                _ => self.below(1 << 20) as f64 * (QUANTUM / f64::from(1 << 20)),
            };
            Time::of_parts(self.below(4).cast_signed() as i64 - 1, offset)
                .expect("an offset below the quantum")
        }

        fn next(&mut self, balls: usize) -> Next {
            let time = self.time();
            let what = match self.below(3) {
                0 => What::Renew,
                1 => What::Wall { wall: self.below(4) as u32 },
                _ => What::Ball { other: self.below(balls) as u32, stamp: self.below(1 << 31) as u32 },
            };
            Next { time, what }
        }
    }

    type Key = (Time, u8, u32, u32);

    /// The slow reference: every ball's key in one ordered set. Two balls that meet each other have one key.
    struct Plain {
        next: Vec<Next>,
        keys: BTreeSet<(Key, u32)>,
    }

    impl Plain {
        fn new(balls: usize) -> Self {
            let next = vec![Next::NEVER; balls];
            let keys = (0..).zip(&next).map(|(ball, next)| (next.key(ball), ball)).collect();
            Self { next, keys }
        }

        fn set(&mut self, ball: usize, next: Next) {
            let id = ball as u32;
            self.keys.remove(&(self.next[ball].key(id), id));
            self.keys.insert((next.key(id), id));
            self.next[ball] = next;
        }

        fn first(&self) -> Key {
            self.keys.first().expect("a ball").0
        }
    }

    fn assert_same(queue: &Queue, plain: &Plain) {
        let (ball, first) = queue.first();
        assert!(ball < plain.next.len(), "ball {ball} of {}", plain.next.len());
        assert_eq!(*first, plain.next[ball]);
        assert_eq!(first.key(ball as u32), plain.first(), "of {} balls", plain.next.len());
    }

    const SIZES: [usize; 8] = [1, 2, 3, 37, 64, 65, 1_000, 100_000];

    #[test]
    fn the_queue_agrees_with_an_ordered_set_at_every_size() {
        for balls in SIZES {
            let (mut queue, mut plain) = (Queue::new(balls), Plain::new(balls));
            let mut random = Random(balls as u64 + 3);
            assert_same(&queue, &plain);
            for _ in 0..20_000_usize.max(3 * balls) {
                let ball = random.below(balls);
                let next = random.next(balls);
                plain.set(ball, next);
                queue.set(ball, next);
                assert_eq!(*queue.of(ball), next);
                assert_same(&queue, &plain);
            }
        }
    }

    #[test]
    fn who_comes_within_a_short_time_is_mostly_found() {
        for balls in SIZES {
            let mut queue = Queue::new(balls);
            let mut random = Random(balls as u64 + 7);
            let mut times: Vec<u64> = Vec::new();
            for ball in 0..balls {
                let time = Time::ZERO.after(random.below(1 << 30) as f64 / f64::from(1 << 30));
                queue.set(ball, Next { time, what: What::Renew });
                times.push(time.rounded_down());
            }
            let mut sorted = times.clone();
            sorted.sort_unstable();
            let (after, until) = (sorted[balls.min(6) - 1], sorted[balls.min(12) - 1]);
            let mut found = Vec::new();
            queue.between(after, until, |ball| found.push(ball));
            assert!(found.iter().all(|ball| after < times[*ball] && times[*ball] <= until), "of {balls}");
            let there = times.iter().filter(|time| after < **time && **time <= until).count();
            assert!(found.len() <= there && 2 * found.len() >= there, "{} of {there}", found.len());
        }
    }

    /// As an engine uses it: who is first is set to something later, again and again, until nothing comes any more.
    #[test]
    fn what_is_taken_out_comes_in_order_until_nothing_is_left() {
        for balls in SIZES {
            let (mut queue, mut plain) = (Queue::new(balls), Plain::new(balls));
            let mut random = Random(balls as u64 + 5);
            for ball in 0..balls {
                let next = random.next(balls);
                plain.set(ball, next);
                queue.set(ball, next);
            }
            let mut before = None;
            loop {
                assert_same(&queue, &plain);
                let (ball, first) = queue.first();
                let key = first.key(ball as u32);
                if key.0 == Time::NEVER {
                    break;
                }
                assert!(before <= Some(key), "{before:?} came before {key:?}");
                before = Some(key);
                plain.set(ball, Next::NEVER);
                queue.set(ball, Next::NEVER);
            }
            assert!(before.is_some() || balls < 64, "{balls} balls had nothing coming");
        }
    }
}
