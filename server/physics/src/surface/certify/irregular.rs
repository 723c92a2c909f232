//! Why a floor has no upward normal somewhere, as far as that is certain.

use super::FloorPlace;
use super::search::Maximum;
use crate::surface::bezier::BezierPatch;
use crate::surface::derivative_nets::Rectangle;
use nalgebra::Vector3;
use std::fmt;

/// A place near which the floor has no upward normal, or is not proved to have one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Irregular {
    /// What is wrong there.
    pub kind: Irregularity,
    /// Where.
    pub at: FloorPlace,
}

/// What is wrong with a floor at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Irregularity {
    /// A border (`u = 0`, `u = 1`, `v = 0` or `v = 1`) is one point.
    CollapsedEdge(&'static str),
    /// `S_u x S_v` vanishes and points the other way beyond.
    Fold,
    /// The floor is vertical and hangs over beyond.
    Overhang,
    /// `S_u x S_v` vanishes: a cusp, or a net with no area.
    NoNormal,
    /// Nothing was found, but the search's budget ended before it was ruled out.
    Unproved,
}

impl fmt::Display for Irregularity {
    /// What the floor does or is.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CollapsedEdge(border) => write!(f, "has no normal: its border {border} is a single point"),
            Self::Fold => f.write_str("folds back on itself: its normal turns over"),
            Self::Overhang => f.write_str("is vertical and hangs over beyond"),
            Self::NoNormal => f.write_str("has no normal: S_u x S_v vanishes"),
            Self::Unproved => f.write_str("is too nearly degenerate to be certified"),
        }
    }
}

/// `S_u x S_v` shorter than this, relative to the longest looked at, is none. Bisection leaves 1e-15 of it.
const NO_AREA: f64 = 1e-9;
/// Control points of a border that is one point are this close, relative to the net.
const ONE_POINT: f64 = 1e-12;
/// A box this close to a border in u or v is there because of it.
const BESIDE: f64 = 1e-6;

/// What the search for the steepest slope ran into.
pub fn irregular(
    patch: &BezierPatch,
    orientation: f64,
    up: &Vector3<f64>,
    slope: &Maximum<Rectangle, [f64; 2]>,
) -> Irregular {
    let cross = |[u, v]: [f64; 2]| {
        let jet = patch.jet(u, v);
        jet.du.cross(&jet.dv)
    };
    let name = |kind, uv| Irregular { kind, at: FloorPlace::new(patch, uv) };
    let middle = [0.5, 0.5];
    let steepest = slope.at.unwrap_or(middle);
    if slope.lower >= 0.0 {
        // Proved to face down, while the middle does not: between them it turns.
        let turn = turn(middle, steepest, |uv| orientation * cross(uv).dot(up) > 0.0);
        let area = cross(middle).norm().max(cross(steepest).norm());
        let kind =
            if cross(turn).norm() <= NO_AREA * area { Irregularity::Fold } else { Irregularity::Overhang };
        return name(kind, turn);
    }
    let at = slope.open.as_ref().map_or(steepest, Rectangle::middle);
    if let Some(border) = collapsed_border(patch, at) {
        return name(Irregularity::CollapsedEdge(border), at);
    }
    let jet = patch.jet(at[0], at[1]);
    let extent = super::extent(patch);
    let vanishes = jet.du.cross(&jet.dv).norm() <= NO_AREA * extent * extent;
    name(if vanishes { Irregularity::NoNormal } else { Irregularity::Unproved }, at)
}

/// The place between two where `upward` ends, by bisection.
fn turn(mut upper: [f64; 2], mut lower: [f64; 2], upward: impl Fn([f64; 2]) -> bool) -> [f64; 2] {
    for _ in 0..60 {
        let middle = [0, 1].map(|k| 0.5 * (upper[k] + lower[k]));
        if upward(middle) {
            upper = middle;
        } else {
            lower = middle;
        }
    }
    lower
}

/// The border next to a place, if all its control points are one.
fn collapsed_border(patch: &BezierPatch, [u, v]: [f64; 2]) -> Option<&'static str> {
    let close = ONE_POINT * super::extent(patch);
    let [p, q] = patch.degree();
    let row = |i: usize| -> Vec<Vector3<f64>> { (0..=q).map(|j| patch.point(i, j)).collect() };
    let column = |j: usize| -> Vec<Vector3<f64>> { (0..=p).map(|i| patch.point(i, j)).collect() };
    let borders = [
        ("u = 0", u, row(0)),
        ("u = 1", 1.0 - u, row(p)),
        ("v = 0", v, column(0)),
        ("v = 1", 1.0 - v, column(q)),
    ];
    let collapsed = |points: &[Vector3<f64>]| points.iter().all(|point| (point - points[0]).norm() <= close);
    borders
        .iter()
        .find(|(_, distance, points)| *distance < BESIDE && collapsed(points))
        .map(|(border, ..)| *border)
}
