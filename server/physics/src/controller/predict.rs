//! What a ball will meet within its window: walls, other balls, or only the window's end.

use super::Controller;
use super::fetch::prefetch_front;
use crate::detect::ball_ball::{self, Approach, Standing, comes_briskly, parts_briskly};
use crate::detect::ball_wall;
use crate::detect::broad_phase::{is_within, swept_bounds, travel, window};
use crate::motion::arc::Arc;
use crate::schedule::clearance::Clearance;
use crate::schedule::event::{Next, What};
use crate::schedule::time::{QUANTUM, Time};
use crate::tolerance::ALONE_MARGIN;

/// What comes first for the ball that searches.
struct First {
    next: Next,
    /// When the one that it meets then is clear of it, and when all the others are that were looked at.
    partner: Clearance,
    others: Clearance,
}

impl First {
    /// Another ball is looked at, which may be the next one that ball `id` hits.
    fn take_in(&mut self, id: u32, found: &Encounter) {
        match found.hit {
            Some(next) if next.key(id) < self.next.key(id) => {
                self.others = self.others.and(self.partner);
                (self.next, self.partner) = (next, found.clear);
            }
            _ => self.others = self.others.and(found.clear),
        }
    }
}

/// What a search found of two balls that may touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Encounter {
    /// The one that was found.
    ball: usize,
    /// Their hit, for the one that searched.
    hit: Option<Next>,
    clear: Clearance,
}

impl Encounter {
    /// Of the arcs of two balls, the second `ball`, from `from` on while both look ahead, the first for `ahead` seconds;
    /// nothing if they surely stay clear of each other. `standing` is where the first is then.
    #[inline(always)]
    fn of<const PLANE: bool>(
        (arc, theirs): (&Arc, &Arc),
        ball: usize,
        (from, ahead, standing): (Time, f64, &Standing),
        searched: &mut u64,
    ) -> Option<Self> {
        let mut found = Self { ball, hit: None, clear: Clearance::UNKNOWN };
        let (mut begin, mut duration) = (from, ahead.min(theirs.window_end.since(from)));
        if theirs.start > from {
            begin = theirs.start;
            duration = arc.window_end.min(theirs.window_end).since(begin);
        }
        let reach = arc.radius + theirs.radius;
        if duration <= 0.0 {
            // They look again at once: the other, if its window ends by now, before anything later happens, and tells.
            if theirs.window_end <= from {
                let there = Standing::on::<PLANE>(theirs, from);
                if Approach::of(standing, &there, 0.0, reach, 0.0).stays_clear() {
                    return None;
                }
                found.clear = Clearance::after(from);
            }
            return Some(found);
        }
        let here = if begin == from { *standing } else { Standing::on::<PLANE>(arc, begin) };
        let there = Standing::on::<PLANE>(theirs, begin);
        let acceleration = arc.acceleration_bound + theirs.acceleration_bound;
        let approach = Approach::of(&here, &there, acceleration, reach, duration);
        if approach.stays_clear() {
            return None;
        }
        if !approach.stays_apart() {
            *searched += 1;
            found.look_closer::<PLANE>((arc, theirs), (&here, &there), (begin, duration));
        } else if parts_briskly(&here, &there, acceleration, duration) {
            found.clear = Clearance::after(begin.after(ALONE_MARGIN));
        }
        Some(found)
    }

    /// Whether and when they hit.
    #[inline(never)]
    fn look_closer<const PLANE: bool>(
        &mut self,
        (arc, theirs): (&Arc, &Arc),
        (here, there): (&Standing, &Standing),
        (begin, duration): (Time, f64),
    ) {
        let reach = arc.radius + theirs.radius;
        let acceleration = arc.acceleration_bound + theirs.acceleration_bound;
        let time_of_impact = if PLANE { ball_ball::time_on_plane } else { ball_ball::time_of_impact };
        let hit = time_of_impact((arc, theirs), (here, there), begin, duration, reach);
        if let Some(t) = hit {
            let time = begin.after(t);
            self.hit = Some(Next { time, what: What::Ball { other: self.ball as u32, stamp: theirs.stamp } });
            if comes_briskly(here, there, acceleration, reach, t) {
                self.clear = Clearance::before(time.after(-ALONE_MARGIN));
            }
        } else if parts_briskly(here, there, acceleration, duration) {
            self.clear = Clearance::after(begin.after(ALONE_MARGIN));
        }
    }
}

impl Controller {
    /// Opens a window for `ball` from `now` on and finds what comes first in it. The present is the caller's event: what
    /// happens to others meanwhile, far away, cannot touch it.
    #[inline]
    pub(super) fn predict(&mut self, ball: usize, now: Time) {
        if self.surface.is_flat() {
            self.predict_on::<true>(ball, now);
        } else {
            self.predict_on::<false>(ball, now);
        }
    }

    #[inline(never)]
    fn predict_on<const PLANE: bool>(&mut self, ball: usize, now: Time) {
        self.will_change(ball);
        self.report.searches += 1;
        let arc = &self.arcs[ball];
        let from = now.max(arc.start);
        let standing = Standing::on::<PLANE>(arc, from);
        self.open_window(ball, from, standing.velocity.norm());
        let arc = &self.arcs[ball];
        let (id, stamp) = (ball as u32, arc.stamp);
        let next = Next { time: arc.window_end, what: What::Renew };
        let mut first = First { next, partner: Clearance::ALWAYS, others: Clearance::ALWAYS };
        let duration = arc.window_end.since(from);
        let bounds =
            swept_bounds(&standing.center, &standing.velocity, arc.acceleration_bound, arc.radius, duration);
        if !is_within(&bounds, &self.room) {
            first.next = self.first_wall::<PLANE>(ball, (from, &standing), first.next);
        }
        self.broad_phase.file(ball, bounds);
        let has_others = self.balls.len() > 1;
        if has_others {
            self.look_around::<PLANE>(ball, (from, duration, &standing), &mut first);
        }
        self.queue.set(ball, first.next);
        self.queue.set_alone(ball, first.others);
        self.reads_neighbours(ball);
        self.has_changed(ball);
        if has_others {
            while let Some(found) = self.work.found.pop() {
                self.tell(&found, id, stamp);
            }
        }
        self.line_up(ball);
    }

    /// Takes in whom a ball may meet within its window, and keeps what was found of them to be told.
    #[inline(never)]
    fn look_around<const PLANE: bool>(
        &mut self,
        ball: usize,
        (from, ahead, standing): (Time, f64, &Standing),
        first: &mut First,
    ) {
        let Self { broad_phase, arcs, report, work, .. } = self;
        let arc = &arcs[ball];
        let fetches = work.fetch.pays();
        let ask = |other: usize| {
            if fetches {
                prefetch_front(&arcs[other], PLANE);
            }
        };
        broad_phase.neighbours_asked_for(ball, ask, |other| {
            report.pairs[0] += 1;
            let pair = (arc, &arcs[other]);
            if let Some(found) =
                Encounter::of::<PLANE>(pair, other, (from, ahead, standing), &mut report.pairs[1])
            {
                first.take_in(ball as u32, &found);
                // Who looks again before anything later happens need not be told.
                if pair.1.window_end > from {
                    work.found.push(found);
                }
            }
        });
    }

    /// The earlier of `next` and the first hit of a wall within the window.
    fn first_wall<const PLANE: bool>(
        &self,
        ball: usize,
        (from, standing): (Time, &Standing),
        mut next: Next,
    ) -> Next {
        let (arc, id) = (&self.arcs[ball], ball as u32);
        let duration = arc.window_end.since(from);
        for (wall, plane) in self.walls.iter().enumerate() {
            let t = if PLANE {
                ball_wall::time_on_plane((arc, standing), plane, duration, arc.radius)
            } else {
                ball_wall::time_of_impact((arc, standing), plane, from, duration, arc.radius)
            };
            if let Some(t) = t {
                let hit = Next { time: from.after(t), what: What::Wall { wall: wall as u32 } };
                if hit.key(id) < next.key(id) {
                    next = hit;
                }
            }
        }
        next
    }

    /// Tells another ball what the search of ball `id`, whose arc has `stamp`, found of the two.
    fn tell(&mut self, found: &Encounter, id: u32, stamp: u32) {
        let Encounter { ball, hit, clear, .. } = *found;
        let before = *self.queue.of(ball);
        let alone = self.queue.alone(ball);
        let Some(hit) = hit else { return self.queue.set_alone(ball, alone.and(clear)) };
        let next = Next { time: hit.time, what: What::Ball { other: id, stamp } };
        let known = next.what == before.what;
        if next.key(ball as u32) < before.key(ball as u32) {
            self.will_change(ball);
            // Only a ball can be in the way: whether a wall is, is looked at when the time comes.
            let partner = match before.what {
                What::Ball { .. } => Clearance::before(before.time.after(-ALONE_MARGIN)),
                What::Wall { .. } | What::Renew => Clearance::ALWAYS,
            };
            self.queue.set(ball, next);
            self.queue.set_alone(ball, if known { alone } else { alone.and(partner) });
            self.has_changed(ball);
        } else if !known {
            self.queue.set_alone(ball, alone.and(clear));
        }
    }

    /// A window ends with the arc, before the ball has travelled far, and for a driven ball with the quantum.
    /// Its length depends on the ball and the floor alone: a ball that nobody meets cannot change another's.
    fn open_window(&mut self, ball: usize, from: Time, speed: f64) {
        let arc = &mut self.arcs[ball];
        let length = window(travel(arc.radius, self.span), speed, arc.acceleration_bound);
        arc.window_end = from.after(length).min(arc.finish());
        if arc.driven {
            let quantum = Time::of_quantum(from.after(0.0).quantum()).after(QUANTUM);
            arc.window_end = arc.window_end.min(quantum);
        }
    }
}
