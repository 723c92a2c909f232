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
