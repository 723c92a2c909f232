//! Who owns whom: strips of as many balls each, and who has copies: everybody whose halo a ball reaches into.

use super::share::{Role, Span};
use super::{Shard, Shards};
use crate::controller::Controller;
use crate::detect::broad_phase::travel;
use crate::schedule::event::Next;

/// The bits set in a word.
pub(super) fn bits(mut word: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = word.trailing_zeros();
        word &= word.wrapping_sub(1);
        (bit < 32).then_some(bit as usize)
    })
}

/// Two of a list, the first to be read.
fn two(list: &mut [Shard], from: usize, to: usize) -> (&Controller, &mut Controller) {
    if from < to {
        let (low, high) = list.split_at_mut(to);
        (&low[from].0, &mut high[0].0)
    } else {
        let (low, high) = list.split_at_mut(from);
        (&high[0].0, &mut low[to].0)
    }
}

impl Controller {
    /// How far the bounds of the largest ball reach from its place, m.
    pub(super) fn farthest_bounds(&self) -> f64 {
        let radius = self.balls.iter().map(|ball| ball.body.radius).fold(0.0, f64::max);
        radius + travel(radius, self.span)
    }
}

impl Shards {
    fn span_of(&self, ball: usize, axis: usize) -> Span {
        Span::of(self.holder(ball).broad_phase.bounds_of(ball), axis)
    }

    /// Strips lie along the side that is longer where the balls are.
    pub(super) fn choose_axis(&mut self) {
        let mut all = [Span::NOWHERE; 2];
        for ball in 0..self.owner.len() {
            for (axis, all) in all.iter_mut().enumerate() {
                all.take_in(self.span_of(ball, axis));
            }
        }
        let [x, y] = all.map(|all| all.high - all.low);
        self.axis = usize::from(y > x);
    }

    /// Deals the balls out as they lie now. Shards are alike where they share balls, and stand between phases.
    pub(super) fn cut(&mut self) {
        self.worn = false;
        self.division.cuts += 1;
        self.find_borders();
        for ball in 0..self.owner.len() {
            let Span { low, high } = self.span_of(ball, self.axis);
            let (before, had) = (usize::from(self.owner[ball]), self.members[ball]);
            let owner = self.borders.partition_point(|border| *border <= 0.5 * (low + high));
            let mut members = 1_u32 << owner;
            for shard in 0..self.list.len() {
                let from = shard.checked_sub(1).map_or(f64::NEG_INFINITY, |left| self.borders[left]);
                let to = self.borders.get(shard).copied().unwrap_or(f64::INFINITY);
                if high >= from - self.halo && low <= to + self.halo {
                    members |= 1 << shard;
                }
            }
            for shard in bits(members & !had) {
                let (from, to) = two(&mut self.list, before, shard);
                to.take_over(ball, from);
            }
            if owner != before {
                let news = |shard: &mut Shard| shard.0.share.as_mut().is_some_and(|s| s.has_news_of(ball));
                if news(&mut self.list[before])
                    && let Some(share) = &mut self.list[owner].0.share
                {
                    share.tell_news_of(ball);
                }
            }
            for shard in bits(had & !members) {
                let shard = &mut self.list[shard].0;
                shard.queue.set(ball, Next::NEVER);
                shard.broad_phase.remove(ball);
            }
            (self.owner[ball], self.members[ball]) = (owner as u8, members);
        }
        self.assign_roles();
    }

    /// As many balls in each strip.
    fn find_borders(&mut self) {
        self.middles.clear();
        for ball in 0..self.owner.len() {
            let Span { low, high } = self.span_of(ball, self.axis);
            self.middles.push(0.5 * (low + high));
        }
        let (balls, shards) = (self.middles.len(), self.list.len());
        for (place, border) in self.borders.iter_mut().enumerate() {
            let rank = (place + 1) * balls / shards;
            *border = *self.middles.select_nth_unstable_by(rank, f64::total_cmp).1;
        }
    }

    /// What each ball is to each shard, and fresh spans.
    fn assign_roles(&mut self) {
        self.beyond.iter_mut().flatten().for_each(|span| *span = Span::NOWHERE);
        for shard in &mut self.list {
            let Some(share) = &mut shard.0.share else { continue };
            share.axis = self.axis;
            for span in [&mut share.owned, &mut share.private, &mut share.below, &mut share.above] {
                *span = Span::NOWHERE;
            }
            for (role, (owner, members)) in share.role.iter_mut().zip(self.owner.iter().zip(&self.members)) {
                let (owner, here) = (usize::from(*owner), members >> share.number & 1 == 1);
                *role = match owner.cmp(&share.number) {
                    _ if !here => Role::Absent,
                    std::cmp::Ordering::Less => Role::Below,
                    std::cmp::Ordering::Greater => Role::Above,
                    std::cmp::Ordering::Equal if members.is_power_of_two() => Role::Private,
                    std::cmp::Ordering::Equal => Role::Shared,
                };
            }
        }
        for ball in 0..self.owner.len() {
            self.extend(ball);
        }
    }

    /// All spans that hold a ball's bounds go on to do so.
    pub(super) fn extend(&mut self, ball: usize) {
        let span = self.span_of(ball, self.axis);
        for shard in bits(self.members[ball]) {
            if let Some(share) = &mut self.list[shard].0.share {
                share.extend(ball, span);
            }
        }
        self.extend_beyond(ball, span);
    }

    /// The same for those who do not have it, though others do.
    pub(super) fn extend_beyond(&mut self, ball: usize, span: Span) {
        let members = self.members[ball];
        if members.count_ones() > 1 {
            let all = u32::MAX >> (32 - self.list.len());
            for shard in bits(all & !members) {
                self.beyond[usize::from(self.owner[ball])][shard].take_in(span);
            }
        }
    }

    /// Copies that went another way take over what their balls did.
    pub(super) fn mend_copies(&mut self) {
        for place in 0..self.parted.len() {
            let parting = self.parted[place];
            let (from, to) = two(&mut self.list, parting.owner, parting.shard);
            to.take_over(parting.ball, from);
            let span = self.span_of(parting.ball, self.axis);
            if let Some(share) = &mut self.list[parting.shard].0.share {
                share.extend(parting.ball, span);
            }
        }
    }
}
