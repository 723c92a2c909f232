//! The first of all next events: a tournament tree with one leaf a ball. It never allocates after it is made.

use super::event::Next;
use super::time::Time;

/// A tournament over the balls' next events.
#[derive(Clone, Debug)]
pub struct Queue {
    next: Vec<Next>,
    /// The winner of the subtree at each node, the root at 1, a ball's leaf at `leaves` + ball. Siblings lie side by
    /// side, so that a match reads one place of memory.
    nodes: Vec<Winner>,
    leaves: usize,
}

/// A ball and the time of its next event: nearly all matches are decided by time.
#[derive(Clone, Copy, Debug)]
struct Winner {
    time: Time,
    ball: u32,
}

impl Queue {
    /// A queue for `balls` balls, none of which has anything coming.
    pub fn new(balls: usize) -> Self {
        let leaves = balls.next_power_of_two().max(2);
        let mut nodes = vec![Winner { time: Time::NEVER, ball: 0 }; 2 * leaves];
        for (ball, leaf) in nodes[leaves..].iter_mut().enumerate() {
            leaf.ball = ball as u32;
        }
        for node in (1..leaves).rev() {
            nodes[node] = nodes[2 * node];
        }
        Self { next: vec![Next::NEVER; leaves], nodes, leaves }
    }

    /// What comes next for a ball.
    #[inline]
    pub fn of(&self, ball: usize) -> &Next {
        &self.next[ball]
    }

    /// Sets what comes next for a ball.
    pub fn set(&mut self, ball: usize, next: Next) {
        self.next[ball] = next;
        let mut node = self.leaves + ball;
        self.nodes[node].time = next.time;
        while node > 1 {
            node >>= 1;
            let (a, b) = (self.nodes[2 * node], self.nodes[2 * node + 1]);
            let winner = if self.is_first(a, b) { a } else { b };
            let before = self.nodes[node].ball;
            // Where another won and wins again, nothing changes farther up.
            if before != ball as u32 && winner.ball == before {
                break;
            }
            self.nodes[node] = winner;
        }
    }

    /// The ball whose event is first, and the event.
    #[inline]
    pub fn first(&self) -> (usize, &Next) {
        let ball = self.nodes[1].ball as usize;
        (ball, &self.next[ball])
    }

    #[inline]
    fn is_first(&self, a: Winner, b: Winner) -> bool {
        if a.time == b.time {
            return self.next[a.ball as usize].key(a.ball) <= self.next[b.ball as usize].key(b.ball);
        }
        a.time < b.time
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
            Time::of_parts([-1, 0, 1, 2][self.below(4)], offset).expect("an offset below the quantum")
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
