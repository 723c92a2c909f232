//! What happened, as far as it can be gone back to: points of the run, and what was done between them.
//!
//! Places on the line are epochs with ticks. Epochs only grow along it, so places are ordered; a rewind cuts off what came
//! after the place it went to, and the line goes on from there in a new epoch. `seconds` are counted along the line: a
//! reset or another scene takes none.

use super::past::Past;
use super::{MAX_POINTS, RECENT_S};
use protocol::command::{Command, Refusal, code};
use protocol::timeline::{HistoryEntry, Rewind};
use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

/// Epoch and tick.
pub type Place = (u64, u64);

/// What was done at a place, and where that led to.
#[derive(Clone)]
pub struct Deed {
    /// After the tick of this place.
    pub at: Place,
    /// What.
    pub what: What,
    /// Where the run went on.
    pub then: Place,
}

/// What can have been done.
#[derive(Clone)]
pub enum What {
    /// A command was obeyed.
    Command(Arc<Command>),
    /// Another moment took the place of the present one.
    Entered(Arc<Past>),
    /// A new epoch of the same run began: it was gone back to here.
    WentBack,
}

/// A stretch of ticks of one epoch.
struct Stretch {
    first: Place,
    /// Where it was entered from.
    from: Place,
    /// Ticks of the whole line before it.
    before: u64,
}

struct Point {
    past: Arc<Past>,
    /// Ticks of the whole line before it.
    line: u64,
}

/// The line of what happened.
pub struct Line {
    points: VecDeque<Point>,
    deeds: VecDeque<Deed>,
    stretches: VecDeque<Stretch>,
    /// What the points take with the worlds that they belong to.
    point_bytes: u64,
    /// What the deeds take, about.
    deed_bytes: u64,
    max_bytes: u64,
    /// Whether the oldest point goes when the deeds take too much.
    forgets: bool,
    tick_rate_hz: u32,
}

/// A way to a place: from a point before it, through what was done.
pub struct Way {
    /// Where it begins.
    pub from: Arc<Past>,
    /// What to do on it.
    pub deeds: Vec<Deed>,
    /// Where it ends.
    pub to: Place,
}

impl Line {
    /// Nothing yet. It takes at most `max_bytes`; if it does not forget, its deeds may take more.
    pub const fn new(tick_rate_hz: u32, max_bytes: u64, forgets: bool) -> Self {
        Self {
            points: VecDeque::new(),
            deeds: VecDeque::new(),
            stretches: VecDeque::new(),
            point_bytes: 0,
            deed_bytes: 0,
            max_bytes,
            forgets,
            tick_rate_hz,
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.points.clear();
        self.deeds.clear();
        self.stretches.clear();
        (self.point_bytes, self.deed_bytes) = (0, 0);
    }

    /// A point: the run as a tick has left it.
    pub fn point(&mut self, past: Arc<Past>) {
        if self.max_bytes == 0 {
            return;
        }
        let place = past.place();
        if self.stretches.is_empty() {
            self.stretches.push_back(Stretch { first: place, from: place, before: 0 });
        }
        let Some(line) = self.ticks_before(place) else { return };
        self.points.push_back(Point { past, line });
        self.count_points();
        self.keep_within_bounds();
    }

    /// Something was done that led from one place to another.
    pub fn done(&mut self, at: Place, what: What, then: Place) {
        let Some(before) = self.ticks_before(at) else { return };
        if at.0 != then.0 {
            self.stretches.push_back(Stretch { first: then, from: at, before });
        }
        let deed = Deed { at, what, then };
        self.deed_bytes += bytes_of(&deed);
        self.deeds.push_back(deed);
        self.keep_within_bounds();
    }

    /// The run went back to `to` and goes on from there as `then`.
    pub fn went_back(&mut self, to: Place, then: Place) {
        if self.ticks_before(to).is_none() {
            return self.clear();
        }
        while self.points.back().is_some_and(|point| point.past.place() > to) {
            self.points.pop_back();
        }
        self.count_points();
        while let Some(deed) = self.deeds.pop_back_if(|deed| deed.at >= to) {
            self.deed_bytes -= bytes_of(&deed);
        }
        while self.stretches.back().is_some_and(|stretch| stretch.first > to) {
            self.stretches.pop_back();
        }
        self.done(to, What::WentBack, then);
    }

    /// How many ticks of the line lie before a place on it.
    fn ticks_before(&self, (epoch, tick): Place) -> Option<u64> {
        let stretch = self.stretches.iter().rev().find(|stretch| stretch.first.0 == epoch)?;
        Some(stretch.before + tick.checked_sub(stretch.first.1)?)
    }

    /// The place that is meant, when the run stands at `now`.
    pub fn find(&self, rewind: &Rewind, now: Place) -> Result<Place, Refusal> {
        if self.max_bytes == 0 {
            let why = "no history is kept here: serve without --history 0, or save states into slots";
            return Err(Refusal::new(code::FEATURE_UNSUPPORTED, why));
        }
        let nothing = || Refusal::new(code::INCORRECT_STATE, "there is nothing to go back to yet");
        let oldest = self.points.front().ok_or_else(nothing)?;
        let present = self.ticks_before(now).ok_or_else(nothing)?;
        let place = match *rewind {
            Rewind { seconds: Some(seconds), .. } => self.back_by(seconds, present),
            Rewind { tick: Some(tick), epoch, .. } => self.at_tick(tick, epoch, now)?,
            _ => None,
        };
        place.filter(|place| *place >= oldest.past.place()).ok_or_else(|| {
            let (epoch, tick) = oldest.past.place();
            let reach = self.seconds(present.saturating_sub(oldest.line));
            let why = format!(
                "the history begins {reach:.3} s ago, at tick {tick} of epoch {epoch}: go back less far, or to that tick"
            );
            Refusal::new(code::OPERATION_FAILED, why)
        })
    }

    fn seconds(&self, ticks: u64) -> f64 {
        ticks as f64 / f64::from(self.tick_rate_hz)
    }

    /// The newest place so many seconds before the present.
    fn back_by(&self, seconds: f64, present: u64) -> Option<Place> {
        let ticks = (seconds * f64::from(self.tick_rate_hz)).round() as u64;
        let line = present.checked_sub(ticks)?;
        let stretch = self.stretches.iter().rev().find(|stretch| stretch.before <= line)?;
        Some((stretch.first.0, stretch.first.1 + (line - stretch.before)))
    }

    /// A tick of an epoch, or of the present count of ticks through its epochs. None when it is long over.
    fn at_tick(&self, tick: u64, epoch: Option<u64>, now: Place) -> Result<Option<Place>, Refusal> {
        let refuse = |why: String| Err(Refusal::new(code::OPERATION_FAILED, why));
        let mut end = now;
        for stretch in self.stretches.iter().rev() {
            let (first, its) = (stretch.first.1, stretch.first.0);
            if epoch.is_none_or(|epoch| epoch == its) && (first..=end.1).contains(&tick) {
                return Ok(Some((its, tick)));
            }
            match epoch {
                Some(epoch) if epoch > its => break,
                Some(epoch) if epoch == its && tick > end.1 => {
                    return refuse(format!("epoch {epoch} was left at tick {}", end.1));
                }
                None if tick > end.1 => {
                    return refuse(format!(
                        "tick {tick} lies ahead: it is tick {} of epoch {}; an earlier epoch has to be named",
                        now.1, now.0
                    ));
                }
                _ => {}
            }
            // Ticks that do not go on are another count.
            if epoch.is_none() && stretch.from.1 != first {
                break;
            }
            end = stretch.from;
        }
        if let Some(epoch) = epoch
            && self.stretches.front().is_some_and(|oldest| epoch >= oldest.first.0)
        {
            return refuse(format!("tick {tick} of epoch {epoch} did not lead to the present"));
        }
        Ok(None)
    }

    /// How to get to a place that was found.
    pub fn way(&self, to: Place) -> Option<Way> {
        let after = self.points.partition_point(|point| point.past.place() <= to);
        let from = self.points.get(after.checked_sub(1)?)?.past.clone();
        let between = from.place()..to;
        let first = self.deeds.partition_point(|deed| deed.at < between.start);
        let deeds = self.deeds.range(first..).take_while(|deed| deed.at < between.end);
        Some(Way { deeds: deeds.cloned().collect(), from, to })
    }

    /// Makes room: points go where they lie closest for their age, and the oldest when deeds take more than half.
    fn keep_within_bounds(&mut self) {
        while self.points.len() > MAX_POINTS || self.bytes() > self.max_bytes {
            if self.forgets && self.deed_bytes > self.max_bytes / 2 {
                self.forget_oldest();
            } else if let Some(place) = self.most_crowded() {
                self.points.remove(place);
            } else if self.forgets && self.points.len() > 1 {
                self.forget_oldest();
            } else {
                break;
            }
            self.count_points();
        }
    }

    fn count_points(&mut self) {
        self.point_bytes = bytes_of_all(self.points.iter().map(|point| &point.past));
    }

    fn forget_oldest(&mut self) {
        self.points.pop_front();
        let Some(oldest) = self.points.front().map(|point| point.past.place()) else { return self.clear() };
        while let Some(deed) = self.deeds.pop_front_if(|deed| deed.at < oldest) {
            self.deed_bytes -= bytes_of(&deed);
        }
        let passed = self.stretches.partition_point(|stretch| stretch.first <= oldest);
        self.stretches.drain(..passed.saturating_sub(1));
    }

    /// The point between the first and the last whose neighbours lie closest, for how long ago it was: up to
    /// [`RECENT_S`] all gaps count alike, farther back with the square of the age. So what lies farther back than that
    /// never takes more room than what does not.
    fn most_crowded(&self) -> Option<usize> {
        let newest = self.points.back()?.line;
        let crowd = |place: usize| {
            let gap = self.points[place + 1].line - self.points[place - 1].line;
            let age = (self.seconds(newest - self.points[place].line) / RECENT_S).max(1.0);
            gap as f64 / (age * age)
        };
        // Of equal ones the oldest goes.
        (1..self.points.len().saturating_sub(1)).min_by(|a, b| crowd(*a).total_cmp(&crowd(*b)))
    }

    /// What it takes, with the worlds that only the past needs.
    pub const fn bytes(&self) -> u64 {
        self.point_bytes + self.deed_bytes
    }

    /// For whoever asks, when the run stands at `now`.
    pub fn entry(&self, now: Place) -> HistoryEntry {
        let oldest = self.points.front();
        let (oldest_epoch, oldest_tick) = oldest.map_or((0, 0), |point| point.past.place());
        let present = self.ticks_before(now);
        HistoryEntry {
            oldest_epoch,
            oldest_tick,
            reach_s: oldest
                .zip(present)
                .map_or(0.0, |(oldest, now)| self.seconds(now.saturating_sub(oldest.line))),
            points: self.points.len() as u64,
            bytes: self.bytes(),
            max_bytes: self.max_bytes,
        }
    }
}

/// What moments take, with each of their worlds once.
pub fn bytes_of_all<'a>(pasts: impl Iterator<Item = &'a Arc<Past>>) -> u64 {
    let mut worlds = BTreeSet::new();
    let of_one = |past: &Arc<Past>| {
        let ground = if worlds.insert(Arc::as_ptr(past.ground())) { past.ground().bytes() } else { 0 };
        past.bytes() + ground
    };
    pasts.map(of_one).sum()
}

fn bytes_of(deed: &Deed) -> u64 {
    let more = match &deed.what {
        What::Command(command) => match &**command {
            Command::LoadScene { toml: Some(toml), .. } => toml.len(),
            Command::LoadState { state: Some(state), .. } => state.words.len(),
            Command::Steer { .. } => 0,
            // As long as it is on the wire, about.
            command => protocol::codec::encode_json(command).len(),
        },
        What::Entered(past) => past.bytes() as usize,
        What::WentBack => 0,
    };
    (size_of::<Deed>() + size_of::<Command>() + more) as u64
}
