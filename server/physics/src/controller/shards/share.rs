//! What a shard notes while it runs: how balls were before the phase, what happened to those that others have too, and
//! whose copies mattered.

use super::super::Controller;
use super::super::ledger::Addend;
use super::super::plain::Reader;
use crate::detect::broad_phase::Bounds;
use crate::diagnostics::Report;
use crate::schedule::event::{Next, What};
use crate::schedule::time::Time;
use crate::tolerance::HITS_KEPT;
use std::ops::Range;

/// What a ball is to a shard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Role {
    /// Not there.
    Absent,
    /// Its own; no other shard has it.
    Private,
    /// Its own; others have copies.
    Shared,
    /// A copy of a ball of a shard before it.
    Below,
    /// A copy of a ball of a shard after it.
    Above,
}

/// An interval along the axis of the strips, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub low: f64,
    pub high: f64,
}

impl Span {
    pub(super) const NOWHERE: Self = Self { low: f64::INFINITY, high: f64::NEG_INFINITY };

    pub(super) fn of(bounds: &Bounds, axis: usize) -> Self {
        Self { low: bounds[axis], high: bounds[axis + 2] }
    }

    /// Holds `other` too, from now on. What is not a number reaches everywhere.
    pub(super) fn take_in(&mut self, other: Self) {
        self.low = if other.low.is_nan() { f64::NEG_INFINITY } else { self.low.min(other.low) };
        self.high = if other.high.is_nan() { f64::INFINITY } else { self.high.max(other.high) };
    }

    /// How far `self` lies below `other`, m: infinite if either is nowhere, and not at all where that is no number.
    pub(super) fn below(&self, other: &Self) -> f64 {
        let room = other.low - self.high;
        if room.is_nan() { f64::NEG_INFINITY } else { room }
    }
}

/// A ball that others have too, after something happened to it: all that its future follows from.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub ball: u32,
    /// Of the event; of the phase's beginning in a ball's first entry, which says how it was.
    pub time: Time,
    pub span: Span,
    pub words: Range<usize>,
}

/// What an event read.
#[derive(Clone, Debug, Default)]
struct Reads {
    /// An own ball, and one that is not there.
    own: bool,
    absent: bool,
    copies: Vec<u32>,
}

/// A shard's notes. The whole of a divided run has some too: who was changed in it.
#[derive(Clone, Debug)]
pub(crate) struct Share {
    whole: bool,
    pub(super) number: usize,
    pub(super) axis: usize,
    pub(super) role: Vec<Role>,
    /// Bounds since the last cut: of all it owns, of those that nobody else has, of copies below and above.
    pub(super) owned: Span,
    pub(super) private: Span,
    pub(super) below: Span,
    pub(super) above: Span,
    /// When the phase began.
    start: Time,
    /// Balls changed in this phase, in order, and how they were.
    changed: Vec<u32>,
    is_changed: Vec<bool>,
    before: Vec<u64>,
    /// Balls changed since the whole was told.
    news: Vec<bool>,
    pub(super) log: Vec<Entry>,
    pub(super) words: Vec<u64>,
    /// For each copy, the last event that read it together with a ball of one's own.
    pub(super) needed: Vec<Time>,
    /// The event's time.
    event: Time,
    reads: Reads,
    /// Whether an own ball was to meet one that is not there.
    pub(super) lost: bool,
    /// Addends of the sums of the whole, with their instants, in order.
    pub(super) addends: Vec<(Time, Addend)>,
    /// The instant of each hit in the controller's list.
    pub(super) hit_times: Vec<Time>,
    pub(super) hits_dropped: u64,
}

impl Share {
    pub(super) fn of_shard(number: usize, balls: usize) -> Self {
        Self {
            whole: false,
            number,
            axis: 0,
            role: vec![Role::Absent; balls],
            owned: Span::NOWHERE,
            private: Span::NOWHERE,
            below: Span::NOWHERE,
            above: Span::NOWHERE,
            start: Time::ZERO,
            changed: Vec::with_capacity(balls),
            is_changed: vec![false; balls],
            before: Vec::new(),
            news: vec![false; balls],
            log: Vec::new(),
            words: Vec::new(),
            needed: vec![Time::ZERO; balls],
            event: Time::ZERO,
            reads: Reads::default(),
            lost: false,
            addends: Vec::new(),
            hit_times: Vec::new(),
            hits_dropped: 0,
        }
    }

    pub(super) fn of_whole(balls: usize) -> Self {
        Self { whole: true, ..Self::of_shard(0, balls) }
    }

    /// Whether a ball was changed since this was last asked.
    pub(super) fn has_news_of(&mut self, ball: usize) -> bool {
        std::mem::take(&mut self.news[ball])
    }

    pub(super) fn tell_news_of(&mut self, ball: usize) {
        self.news[ball] = true;
    }

    /// Balls changed in this phase.
    pub(super) fn changed_here(&self) -> impl Iterator<Item = usize> + '_ {
        self.changed.iter().map(|ball| *ball as usize)
    }

    /// An empty sheet.
    pub(super) fn open_phase(&mut self, start: Time) {
        self.start = start;
        for ball in self.changed.drain(..) {
            self.is_changed[ball as usize] = false;
        }
        self.before.clear();
        self.log.clear();
        self.words.clear();
        self.addends.clear();
        self.hit_times.clear();
        self.hits_dropped = 0;
        self.lost = false;
    }

    /// The spans of a ball's bounds go on to hold `span`.
    pub(super) fn extend(&mut self, ball: usize, span: Span) {
        match self.role[ball] {
            Role::Absent => {}
            Role::Private => {
                self.owned.take_in(span);
                self.private.take_in(span);
            }
            Role::Shared => self.owned.take_in(span),
            Role::Below => self.below.take_in(span),
            Role::Above => self.above.take_in(span),
        }
    }

    fn owns(&self, ball: usize) -> bool {
        matches!(self.role[ball], Role::Private | Role::Shared)
    }

    fn read(&mut self, ball: usize) {
        match self.role[ball] {
            Role::Absent => self.reads.absent = true,
            Role::Private | Role::Shared => self.reads.own = true,
            Role::Below | Role::Above => self.reads.copies.push(ball as u32),
        }
    }

    fn open_event(&mut self, ball: usize, next: &Next) {
        self.event = next.time;
        self.reads.copies.clear();
        (self.reads.own, self.reads.absent) = (false, false);
        self.read(ball);
        if let What::Ball { other, .. } = next.what {
            self.read(other as usize);
        }
    }

    fn close_event(&mut self) {
        if self.reads.own {
            self.lost |= self.reads.absent;
            for ball in self.reads.copies.drain(..) {
                self.needed[ball as usize] = self.event;
            }
        }
    }
}

impl Controller {
    /// An event in a shard. One of a copy is another shard's: it counts there.
    pub(in super::super) fn take_in_shard(&mut self, ball: usize, next: &Next) {
        let before = (self.report, self.now);
        let (mut own, mut absent) = (true, false);
        if let Some(share) = &mut self.share {
            share.open_event(ball, next);
            (own, absent) = (share.owns(ball), share.reads.absent);
        }
        self.now = self.now.max(next.time);
        if absent {
            // A copy's partner that this shard does not have: the copy goes its own way, and is mended.
            self.predict(ball, next.time);
        } else {
            self.take(ball, next);
        }
        let Some(share) = &mut self.share else { return };
        share.close_event();
        share.hit_times.resize(self.hits.len(), next.time);
        if !own {
            (self.report, self.now) = before;
        }
    }

    /// Whether events are to be noted.
    pub(in super::super) fn is_shard(&self) -> bool {
        self.share.as_ref().is_some_and(|share| !share.whole)
    }

    /// To be told before anything of a ball changes.
    #[inline]
    pub(in super::super) fn will_change(&mut self, ball: usize) {
        if self.share.is_some() {
            self.note_change(ball);
        }
    }

    #[inline(never)]
    fn note_change(&mut self, ball: usize) {
        if let Some(share) = self.share.take_if(|share| !share.is_changed[ball]) {
            self.note_before(share, ball);
        }
    }

    fn note_before(&mut self, mut share: Box<Share>, ball: usize) {
        share.is_changed[ball] = true;
        share.changed.push(ball as u32);
        if !share.whole {
            share.news[ball] = true;
            self.seeds_of(ball, &mut |word| share.before.push(word));
            if share.role[ball] >= Role::Shared {
                let start = share.start;
                self.note(&mut share, ball, start);
            }
        }
        self.share = Some(share);
    }

    fn note(&self, share: &mut Share, ball: usize, time: Time) {
        let from = share.words.len();
        self.seeds_of(ball, &mut |word| share.words.push(word));
        let span = Span::of(self.broad_phase.bounds_of(ball), share.axis);
        share.log.push(Entry { ball: ball as u32, time, span, words: from..share.words.len() });
    }

    /// To be told after an event changed a ball.
    #[inline]
    pub(in super::super) fn has_changed(&mut self, ball: usize) {
        if self.share.is_some() {
            self.note_changed(ball);
        }
    }

    #[inline(never)]
    fn note_changed(&mut self, ball: usize) {
        if let Some(share) = self.share.take_if(|share| !share.whole) {
            self.note_after(share, ball);
        }
    }

    fn note_after(&mut self, mut share: Box<Share>, ball: usize) {
        share.extend(ball, Span::of(self.broad_phase.bounds_of(ball), share.axis));
        if share.role[ball] >= Role::Shared {
            let time = share.event;
            self.note(&mut share, ball, time);
        }
        self.share = Some(share);
    }

    /// To be told when a search for neighbours of a ball is due, or was: it reads them all. Balls that nobody else has never
    /// have copies among theirs, or the phase does not hold.
    #[inline]
    pub(in super::super) fn reads_neighbours(&mut self, ball: usize) {
        if self.share.is_some() {
            self.note_neighbours(ball);
        }
    }

    #[inline(never)]
    fn note_neighbours(&mut self, ball: usize) {
        if let Some(mut share) = self.share.take_if(|share| share.role[ball] >= Role::Shared) {
            share.read(ball);
            self.broad_phase.neighbours(ball, |other| share.read(other));
            self.share = Some(share);
        }
    }

    /// Whether hits whose first ball is `ball` go into the list here.
    #[inline]
    pub(in super::super) fn lists_hits_of(&self, ball: usize) -> bool {
        self.share.as_ref().is_none_or(|share| share.whole || share.owns(ball))
    }

    /// Counts hits that are not listed.
    pub(in super::super) fn drop_hits(&mut self, count: usize) {
        match &mut self.share {
            Some(share) if !share.whole => {
                share.hits_dropped += count as u64;
                share.hit_times.truncate(HITS_KEPT);
            }
            _ => self.report.hits_dropped += count as u64,
        }
    }

    /// Adds to the sums, or notes the addend where others' may come first.
    pub(in super::super) fn add_up(&mut self, addend: Addend) {
        match &mut self.share {
            Some(share) if !share.whole => {
                if share.owns(addend.ball as usize) {
                    share.addends.push((self.ledger.time, addend));
                }
            }
            _ => {
                self.report.steering_work += addend.work;
                self.report.negative_reaction += addend.pulled;
            }
        }
    }

    /// Begins a phase with an empty sheet.
    pub(super) fn open_phase(&mut self, start: Time) {
        self.report = Report::default();
        // The whole knows the latest event before.
        self.now = Time::ZERO;
        self.clear_hits();
        if let Some(share) = &mut self.share {
            share.open_phase(start);
        }
    }

    /// Every ball as it was when the phase began.
    pub(super) fn undo_phase(&mut self) {
        let Some(share) = self.share.take() else { return };
        let mut from = Reader::new(&share.before);
        for ball in share.changed_here() {
            let done = self.sow_ball(ball, &mut from);
            assert!(done, "ball {ball} cannot be launched again as it was");
        }
        self.time = share.start;
        self.share = Some(share);
    }
}
