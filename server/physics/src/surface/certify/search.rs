//! Branch and bound: the largest value of a function over boxes, bracketed.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A part of what is searched, and what is known there.
pub struct Part<B, P> {
    /// Which.
    pub place: B,
    /// The function is nowhere above this here.
    pub upper: f64,
    /// A value that is reached here (or a number below it), and where.
    pub sample: Option<(f64, P)>,
}

/// Bracket of a maximum.
pub struct Maximum<B, P> {
    /// The function is nowhere above.
    pub upper: f64,
    /// It is reached at `at`.
    pub lower: f64,
    /// Where; None while the starting value is the best.
    pub at: Option<P>,
    /// The most promising part left when the search ended; none if every part was ruled out.
    pub open: Option<B>,
    /// Parts looked at, a measure of work.
    pub boxes: usize,
}

struct Candidate<B> {
    upper: f64,
    depth: u32,
    place: B,
}

impl<B: Ord> Ord for Candidate<B> {
    /// Highest first; among equals the smallest, so that a degenerate place is run to ground before others are opened; then
    /// by place, so that the order is total.
    fn cmp(&self, other: &Self) -> Ordering {
        self.upper
            .total_cmp(&other.upper)
            .then_with(|| self.depth.cmp(&other.depth))
            .then_with(|| other.place.cmp(&self.place))
    }
}
impl<B: Ord> PartialOrd for Candidate<B> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl<B: Ord> PartialEq for Candidate<B> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl<B: Ord> Eq for Candidate<B> {}

/// The larger of `known` and the maximum over `roots`, highest bound first, until `enough(lower, upper)`, a part
/// cannot be split (`split` returns None), or `budget` parts have been looked at. `split` is told the best value so
/// far and need not return parts that stay below it.
pub fn maximise<B: Ord, P>(
    roots: impl IntoIterator<Item = B>,
    known: f64,
    budget: usize,
    mut split: impl FnMut(&B, f64) -> Option<Vec<Part<B, P>>>,
    enough: impl Fn(f64, f64) -> bool,
) -> Maximum<B, P> {
    let mut found = Maximum { upper: known, lower: known, at: None, open: None, boxes: 0 };
    let root = |place| Candidate { upper: f64::INFINITY, depth: 0, place };
    let mut heap: BinaryHeap<_> = roots.into_iter().map(root).collect();
    // With nothing left above the best value, that value is the maximum.
    while let Some(top) = heap.pop() {
        let upper = top.upper.max(found.lower);
        let parts = if enough(found.lower, upper) || found.boxes >= budget {
            None
        } else {
            split(&top.place, found.lower)
        };
        let Some(parts) = parts else {
            found.upper = upper;
            found.open = Some(top.place);
            return found;
        };
        for part in parts {
            found.boxes += 1;
            if let Some((value, at)) = part.sample
                && value > found.lower
            {
                found.lower = value;
                found.at = Some(at);
            }
            if part.upper > found.lower {
                let upper = part.upper.min(top.upper);
                heap.push(Candidate { upper, depth: top.depth + 1, place: part.place });
            }
        }
    }
    found.upper = found.lower;
    found
}
