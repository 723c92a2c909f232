//! Memory asked for ahead of its use.
//!
//! Thousands of balls have no room in the processor's nearest memory, and an event waits for its ball, then for the cells
//! around it, then for who is in them, one after another. So those who met in the queue's last match are asked for before the
//! event at hand, whom a search finds are all asked for before the first is looked at, and hits that are landed on together
//! have their arcs asked for at once. Beyond some ten thousand balls that comes too late: the queue tells who is next but a few
//! events, and what these will read is asked for in three steps, each two events after the one before. Nothing is read into a
//! result: a wrong guess costs time only.

use super::Controller;
use super::approach::Due;
use crate::detect::broad_phase::Bounds;
use crate::motion::arc::Arc;
use crate::motion::step::TERMS;
use crate::schedule::event::What;
use crate::schedule::time::Time;
use prefetch_index::prefetch_index;

/// Balls from which on it pays: less stays in the processor's own memory.
const BALLS_MIN: usize = 2048;
/// Balls from which on it pays to look events ahead.
const BALLS_FAR: usize = 16_384;
/// Events from one look at the queue to the next.
const EVENTS: u32 = 6;
/// Most balls looked after at once: some are found beyond the expected [`EVENTS`].
const MOST: usize = 4 * EVENTS as usize;

/// Whose memory is being asked for.
#[derive(Clone, Debug)]
pub(super) struct Fetch {
    pays: bool,
    pays_far: bool,
    /// Events since the last look at the queue, and when that was.
    events: u32,
    looked: u64,
    balls: [u32; MOST],
    /// Where each ball will search, about.
    bounds: [Bounds; MOST],
    count: usize,
}

impl Fetch {
    /// For so many balls.
    pub(super) const fn new(balls: usize) -> Self {
        let (pays, pays_far) = (balls >= BALLS_MIN, balls >= BALLS_FAR);
        Self { pays, pays_far, events: 0, looked: 0, balls: [0; MOST], bounds: [[0.0; 4]; MOST], count: 0 }
    }

    /// Whether it pays at all.
    pub(super) const fn pays(&self) -> bool {
        self.pays
    }
}

impl Controller {
    /// The event of `ball` begins: asks for what later ones will read.
    #[inline(never)]
    pub(super) fn fetch_ahead(&mut self, ball: usize, now: Time) {
        for other in self.queue.finalists() {
            let other = other as usize;
            if other != ball && other < self.balls.len() {
                self.fetch_ball(other);
            }
        }
        if self.work.fetch.pays_far {
            self.fetch_far_ahead(now);
        }
    }

    /// Asks for what is read of those who may hit soon.
    pub(super) fn fetch_candidates(&self) {
        if self.work.fetch.pays {
            self.work.foresight.calendar.ahead(|ball| {
                self.fetch_ball(ball);
                prefetch_index(self.arcs[ball].state.as_slice(), 0);
                true
            });
        }
    }

    /// Asks for the rest of the arcs of those who hit.
    pub(super) fn fetch_rest_of(&self, hits: &[Due]) {
        if self.work.fetch.pays {
            for landed in hits.iter().flat_map(Due::landed) {
                prefetch_rest(&self.arcs[landed.ball], self.surface.is_flat());
            }
        }
    }

    fn fetch_far_ahead(&mut self, now: Time) {
        let event = self.work.fetch.events;
        self.work.fetch.events = (event + 1) % EVENTS;
        match event {
            0 => self.fetch_balls(now.rounded_down()),
            2 => self.fetch_cells(),
            4 => self.fetch_neighbours(),
            _ => {}
        }
    }

    /// Chooses those whose turn comes after the next [`EVENTS`], which take about as long as the last, and asks for what is
    /// kept of each.
    fn fetch_balls(&mut self, now: u64) {
        let Self { queue, work, .. } = self;
        let fetch = &mut work.fetch;
        let lasted = now.saturating_sub(std::mem::replace(&mut fetch.looked, now));
        let from = now.saturating_add(lasted);
        fetch.count = 0;
        queue.between(from, from.saturating_add(lasted), |ball| {
            if fetch.count < MOST {
                fetch.balls[fetch.count] = ball as u32;
                fetch.count += 1;
            }
        });
        for ball in &self.work.fetch.balls[..self.work.fetch.count] {
            self.fetch_ball(*ball as usize);
        }
    }

    /// Asks for what every event of a ball reads of it.
    fn fetch_ball(&self, ball: usize) {
        self.queue.prefetch(ball);
        self.broad_phase.prefetch(ball);
        prefetch_index(&self.balls, ball);
        prefetch_front(&self.arcs[ball], self.surface.is_flat());
    }

    /// Asks for the cells in which each will search, for whom it will hit, and for the rest of the arcs of those who hit.
    fn fetch_cells(&mut self) {
        let is_flat = self.surface.is_flat();
        for place in 0..self.work.fetch.count {
            let ball = self.work.fetch.balls[place] as usize;
            let mut bounds = *self.broad_phase.bounds_of(ball);
            match self.queue.of(ball).what {
                What::Ball { other, .. } => {
                    self.fetch_ball(other as usize);
                    prefetch_rest(&self.arcs[ball], is_flat);
                    prefetch_rest(&self.arcs[other as usize], is_flat);
                }
                What::Wall { .. } => prefetch_rest(&self.arcs[ball], is_flat),
                What::Renew => move_on(&mut bounds, &self.arcs[ball]),
            }
            self.broad_phase.prefetch_cells(ball, &bounds);
            self.work.fetch.bounds[place] = bounds;
        }
    }

    /// Asks for whom each may meet.
    fn fetch_neighbours(&self) {
        let fetch = &self.work.fetch;
        for (ball, bounds) in fetch.balls[..fetch.count].iter().zip(&fetch.bounds) {
            self.broad_phase.prefetch_firsts(*ball as usize, bounds);
        }
    }
}

/// Moves the bounds of a window to where those of the next will be, about.
fn move_on(bounds: &mut Bounds, arc: &Arc) {
    for axis in 0..2 {
        let far = bounds[axis + 2] - bounds[axis] - 2.0 * arc.radius;
        let far = far.copysign(arc.center[1][axis]);
        bounds[axis] += far;
        bounds[axis + 2] += far;
    }
}

/// What a search asks of an arc, line by line of cache.
#[inline]
pub(super) fn prefetch_front(arc: &Arc, is_flat: bool) {
    prefetch_index(std::slice::from_ref(arc), 0);
    prefetch_index(arc.center.as_slice(), 1);
    if !is_flat {
        prefetch_index(arc.center.as_slice(), 4);
        prefetch_index(arc.center.as_slice(), 6);
    }
}

/// The rest, which a hit reads and writes.
#[inline]
fn prefetch_rest(arc: &Arc, is_flat: bool) {
    prefetch_index(arc.state.as_slice(), 0);
    if !is_flat {
        for term in 0..TERMS {
            prefetch_index(arc.dense.as_slice(), term);
        }
        prefetch_index(arc.end.as_slice(), 0);
        prefetch_index(arc.turning.turn.as_slice(), 0);
    }
}

#[cfg(test)]
mod tests {
    use super::super::foresee::tests::crowd;
    use super::*;

    #[test]
    fn asking_for_memory_changes_no_bit() {
        let mut without = Controller::new(&crowd(9)).expect("a scene");
        let mut with = without.clone();
        assert!(!without.work.fetch.pays);
        (with.work.fetch.pays, with.work.fetch.pays_far) = (true, true);
        let mut asked = 0;
        for tick in 1..=120 {
            let time = Time::of_tick(tick, 60);
            with.advance_to(time);
            without.advance_to(time);
            assert_eq!(with.state_hash(), without.state_hash(), "tick {tick}");
            asked += with.work.fetch.count;
        }
        assert!(asked > 120, "{asked}");
    }
}
