//! The largest ball that touches the floor in one place only, by branch and bound over pairs of places.
//!
//! A ball of radius R that lies on the floor at p touches it again at q where
//! |S(q) - S(p)|^2 = 2 R n(p) . (S(q) - S(p)). With x = S(q) - S(p) the reach is therefore R* = 1/sup g,
//!
//! ```text
//! g(p, q) = 2 n(p) . x / |x|^2,      g -> n . S_dd / |S_d|^2   for q -> p along d,
//! ```
//!
//! so that sup g is at least the largest concave curvature k. Three bounds make the search short:
//!
//! * far pairs: g itself in affine forms of four variables;
//! * near pairs, whose x may vanish: with both places in one box, x = D d and n . x = n . B(d, d)/2, where D is the
//!   mean of S' from p to q and B the mean of S'' weighted towards p. So g is at most the larger eigenvalue of the
//!   pencil (n . B, D^T D). The means of an affine function are its values at (p + q)/2 and at (2 p + q)/3: the
//!   excess falls with the box squared, as that of the curvature does;
//! * where g exceeds k and p is not on a border, g can be largest only if x is parallel to n(p). Moving p by d changes
//!   1/g in proportion to -x . (d - W d/g), W the Weingarten map, and 1 - W/g is regular. So pairs whose x certainly
//!   has a tangential part need no bound at all. It is what spares the search the whole diagonal: near it x is all
//!   but tangential. Only places of contact on the four borders are searched in full.
//!
//! On a floor that is a graph over its rectangle a second touch needs a border or a steep flank, and R* = 1/k nearly
//! always; on a net that overlaps itself the sheets' distance decides.

use super::curvature::{ShapeOperator, steepest_corner, unit_normal};
use super::search::{Maximum, Part, maximise};
use crate::surface::affine::{Affine, cross, dot};
use crate::surface::derivative_nets::{DerivativeNets, Derivatives, Rectangle};
use crate::tolerance::{REACH_PAIRS_MAX, REACH_WIDTH};
use std::collections::BTreeMap;
use std::rc::Rc;

/// A box of contact places and one of second places.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Pair {
    /// Where the ball lies.
    pub contact: Rectangle,
    /// Where it may touch again.
    pub touch: Rectangle,
    rank: Rank,
}

/// Which contacts of a box count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Rank {
    /// Those on no border.
    Inner,
    /// Those on one border, across which this parameter changes, towards the floor by this sign.
    Border(usize, i8),
    /// All.
    Corner,
}

/// Where a ball this many times smaller than the floor and its curvature allow touches twice, the floor meets itself.
const MEETS: f64 = 1e4;

/// Parameters of a contact and of a second touch.
pub type Places = [[f64; 2]; 2];

/// What is asked about sup g.
pub struct Question {
    /// A certified upper bound of the largest curvature, 1/m: sup g is that or more.
    pub curvature: f64,
    /// Only whether sup g is above this, 1/m; 0 for its bracket.
    pub ample: f64,
    /// The floor's size, m.
    pub size: f64,
    /// A bracket this narrow is narrow enough, 1/m.
    pub flat: f64,
}

/// Bracket of the largest of sup g, the curvature and what is ample.
pub fn largest_touch(nets: &DerivativeNets, side: f64, question: &Question) -> Maximum<Pair, Places> {
    let Question { curvature, ample, size, flat } = *question;
    let inner = Pair { contact: Rectangle::WHOLE, touch: Rectangle::WHOLE, rank: Rank::Inner };
    let borders = [0, 1, 2, 3].map(|k| {
        let rank = Rank::Border(k / 2, [1, -1][k % 2]);
        Pair { contact: Rectangle::BORDERS[k], rank, ..inner }
    });
    let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]].map(|signs| Pair {
        contact: Rectangle::WHOLE.corner_box(signs),
        rank: Rank::Corner,
        ..inner
    });
    let mut floor = Met { nets, side, size, pieces: BTreeMap::new(), hulls: BTreeMap::new() };
    let enough = |lower: f64, upper: f64| {
        let meets = lower > MEETS * curvature.max(size.recip());
        let decided = ample > curvature && lower > ample;
        let narrow = ample <= curvature && upper < f64::INFINITY;
        meets || decided || (narrow && upper - lower <= (REACH_WIDTH * upper).max(flat))
    };
    maximise(
        borders.into_iter().chain(corners).chain([inner]),
        curvature.max(ample),
        REACH_PAIRS_MAX,
        |pair, known| floor.split(pair, known),
        enough,
    )
}

/// What is known of the floor on one box.
struct Piece {
    point: [Affine; 3],
    /// `S_u` and `S_v`.
    tangents: [[Affine; 3]; 2],
    /// Unit normal on the balls' side.
    normal: Option<[Affine; 3]>,
}

/// The floor's pieces met so far.
struct Met<'a> {
    nets: &'a DerivativeNets,
    side: f64,
    size: f64,
    pieces: BTreeMap<Rectangle, Rc<Piece>>,
    /// Derivatives on boxes around pairs.
    hulls: BTreeMap<Rectangle, Rc<Derivatives<Affine>>>,
}

/// g as far as it is known on a pair of boxes.
struct Chord {
    /// S(q) - S(p).
    x: [Affine<4>; 3],
    normal: [Affine<4>; 3],
    /// n(p) . x.
    height: Affine<4>,
    /// g; None where x may vanish.
    g: Option<Affine<4>>,
}

impl Chord {
    /// None if no ball above p reaches up to q.
    fn new(contact: &Piece, touch: &Piece, normal: [Affine; 3]) -> Option<Self> {
        let x: [Affine<4>; 3] = std::array::from_fn(|k| touch.point[k].joint(1) - contact.point[k].joint(0));
        let normal = normal.map(|component| component.joint(0));
        let height = dot(&x, &normal);
        let g = dot(&x, &x).recip().map(|inverse| height.scaled(2.0) * inverse);
        (height.range()[1] > 0.0).then_some(Self { x, normal, height, g })
    }
}

impl Met<'_> {
    fn piece(&mut self, place: Rectangle) -> Rc<Piece> {
        let (nets, side) = (self.nets, self.side);
        let piece = self.pieces.entry(place).or_insert_with(|| {
            let [point, u, v] = nets.first(&place);
            let normal = unit_normal(&u, &v).map(|n| n.map(|component| component.scaled(side)));
            Rc::new(Piece { point, tangents: [u, v], normal })
        });
        piece.clone()
    }

    /// The halves of a pair that may hold more than `known`, cut where the chord changes most.
    fn split(&mut self, pair: &Pair, known: f64) -> Option<Vec<Part<Pair, Places>>> {
        let contact = self.piece(pair.contact);
        let touch = self.piece(pair.touch);
        let radius = self.size.min(known.recip());
        let swing =
            |vector: &[Affine; 3], d: usize| vector.iter().map(|a| a.slope[d].powi(2)).sum::<f64>().sqrt();
        let mut best: Option<(f64, [Pair; 2])> = None;
        for d in 0..2 {
            let turn = contact.normal.map_or(0.0, |normal| swing(&normal, d));
            let of_contact = swing(&contact.point, d) + radius * turn;
            let of_touch = swing(&touch.point, d);
            let cuts = [
                (of_contact, pair.contact.halves(d).map(|cut| cut.map(|contact| Pair { contact, ..*pair }))),
                (of_touch, pair.touch.halves(d).map(|cut| cut.map(|touch| Pair { touch, ..*pair }))),
            ];
            for (gain, halves) in cuts {
                if let Some(halves) = halves
                    && best.is_none_or(|(most, _)| gain > most)
                {
                    best = Some((gain, halves));
                }
            }
        }
        let (_, halves) = best?;
        Some(halves.into_iter().map(|half| self.look(half, known)).collect())
    }

    /// What a pair may hold, with -infinity for nothing above `known`.
    fn look(&mut self, place: Pair, known: f64) -> Part<Pair, Places> {
        let nothing = Part { place, upper: f64::NEG_INFINITY, sample: None };
        let contact = self.piece(place.contact);
        let touch = self.piece(place.touch);
        let farthest = 2.0 / distance(&contact.point, &touch.point);
        let Some(normal) = contact.normal.filter(|_| farthest > known) else {
            let upper = if farthest > known { farthest } else { f64::NEG_INFINITY };
            return Part { upper, ..nothing };
        };
        let Some(chord) = Chord::new(&contact, &touch, normal) else { return nothing };
        let [u, v] = &contact.tangents;
        let ruled_out = match place.rank {
            Rank::Inner => chord.is_oblique(&contact.tangents),
            Rank::Border(across, sign) => {
                let inward = if across == 0 { cross(v, &normal) } else { cross(&normal, u) };
                let inward = inward.map(|form| form.scaled(self.side * f64::from(sign)).joint(0));
                dot(&chord.x, &inward).range()[0] > 0.0
            }
            Rank::Corner => false,
        };
        if ruled_out {
            return nothing;
        }
        let mut upper = chord.g.map_or(farthest, |g| g.range()[1].min(farthest));
        if upper > known && (place.rank == Rank::Inner || place.contact.is_near(&place.touch)) {
            match self.near(&place, &chord.normal) {
                Near::Oblique => return nothing,
                Near::Upper(bound) => upper = upper.min(bound),
            }
        }
        // Where x may vanish the highest q is the best guess.
        let guess = chord.g.unwrap_or(chord.height);
        let corner = steepest_corner(&CORNERS, |s| guess.at(s));
        let promising = upper > known && chord.g.is_none_or(|g| g.at(corner) > known);
        let sample = promising.then(|| self.sample(&place, corner)).flatten();
        Part { place, upper, sample }
    }

    /// A number that g reaches at a corner of a pair.
    fn sample(&mut self, place: &Pair, [a, b, c, d]: [f64; 4]) -> Option<(f64, Places)> {
        let contact = place.contact.corner_box([a, b]);
        let touch = place.touch.corner_box([c, d]);
        let (p, q) = (self.piece(contact), self.piece(touch));
        let g = Chord::new(&p, &q, p.normal?)?.g?;
        Some((g.range()[0], [contact.middle(), touch.middle()]))
    }

    /// The bound by second derivatives over a box that holds both places.
    fn near(&mut self, place: &Pair, normal: &[Affine<4>; 3]) -> Near {
        let hull = place.contact.hull(&place.touch).rounded();
        let ends = [place.contact.within(&hull), place.touch.within(&hull)];
        // The place (1 - share) p + share q.
        let between = |share: f64| -> [Affine<4>; 2] {
            std::array::from_fn(|d| {
                let end = |k: usize| {
                    let mut slope = [0.0; 2];
                    slope[d] = ends[k][d][1];
                    Affine { center: ends[k][d][0], slope, radius: 0.0 }.joint(k)
                };
                end(0) * Affine::number(1.0 - share, 0.0) + end(1) * Affine::number(share, 0.0)
            })
        };
        let nets = self.nets;
        let whole = self.hulls.entry(hull).or_insert_with(|| Rc::new(nets.enclosures(&hull))).clone();
        let [middle, third] = [between(0.5), between(1.0 / 3.0)];
        let mean = |vector: &[Affine; 3], place: &[Affine<4>; 2]| vector.map(|form| form.composed(place));
        let first = [&whole.u, &whole.v].map(|form| mean(form, &middle));
        if place.rank == Rank::Inner {
            // x = D d has tangential part S'(p)^T D d, which vanishes for d = 0 only if that matrix is regular; its
            // determinant is the product of the two normals.
            let mean_normal = cross(&first[0], &first[1]).map(|form| form.scaled(self.side));
            if dot(&mean_normal, normal).range()[0] > 0.0 {
                return Near::Oblique;
            }
        }
        let second = [&whole.uu, &whole.uv, &whole.vv].map(|form| mean(form, &third));
        let shape = ShapeOperator::new([&first[0], &first[1]], second.each_ref(), normal);
        Near::Upper(shape.map_or(f64::INFINITY, |shape| shape.largest(&CORNERS).0))
    }
}

impl Chord {
    /// Whether x certainly has a tangential part at p.
    fn is_oblique(&self, tangents: &[[Affine; 3]; 2]) -> bool {
        tangents.iter().any(|tangent| {
            let [low, high] = dot(&self.x, &tangent.map(|component| component.joint(0))).range();
            low > 0.0 || high < 0.0
        })
    }
}

/// What is known of places in one box.
enum Near {
    /// No x but 0 is parallel to the normal.
    Oblique,
    /// g is nowhere above.
    Upper(f64),
}

/// The corners of a box in four variables.
const CORNERS: [[f64; 4]; 16] = {
    let mut corners = [[-1.0; 4]; 16];
    let mut k = 0;
    while k < 16 {
        let mut d = 0;
        while d < 4 {
            if k >> d & 1 == 1 {
                corners[k][d] = 1.0;
            }
            d += 1;
        }
        k += 1;
    }
    corners
};

/// Smallest distance of two boxes' bounds, m.
fn distance(a: &[Affine; 3], b: &[Affine; 3]) -> f64 {
    let gap = |k: usize| {
        let ([low, high], [other_low, other_high]) = (a[k].range(), b[k].range());
        (other_low - high).max(low - other_high).max(0.0)
    };
    // Rounded down.
    (1.0 - 1e-14) * (0..3).map(|k| gap(k).powi(2)).sum::<f64>().sqrt()
}
