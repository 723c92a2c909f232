//! An advance: the first event of all, again and again, until the caller's time.

use super::approach::Due;
use super::{Controller, Shard};
use crate::diagnostics::{HitPartner, Report};
use crate::motion::arc::Path;
use crate::motion::law::State;
use crate::motion::together::{self, Launch};
use crate::schedule::event::{Next, What};
use crate::schedule::time::{QUANTUM, Time};

impl Controller {
    /// Advances to `time`: every hit up to and including it is resolved. Earlier times do nothing. Returns what
    /// happened; the hits themselves are in [`Self::hits`], the energy in [`Self::energy`].
    pub fn advance_to(&mut self, time: Time) -> Report {
        if self.shards.is_some() {
            let in_turn = &mut |shards: &mut Vec<Shard>, until| {
                for shard in shards {
                    shard.advance_to(until);
                }
            };
            return self.advance_divided(time, in_turn);
        }
        self.clear_hits();
        if time <= self.time {
            return Report::default();
        }
        self.time = time;
        if self.queue.first().1.time > time { self.report.of_nothing() } else { self.run_and_report(time) }
    }

    #[inline(never)]
    fn run_and_report(&mut self, time: Time) -> Report {
        let before = self.report;
        self.run_to(time);
        self.report.since(&before)
    }

    /// Every event up to and including `time`.
    pub(super) fn run_to(&mut self, time: Time) {
        if self.work.fetch.pays() { self.run::<true>(time) } else { self.run::<false>(time) }
    }

    fn run<const FETCH: bool>(&mut self, time: Time) {
        loop {
            let (ball, next) = self.queue.first();
            let next = *next;
            if next.time > time {
                self.close_instant();
                break;
            }
            self.open_instant(next.time);
            if FETCH {
                self.fetch_ahead(ball, next.time);
            }
            if self.is_shard() {
                self.take_in_shard(ball, &next);
                continue;
            }
            self.now = self.now.max(next.time);
            self.take(ball, &next);
        }
    }

    pub(super) fn take(&mut self, ball: usize, next: &Next) {
        match next.what {
            What::Ball { other, stamp } if self.arcs[other as usize].stamp == stamp => {
                self.collide(&mut Due::new(ball, HitPartner::Ball(other as usize), next.time));
            }
            // The other ball went elsewhere: search again.
            What::Ball { .. } => self.predict(ball, next.time),
            What::Wall { wall } => {
                self.collide(&mut Due::new(ball, HitPartner::Wall(wall as usize), next.time));
            }
            What::Renew => self.renew(ball, next.time),
        }
    }

    /// The window or the arc ends.
    fn renew(&mut self, ball: usize, time: Time) {
        if self.arcs[ball].driven && time.offset() == 0.0 && self.steer_anew(ball, time) {
            return;
        }
        let arc = &self.arcs[ball];
        if arc.finish() <= time {
            match arc.path {
                Path::Curved => {
                    let state = arc.end;
                    self.close_arc(ball, time);
                    self.go_on(ball, time, &state);
                }
                Path::Parabola | Path::Held => {
                    let dt = time.since(arc.start);
                    let state = arc.land(&self.balls[ball].body, &self.surface, self.accuracy, dt).0;
                    self.relaunch(ball, time, &state);
                }
            }
        }
        self.predict(ball, time);
    }

    /// Closes the present arc and puts a ball that was hit or pushed on a new one.
    pub(super) fn relaunch(&mut self, ball: usize, time: Time, state: &State) {
        self.leave(ball, time, state);
        self.launch(ball, time, state);
    }

    /// Closes the present arc of a ball that was hit or pushed, and finds the force on its new one.
    pub(super) fn leave(&mut self, ball: usize, time: Time, state: &State) {
        self.close_arc(ball, time);
        if self.balls[ball].drive.is_some() {
            // The speed limit asks for another force.
            self.balls[ball].body.applied = self.applied(ball, state, time);
        }
    }

    /// Takes stock of the present arc at its end, and keeps the orientation for the next.
    pub(super) fn close_arc(&mut self, ball: usize, time: Time) {
        self.will_change(ball);
        let work = self.work_of_force(ball, time);
        let arc = &self.arcs[ball];
        let dt = time.since(arc.start);
        let pulled = arc.negative_reaction(dt);
        if self.balls[ball].body.rolls {
            let foreseen =
                self.foreseen_orientation(ball, time).or_else(|| self.prepared_orientation(ball, time));
            self.arcs[ball].turning.start = foreseen.unwrap_or_else(|| self.arcs[ball].orientation_at(dt));
        }
        self.book(ball, work, pulled);
    }

    /// Puts a ball on a new arc, which keeps the orientation.
    pub(super) fn launch(&mut self, ball: usize, time: Time, state: &State) {
        let b = &mut self.balls[ball];
        let before = b.stepping.steps;
        b.body.launch(&self.surface, self.accuracy, (time, state), &mut b.stepping, &mut self.arcs[ball]);
        let steps = b.stepping.steps - before;
        self.set_out_on(ball, (time, state), steps);
    }

    /// Puts two balls on new arcs at once: the same arcs.
    pub(super) fn launch_pair(&mut self, time: Time, pair: [(usize, State); 2]) {
        let places = pair.map(|(ball, _)| ball);
        let (Ok(balls), Ok(arcs)) = (self.balls.get_disjoint_mut(places), self.arcs.get_disjoint_mut(places))
        else {
            return;
        };
        let ([a, b], [arc_a, arc_b]) = (balls, arcs);
        let before = [a.stepping.steps, b.stepping.steps];
        (arc_a.start, arc_a.state) = (time, pair[0].1);
        (arc_b.start, arc_b.state) = (time, pair[1].1);
        let launches = [
            Launch { body: &a.body, stepping: &mut a.stepping, arc: arc_a },
            Launch { body: &b.body, stepping: &mut b.stepping, arc: arc_b },
        ];
        together::launch(&self.surface, self.accuracy, &mut launches.map(Some));
        for ((ball, state), before) in pair.iter().zip(before) {
            let steps = self.balls[*ball].stepping.steps - before;
            self.set_out_on(*ball, (time, state), steps);
        }
    }

    fn set_out_on(&mut self, ball: usize, (time, state): (Time, &State), steps: u64) {
        self.launched(ball, steps);
        if !self.arcs[ball].is_sane() {
            self.stand_still(ball, time, state);
        }
    }

    /// Takes stock of a launch that took `steps`.
    pub(super) fn launched(&mut self, ball: usize, steps: u64) {
        let b = &mut self.balls[ball];
        self.report.steps += steps;
        self.report.fallbacks += std::mem::take(&mut b.stepping.forced);
        let arc = &mut self.arcs[ball];
        arc.stamp = arc.stamp.wrapping_add(1);
        arc.driven = b.drive.is_some();
    }

    /// The equations have no finite answer from here: the ball stands at its last good place.
    #[cold]
    pub(super) fn stand_still(&mut self, ball: usize, time: Time, state: &State) {
        self.report.fallbacks += 1;
        let length = Time::of_quantum(time.quantum()).after(QUANTUM).since(time);
        self.balls[ball].body.hold(&self.surface, (time, state), length, &mut self.arcs[ball]);
    }
}
