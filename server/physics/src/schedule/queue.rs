//! The first of all next events: a tournament tree with one leaf a ball. It never allocates after it is made.

use super::event::Next;

/// A tournament over the balls' next events.
#[derive(Clone, Debug)]
pub struct Queue {
    next: Vec<Next>,
    /// Winner of the subtree at each node, by ball; leaves are implied.
    winner: Vec<u32>,
    leaves: usize,
}

impl Queue {
    /// A queue for `balls` balls, none of which has anything coming.
    pub fn new(balls: usize) -> Self {
        let leaves = balls.next_power_of_two().max(2);
        let mut queue = Self { next: vec![Next::NEVER; leaves], winner: vec![0; leaves], leaves };
        for node in (1..leaves).rev() {
            queue.replay(node);
        }
        queue
    }

    /// What comes next for a ball.
    #[inline]
    pub fn of(&self, ball: usize) -> &Next {
        &self.next[ball]
    }

    /// Sets what comes next for a ball.
    pub fn set(&mut self, ball: usize, next: Next) {
        self.next[ball] = next;
        let mut node = (self.leaves + ball) >> 1;
        while node > 0 {
            self.replay(node);
            node >>= 1;
        }
    }

    /// The ball whose event is first, and the event.
    #[inline]
    pub fn first(&self) -> (usize, &Next) {
        let ball = self.winner[1] as usize;
        (ball, &self.next[ball])
    }

    fn replay(&mut self, node: usize) {
        let of = |child: usize| {
            if child >= self.leaves { (child - self.leaves) as u32 } else { self.winner[child] }
        };
        let (a, b) = (of(2 * node), of(2 * node + 1));
        let a_first = self.next[a as usize].key(a) <= self.next[b as usize].key(b);
        self.winner[node] = if a_first { a } else { b };
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
