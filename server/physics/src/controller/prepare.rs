//! Arcs computed ahead of their time, so that several balls' steps are computed side by side.
//!
//! What follows an arc that ends by itself is a function of its end, of the step tried next and of the force: computed
//! early, it has the same bits. Balls whose arc ends within the window that they look ahead, with nothing met before, wait
//! in a line; when one of them needs its next arc, the foremost are launched with it. What was prepared is used if the ball
//! comes to that very end, and is forgotten if not.

use super::Controller;
use super::foresee::Origin;
use crate::lanes::LANES_MAX;
use crate::motion::arc::{Arc, Path};
use crate::motion::body::{Body, Stepping};
use crate::motion::follow::orientations;
use crate::motion::law::State;
use crate::motion::together::{self, Launch};
use crate::schedule::event::What;
use crate::schedule::time::Time;
use nalgebra::Vector3;
use std::collections::VecDeque;

/// Balls for each arc that may be kept prepared: memory.
const BALLS_PER_SLOT: usize = 8;
/// Most arcs kept prepared: a megabyte for all, which stays near the processor.
const SLOTS_MAX: usize = 256;
/// Balls looked at in the line for one group.
const LOOKED_AT: usize = 16;

/// A ball's next arc.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prepared {
    pub(super) ball: usize,
    /// Step tried first, s, and force: what the arc follows from, beside where it begins.
    tried: f64,
    applied: Vector3<f64>,
    stepping: Stepping,
    arc: Arc,
    /// What the arc before it follows from, and the orientation at that one's end.
    turned: Option<(Origin, [f64; 4])>,
}

impl Prepared {
    /// Nobody's.
    pub(super) const NOTHING: Self = Self {
        ball: usize::MAX,
        tried: 0.0,
        applied: Vector3::new(0.0, 0.0, 0.0),
        stepping: Stepping { try_s: 0.0, steps: 0, forced: 0 },
        arc: Arc::empty(0.0),
        turned: None,
    };
}

/// What is prepared, and who may be next.
#[derive(Clone, Debug)]
pub(super) struct Ahead {
    line: VecDeque<u32>,
    /// A ball's place is its number modulo the length.
    slots: Vec<Option<Prepared>>,
    group: Vec<Prepared>,
    /// Arcs computed at once.
    width: usize,
}

impl Ahead {
    /// For so many balls, `width` of which are launched at once.
    pub(super) fn new(balls: usize, width: usize) -> Self {
        let slots = if width > 1 { (balls / BALLS_PER_SLOT).min(SLOTS_MAX) } else { 0 };
        let line = if slots > 0 { VecDeque::with_capacity(2 * SLOTS_MAX) } else { VecDeque::new() };
        Self { line, slots: vec![None; slots], group: Vec::with_capacity(width), width }
    }

    /// Whether anything is ever prepared.
    const fn is_idle(&self) -> bool {
        self.slots.is_empty()
    }

    fn slot(&mut self, ball: usize) -> &mut Option<Prepared> {
        let place = ball % self.slots.len();
        &mut self.slots[place]
    }
}

impl Controller {
    /// Lines up a ball whose present arc ends within its window with nothing met before, and notes a hit.
    #[inline]
    pub(super) fn line_up(&mut self, ball: usize) {
        if self.work.side_by_side {
            self.line_up_with_others(ball);
        }
    }

    #[inline(never)]
    fn line_up_with_others(&mut self, ball: usize) {
        let next = self.queue.of(ball);
        if next.what != What::Renew {
            self.work.foresight.note(ball, next.time);
        } else if !self.work.ahead.is_idle() && self.ends_by_itself(ball) {
            let line = &mut self.work.ahead.line;
            if line.len() == line.capacity() {
                line.pop_front();
            }
            line.push_back(ball as u32);
        }
    }

    fn ends_by_itself(&self, ball: usize) -> bool {
        let (arc, next) = (&self.arcs[ball], self.queue.of(ball));
        arc.path == Path::Curved && !arc.driven && next.what == What::Renew && next.time == arc.finish()
    }

    /// Puts a ball on the arc that follows its present one, which ends at `time` in `state` and has been closed.
    pub(super) fn go_on(&mut self, ball: usize, time: Time, state: &State) {
        if self.work.ahead.is_idle() || self.arcs[ball].driven {
            self.launch(ball, time, state);
            return;
        }
        let prepared = self.work.ahead.slot(ball).take();
        match prepared {
            Some(next) if self.follows(&next, ball, time, state) => self.put_on(&next),
            other => {
                if other.as_ref().is_some_and(|other| other.ball != ball) {
                    *self.work.ahead.slot(ball) = other;
                }
                self.launch_group(ball, time, state);
            }
        }
    }

    /// Whether an arc is what follows from `state` at `time`.
    pub(super) fn follows(&self, next: &Prepared, ball: usize, time: Time, state: &State) -> bool {
        let b = &self.balls[ball];
        next.ball == ball
            && (next.arc.start, next.arc.state) == (time, *state)
            && (next.tried, next.applied) == (b.stepping.try_s, b.body.applied)
    }

    /// Launches a ball together with others that will need their next arc soon.
    fn launch_group(&mut self, ball: usize, time: Time, state: &State) {
        let mut group = std::mem::take(&mut self.work.ahead.group);
        group.clear();
        group.push(self.blank(ball, time, state));
        let looked_at = LOOKED_AT.min(self.work.ahead.line.len());
        for _ in 0..looked_at {
            if group.len() == self.work.ahead.width {
                break;
            }
            let Some(other) = self.work.ahead.line.pop_front() else { break };
            let other = other as usize;
            if !self.ends_by_itself(other) || group.iter().any(|known| known.ball == other) {
                continue;
            }
            let (finish, end) = (self.arcs[other].finish(), self.arcs[other].end);
            // A place is free when what it holds was not used in time.
            let kept = self.work.ahead.slot(other).as_ref();
            let known = |kept: &Prepared| kept.ball == other && kept.arc.state == end;
            if kept.is_some_and(|kept| known(kept) || (kept.ball != other && kept.arc.start >= time)) {
                continue;
            }
            group.push(self.blank(other, finish, &end));
        }
        if group.len() == 1 {
            self.launch(ball, time, state);
        } else {
            self.compute(group.iter_mut());
            // The first has left its arc already.
            self.turn_to_ends(&mut group[1..]);
            self.put_on(&group[0]);
            for next in group.drain(1..) {
                *self.work.ahead.slot(next.ball) = Some(next);
            }
        }
        self.work.ahead.group = group;
    }

    fn blank(&self, ball: usize, start: Time, state: &State) -> Prepared {
        let mut next = Prepared::NOTHING;
        self.note_start(&mut next, ball, start, state);
        next
    }

    /// What the next arc of a ball follows from; the arc itself is for [`Self::compute`].
    pub(super) fn note_start(&self, next: &mut Prepared, ball: usize, start: Time, state: &State) {
        let Body { radius, applied, .. } = self.balls[ball].body;
        let tried = self.balls[ball].stepping.try_s;
        (next.ball, next.tried, next.applied) = (ball, tried, applied);
        next.stepping = Stepping { try_s: tried, steps: 0, forced: 0 };
        (next.arc.start, next.arc.state, next.arc.radius) = (start, *state, radius);
    }

    /// Launches the first [`LANES_MAX`] of a group at once.
    pub(super) fn compute<'a>(&self, mut group: impl Iterator<Item = &'a mut Prepared>) {
        let mut wanted: [Option<Launch<'_>>; LANES_MAX] = std::array::from_fn(|_| {
            let Prepared { ball, stepping, arc, .. } = group.next()?;
            Some(Launch { body: &self.balls[*ball].body, stepping, arc })
        });
        together::launch(&self.surface, self.accuracy, &mut wanted);
    }

    /// Finds the orientations of rolling balls at the ends of their present arcs.
    fn turn_to_ends(&self, group: &mut [Prepared]) {
        if !self.balls[group[0].ball].body.rolls {
            return;
        }
        let mut courses = [None; LANES_MAX];
        for (course, next) in courses.iter_mut().zip(&*group) {
            let Arc { start, scale, turning, .. } = &self.arcs[next.ball];
            *course = Some((turning, next.arc.start.since(*start) / scale));
        }
        let (count, mut q) = (group.len(), [[0.0; 4]; LANES_MAX]);
        orientations(&courses[..count], &mut [], &mut q[..count]);
        for (next, q) in group.iter_mut().zip(q) {
            next.turned = Some((self.origin(next.ball), q));
        }
    }

    /// The orientation prepared for a ball at the end of its present arc.
    pub(super) fn prepared_orientation(&self, ball: usize, time: Time) -> Option<[f64; 4]> {
        let slots = &self.work.ahead.slots;
        let next = slots.get(ball.checked_rem(slots.len())?)?.as_ref()?;
        let (of, q) = next.turned.filter(|_| next.ball == ball && next.arc.start == time)?;
        (of == self.origin(ball)).then_some(q)
    }

    /// Puts a ball on a prepared arc, with its own orientation.
    pub(super) fn put_on(&mut self, next: &Prepared) {
        // Asked of the copy at hand: the ball's own may be far away.
        let is_sane = next.arc.is_sane();
        let arc = &mut self.arcs[next.ball];
        let was = (arc.stamp, arc.window_end, arc.turning.start);
        *arc = next.arc;
        (arc.stamp, arc.window_end) = (was.0, was.1);
        arc.turning.start = was.2;
        let stepping = &mut self.balls[next.ball].stepping;
        stepping.try_s = next.stepping.try_s;
        stepping.steps += next.stepping.steps;
        stepping.forced += next.stepping.forced;
        self.launched(next.ball, next.stepping.steps);
        if !is_sane {
            self.stand_still(next.ball, next.arc.start, &next.arc.state);
        }
    }
}
