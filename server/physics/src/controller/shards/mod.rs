//! One scene in several shards: each runs its part of the floor by itself, and no bit differs from the run in one piece.
//!
//! The floor is cut into strips. A shard owns the balls of its strip and has copies of those in a halo around it; on all
//! of these it runs the engine as it is for a short phase. Nothing that lies beyond its halo can have touched a ball it
//! owns, unless something came farther than the halo is wide. So after the phase it is asked whether that holds:
//!
//! - the bounds of owned balls met the bounds of nobody whom the shard does not have;
//! - every copy that an event with an owned ball read had until then the course that its owner gave it, compared word by
//!   word.
//!
//! Then, event by event in the one order of all, each owned ball did what it does in the run in one piece. If it does not
//! hold, the phase is undone and run in one piece. Either way the result is that of the one order: no luck is involved,
//! and the number of shards, like the threads that run them, changes no bit.
//!
//! | question | file |
//! |---|---|
//! | who owns whom, who has copies | `cut` |
//! | what a shard notes while it runs | `share` |
//! | whether a phase holds, and its undoing | `check` |
//! | one report, one list of hits | `merge` |

mod check;
mod cut;
mod merge;
mod share;

pub(super) use share::Share;

use super::{Controller, Work};
use crate::diagnostics::Report;
use crate::motion::together;
use crate::schedule::clearance::Clearance;
use crate::schedule::time::{QUANTUM, Time};
use crate::tolerance::{HALO, HITS_KEPT, PHASES_APART_MAX};
use check::Parting;
use share::Span;

/// Most shards of a scene: one bit each of a word.
pub const SHARDS_MAX: usize = 32;

/// A part of the floor with the balls on it, to be advanced wherever the caller likes.
#[derive(Clone, Debug)]
pub struct Shard(Box<Controller>);

impl Shard {
    /// Runs its part until `time`. Shards know nothing of each other meanwhile.
    pub fn advance_to(&mut self, time: Time) {
        self.0.run_to(time);
        self.0.time = time;
    }
}

/// How a divided run went: what it cost, for no bit depends on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Division {
    /// Shards.
    pub shards: usize,
    /// Phases run in shards and kept.
    pub kept: u64,
    /// Phases undone and run in one piece.
    pub undone: u64,
    /// Phases run in one piece at once, because the last ones were undone.
    pub in_one: u64,
    /// Times that balls were dealt out anew.
    pub cuts: u64,
    /// Balls that shards have beside their own, now.
    pub copies: usize,
}

/// A scene's shards, and who has which ball.
#[derive(Clone, Debug)]
pub(super) struct Shards {
    list: Vec<Shard>,
    /// For each ball the shard that owns it, and a bit for each shard that has it.
    owner: Vec<u8>,
    members: Vec<u32>,
    /// Strips lie one after the other along x (0) or y (1).
    axis: usize,
    /// Width of the halo around a strip, m.
    halo: f64,
    /// Where one strip ends and the next begins, m.
    borders: Vec<f64>,
    middles: Vec<f64>,
    /// `beyond[b][c]`: bounds of balls that b owns and shares with others, but not with c.
    beyond: Vec<Vec<Span>>,
    /// Whether the shards are ahead of the whole.
    ahead: bool,
    /// Whether balls must be dealt out anew before the next phase.
    worn: bool,
    /// Phases still to be run in one piece, and how many the next undone one costs.
    pause: u32,
    penalty: u32,
    /// Copies that went another way than their balls.
    parted: Vec<Parting>,
    division: Division,
}

impl Controller {
    /// Divides the run into `count` shards for [`Self::advance_divided`], at most [`SHARDS_MAX`] and no more than there are
    /// balls; fewer than two leave it in one piece. Each takes as much memory as the run itself. Changes no bit of it.
    pub fn divide(&mut self, count: usize) {
        self.undivide();
        let count = count.min(SHARDS_MAX).min(self.balls.len());
        if count < 2 {
            return;
        }
        let shard = |number| {
            let mut shard = self.clone();
            shard.hits = Vec::with_capacity(HITS_KEPT);
            let width = together::width(&shard.surface, shard.accuracy);
            shard.work = Work::new(shard.balls.len(), width);
            shard.share = Some(Box::new(Share::of_shard(number, self.balls.len())));
            Shard(Box::new(shard))
        };
        let mut shards = Shards {
            list: (0..count).map(shard).collect(),
            owner: vec![0; self.balls.len()],
            members: vec![u32::MAX >> (SHARDS_MAX - count); self.balls.len()],
            axis: 0,
            halo: HALO * self.farthest_bounds(),
            borders: vec![0.0; count - 1],
            middles: Vec::with_capacity(self.balls.len()),
            beyond: vec![vec![Span::NOWHERE; count]; count],
            ahead: false,
            worn: false,
            pause: 0,
            penalty: 1,
            parted: Vec::new(),
            division: Division { shards: count, ..Division::default() },
        };
        shards.choose_axis();
        shards.cut();
        self.share = Some(Box::new(Share::of_whole(self.balls.len())));
        self.shards = Some(Box::new(shards));
    }

    /// Back in one piece.
    pub fn undivide(&mut self) {
        self.recall();
        (self.shards, self.share) = (None, None);
    }

    /// Into how many shards the run is divided, and how that goes; nothing if it is in one piece.
    pub fn division(&self) -> Option<Division> {
        let shards = self.shards.as_ref()?;
        let copies = shards.members.iter().map(|members| members.count_ones() as usize - 1).sum();
        Some(Division { copies, ..shards.division })
    }

    /// As [`Self::advance_to`], in shards: `run` must bring every shard to the time it is given with
    /// [`Shard::advance_to`], on whatever threads, and leave the list as it was. Every bit is that of the run in one piece.
    pub fn advance_divided(&mut self, time: Time, run: &mut dyn FnMut(&mut Vec<Shard>, Time)) -> Report {
        if self.shards.is_none() {
            return self.advance_to(time);
        }
        self.clear_hits();
        if time <= self.time {
            return Report::default();
        }
        let before = self.report;
        while self.time < time {
            let until = self.time.after(QUANTUM).min(time);
            match self.shards.take() {
                Some(mut shards) => {
                    shards.phase(self, until, run);
                    self.shards = Some(shards);
                }
                None => self.run_to(until),
            }
            self.time = until;
        }
        self.report.since(&before)
    }

    /// Who knows what a ball does now.
    pub(super) fn holder(&self, ball: usize) -> &Self {
        match &self.shards {
            Some(shards) if shards.ahead => shards.holder(ball),
            _ => self,
        }
    }

    /// Has all balls here again, to be looked at together or changed.
    pub(super) fn recall(&mut self) {
        if let Some(mut shards) = self.shards.take() {
            shards.recall(self);
            self.shards = Some(shards);
        }
    }

    /// Takes over a ball as it is in `from`, another controller of the same run.
    fn take_over(&mut self, ball: usize, from: &Self) {
        self.balls[ball] = from.balls[ball];
        self.arcs[ball] = from.arcs[ball];
        self.broad_phase.file(ball, *from.broad_phase.bounds_of(ball));
        self.queue.set(ball, *from.queue.of(ball));
        // Those near it did not see it come.
        let Self { broad_phase, queue, .. } = self;
        broad_phase.neighbours(ball, |other| queue.set_alone(other, Clearance::UNKNOWN));
    }
}

impl Shards {
    fn holder(&self, ball: usize) -> &Controller {
        &self.list[usize::from(self.owner[ball])].0
    }

    /// Runs until `until`: in shards, if that holds, or else in one piece.
    fn phase(&mut self, whole: &mut Controller, until: Time, run: &mut dyn FnMut(&mut Vec<Shard>, Time)) {
        if self.pause > 0 {
            self.pause -= 1;
            self.division.in_one += 1;
            whole.run_to(until);
            return;
        }
        self.hand_out(whole);
        if self.worn {
            self.cut();
        }
        for shard in &mut self.list {
            shard.0.open_phase(whole.time);
        }
        run(&mut self.list, until);
        self.ahead = true;
        if self.holds() {
            self.division.kept += 1;
            self.penalty = 1;
            self.mend_copies();
            self.merge(whole);
            return;
        }
        for shard in &mut self.list {
            shard.0.undo_phase();
        }
        self.recall(whole);
        whole.run_to(until);
        self.worn = true;
        self.division.undone += 1;
        // A scene that does not divide costs little more than one that is not divided.
        self.pause = self.penalty - 1;
        self.penalty = (2 * self.penalty).min(PHASES_APART_MAX);
    }

    /// Brings what the shards did to the whole.
    fn recall(&mut self, whole: &mut Controller) {
        if !std::mem::take(&mut self.ahead) {
            return;
        }
        for (ball, owner) in self.owner.iter().enumerate() {
            let shard = &mut self.list[usize::from(*owner)].0;
            if shard.share.as_mut().is_some_and(|share| share.has_news_of(ball)) {
                whole.take_over(ball, shard);
            }
        }
    }

    /// Brings what happened in the whole since the last phase, commands above all, to the shards.
    fn hand_out(&mut self, whole: &mut Controller) {
        let Some(mut share) = whole.share.take() else { return };
        for ball in share.changed_here() {
            let members = self.members[ball];
            for shard in cut::bits(members) {
                self.list[shard].0.take_over(ball, whole);
            }
            self.extend(ball);
        }
        share.open_phase(whole.time);
        whole.share = Some(share);
    }
}
