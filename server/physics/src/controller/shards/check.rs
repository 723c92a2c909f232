//! Whether a phase holds: whether every ball did in its owner's shard what it does in the run in one piece.
//!
//! Suppose not, and take the first event, in the one order of all, that differs. It changes or reads a ball that some shard
//! owns, and up to it all balls did what their owners say. The shard has everybody whose bounds meet those of its balls,
//! by the spans; copies that the event reads are what their owners say, by the logs; copies that it does not read for going
//! another way are, by the logs, balls that stay away from all it owns. So the event is the same.

use super::share::{Entry, Share};
use super::{Shard, Shards};
use std::cmp::Ordering;

/// A copy that did not go its ball's way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parting {
    pub ball: usize,
    pub owner: usize,
    pub shard: usize,
}

/// Entries of one ball in one log.
type Course<'a> = &'a [Entry];

fn share(shard: &Shard) -> &Share {
    shard.0.share.as_ref().expect("every shard takes notes")
}

/// Entries of a ball; the log is sorted.
fn course(share: &Share, ball: usize) -> Course<'_> {
    let from = share.log.partition_point(|entry| (entry.ball as usize) < ball);
    let length = share.log[from..].partition_point(|entry| entry.ball as usize == ball);
    &share.log[from..from + length]
}

impl Shards {
    /// Whether the phase holds. Lists copies that must be mended.
    pub(super) fn holds(&mut self) -> bool {
        self.parted.clear();
        for shard in &mut self.list {
            if let Some(share) = &mut shard.0.share {
                // By ball; each ball's entries stay in their order, that of their words.
                share.log.sort_unstable_by_key(|entry| (entry.ball, entry.words.start));
            }
        }
        for place in 0..self.list.len() {
            let mut log = share(&self.list[place]).log.len();
            while log > 0 {
                log -= 1;
                let Entry { ball, span, .. } = share(&self.list[place]).log[log];
                if usize::from(self.owner[ball as usize]) == place {
                    self.extend_beyond(ball as usize, span);
                }
            }
        }
        let room = self.room();
        self.worn = room < self.halo / 4.0;
        let lost = self.list.iter().any(|shard| share(shard).lost);
        room > 0.0 && !lost && self.copies_agree()
    }

    /// The least distance between what a shard has or owns and what is kept from it, along the axis, m.
    fn room(&self) -> f64 {
        let mut least = f64::INFINITY;
        let mut take = |room: f64| least = least.min(room);
        for (b, theirs) in self.list.iter().map(share).enumerate() {
            take(theirs.below.below(&theirs.private));
            take(theirs.private.below(&theirs.above));
            for (c, mine) in self.list.iter().map(share).enumerate() {
                for span in [&theirs.private, &self.beyond[b][c]] {
                    match b.cmp(&c) {
                        Ordering::Less => take(span.below(&mine.owned)),
                        Ordering::Greater => take(mine.owned.below(span)),
                        Ordering::Equal => {}
                    }
                }
            }
        }
        least
    }

    /// Compares the courses of all copies with those of their balls.
    fn copies_agree(&mut self) -> bool {
        let mut parted = std::mem::take(&mut self.parted);
        let mut fine = true;
        for (place, mine) in self.list.iter().map(share).enumerate() {
            for course in mine.log.chunk_by(|a, b| a.ball == b.ball) {
                let ball = course[0].ball as usize;
                let owner = usize::from(self.owner[ball]);
                if owner == place {
                    // Those that a copy never heard of.
                    for shard in super::cut::bits(self.members[ball] & !(1 << owner)) {
                        let copy = share(&self.list[shard]);
                        if self::course(copy, ball).is_empty() {
                            parted.push(Parting { ball, owner, shard });
                            fine &= parted_apart(mine, course, copy, &[]);
                        }
                    }
                } else {
                    let theirs = share(&self.list[owner]);
                    let true_course = self::course(theirs, ball);
                    if !same(theirs, true_course, mine, course) {
                        parted.push(Parting { ball, owner, shard: place });
                        fine &= parted_apart(theirs, true_course, mine, course);
                    }
                }
            }
        }
        self.parted = parted;
        fine
    }
}

fn same_entry(a: (&Share, &Entry), b: (&Share, &Entry)) -> bool {
    a.1.time == b.1.time && a.0.words[a.1.words.clone()] == b.0.words[b.1.words.clone()]
}

fn same(a: &Share, of_a: Course<'_>, b: &Share, of_b: Course<'_>) -> bool {
    of_a.len() == of_b.len() && of_a.iter().zip(of_b).all(|(x, y)| same_entry((a, x), (b, y)))
}

/// Whether a copy that went another way than its ball, told by `owner`, was not read any more and would not have been.
fn parted_apart(owner: &Share, course: Course<'_>, copy: &Share, of_copy: Course<'_>) -> bool {
    let pairs = course.iter().zip(of_copy);
    let mut common = pairs.take_while(|(x, y)| same_entry((owner, x), (copy, y))).count();
    if course.is_empty() || of_copy.is_empty() {
        // The first entry is how the ball was, which both know.
        common = 1;
    }
    let Some(last) = common.checked_sub(1) else { return false };
    let known = course.get(last).or_else(|| of_copy.get(last));
    let Some(ball) = known.map(|entry| entry.ball as usize) else { return false };
    let unread = [course, of_copy].iter().filter_map(|c| c.get(common)).all(|e| copy.needed[ball] < e.time);
    let away = |entry: &Entry| {
        let room = match owner.number.cmp(&copy.number) {
            Ordering::Less => entry.span.below(&copy.owned),
            _ => copy.owned.below(&entry.span),
        };
        room > 0.0
    };
    unread && known.into_iter().chain(course.iter().skip(common)).all(away)
}
