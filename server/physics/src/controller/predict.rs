//! What a ball will meet within its window: walls, other balls, or only the window's end.

use super::Controller;
use crate::detect::ball_ball::{self, Standing, surely_apart};
use crate::detect::ball_wall;
use crate::detect::broad_phase::{swept_bounds, travel};
use crate::schedule::event::{Next, What};
use crate::schedule::time::{QUANTUM, Time};
use crate::tolerance::{WINDOW_MAX, WINDOW_MIN};

impl Controller {
    /// Opens a window for `ball` from `now` on and finds what comes first in it. The present is the caller's event: what
    /// happens to others meanwhile, far away, cannot touch it.
    pub(super) fn predict(&mut self, ball: usize, now: Time) {
        self.will_change(ball);
        self.report.searches += 1;
        let from = now.max(self.arcs[ball].start);
        self.open_window(ball, from);
        let arc = &self.arcs[ball];
        let id = ball as u32;
        let mut best = Next { time: arc.window_end, what: What::Renew };
        let duration = arc.window_end.since(from);
        let standing = Standing::of(arc, from);
        for (wall, plane) in self.walls.iter().enumerate() {
            if let Some(t) = ball_wall::time_of_impact((arc, &standing), plane, from, duration, arc.radius) {
                let next = Next { time: from.after(t), what: What::Wall { wall: wall as u32 } };
                if next.key(id) < best.key(id) {
                    best = next;
                }
            }
        }
        let bounds =
            swept_bounds(&standing.center, &standing.velocity, arc.acceleration_bound, arc.radius, duration);
        self.broad_phase.file(ball, bounds);
        let Self { broad_phase, arcs, queue, report, work, .. } = self;
        let arc = &arcs[ball];
        broad_phase.neighbours(ball, |other| {
            report.pairs[0] += 1;
            let theirs = &arcs[other];
            let begin = from.max(theirs.start);
            let duration = arc.window_end.min(theirs.window_end).since(begin);
            if duration <= 0.0 {
                return;
            }
            let reach = arc.radius + theirs.radius;
            let here = if begin == from { standing } else { Standing::of(arc, begin) };
            let there = Standing::of(theirs, begin);
            let acceleration = arc.acceleration_bound + theirs.acceleration_bound;
            if surely_apart(&here, &there, acceleration, reach, duration) {
                return;
            }
            report.pairs[1] += 1;
            let hit = ball_ball::time_of_impact((arc, theirs), (&here, &there), begin, duration, reach);
            let Some(t) = hit else { return };
            let time = begin.after(t);
            let mine = Next { time, what: What::Ball { other: other as u32, stamp: theirs.stamp } };
            if mine.key(id) < best.key(id) {
                best = mine;
            }
            let theirs = Next { time, what: What::Ball { other: id, stamp: arc.stamp } };
            if theirs.key(other as u32) < queue.of(other).key(other as u32) {
                work.theirs.push((other, theirs));
            }
        });
        self.queue.set(ball, best);
        self.reads_neighbours(ball);
        self.has_changed(ball);
        while let Some((other, theirs)) = self.work.theirs.pop() {
            self.will_change(other);
            self.queue.set(other, theirs);
            self.has_changed(other);
        }
        self.line_up(ball);
    }

    /// A window ends with the arc, before the ball has travelled far, and for a driven ball with the quantum.
    /// Its length is a power of two of seconds and depends on the ball and the floor alone: a ball that nobody meets
    /// cannot change another's.
    fn open_window(&mut self, ball: usize, from: Time) {
        let driven = self.balls[ball].drive.is_some();
        let arc = &mut self.arcs[ball];
        let speed = arc.velocity_at(from.since(arc.start)).norm();
        let travel = travel(arc.radius, self.span);
        let mut length = WINDOW_MAX;
        while length > WINDOW_MIN && length * (speed + 0.5 * arc.acceleration_bound * length) > travel {
            length *= 0.5;
        }
        arc.window_end = from.after(length).min(arc.finish());
        if driven {
            let quantum = Time::of_quantum(from.after(0.0).quantum()).after(QUANTUM);
            arc.window_end = arc.window_end.min(quantum);
        }
    }
}
