//! The first of all next events: a tournament of four at a time with one leaf a ball. It never allocates after it is made.

use super::event::Next;
use super::time::Time;

/// Players of a match: their times fill a line of cache.
const MATCH: usize = 4;

/// A tournament over the balls' next events.
#[derive(Clone, Debug)]
pub struct Queue {
    next: Vec<Next>,
    /// Round after round, the leaves first: who meets in a match lies side by side, and its winner plays in the next round.
    players: Vec<Player>,
    /// Where each round begins; the last has one player.
    rounds: Vec<usize>,
}

/// A ball and the rank of its next event: a number that never falls as time grows, and decides nearly all matches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Player {
    rank: u64,
    ball: u32,
}

impl Player {
    const NOBODY: Self = Self { rank: u64::MAX, ball: u32::MAX };
}

/// 2^-36 s of the first eight years.
const fn rank(time: Time) -> u64 {
    const QUANTUM_BITS: u32 = 34;
    const REST_BITS: u32 = 64 - QUANTUM_BITS;
    const LAST: i64 = (1 << QUANTUM_BITS) - 1;
    let quantum = if time.quantum() < 0 {
        0
    } else if time.quantum() > LAST {
        LAST
    } else {
        time.quantum()
    };
    // A quantum is 2^-6 s.
    let rest = (time.offset() * (1_u64 << (REST_BITS + 6)) as f64) as u64;
    ((quantum as u64) << REST_BITS) | rest
}

impl Queue {
    /// A queue for `balls` balls, none of which has anything coming.
    pub fn new(balls: usize) -> Self {
        let (mut rounds, mut start, mut length) = (vec![0], 0, balls.max(1));
        while length > 1 {
            start += length.next_multiple_of(MATCH);
            rounds.push(start);
            length = length.div_ceil(MATCH);
        }
        let mut players = vec![Player::NOBODY; start + 1];
        for (ball, player) in players.iter_mut().enumerate().take(balls) {
            *player = Player { rank: rank(Time::NEVER), ball: ball as u32 };
        }
        let mut queue = Self { next: vec![Next::NEVER; balls], players, rounds };
        for ball in 0..balls {
            queue.set(ball, Next::NEVER);
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
        let mut place = ball;
        self.players[place].rank = rank(next.time);
        for round in 1..self.rounds.len() {
            let winner = self.winner(self.rounds[round - 1] + place / MATCH * MATCH);
            place /= MATCH;
            let before = &mut self.players[self.rounds[round] + place];
            // Where another one won and wins again, nothing changes farther up.
            if before.ball != ball as u32 && *before == winner {
                break;
            }
            *before = winner;
        }
    }

    /// The ball whose event is first, and the event. A queue of no balls never has one.
    #[inline]
    pub fn first(&self) -> (usize, &Next) {
        let ball = self.players.last().map_or(0, |first| first.ball as usize);
        self.next.get(ball).map_or((0, &Next::NEVER), |next| (ball, next))
    }

    /// Who wins the match whose players begin at `first`.
    #[inline]
    fn winner(&self, first: usize) -> Player {
        let Some(&[a, b, c, d]) = self.players[first..].first_chunk::<MATCH>() else { return Player::NOBODY };
        let better = |a: Player, b: Player| {
            if b.rank < a.rank || (b.rank == a.rank && self.is_first(b, a)) { b } else { a }
        };
        better(better(a, b), better(c, d))
    }

    /// Decides between players of one rank.
    fn is_first(&self, a: Player, b: Player) -> bool {
        // Both of a pair may have the same event coming.
        let key = |p: Player| Some((self.next.get(p.ball as usize)?.key(p.ball), p.ball));
        match (key(a), key(b)) {
            (Some(a), Some(b)) => a < b,
            (here, _) => here.is_some(),
        }
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
