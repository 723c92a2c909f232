//! Certified bounds over a whole patch: is there a normal everywhere, how steep is the floor, how tightly does it
//! curve towards the balls, how large a ball touches it in one place only. Sampling would miss a spike between
//! samples; subdivision with enclosures cannot.
//!
//! It takes about a millisecond for a bowl (316 boxes, 138 pairs of boxes), 30 to 60 ms for the pit and hill of degree
//! 10 x 10 (748 and 2682), some 10 ms for a random height field of degree 3 to 6 and 0.1 to 0.5 s for a random net of
//! degree 12 x 12. [`certify_for`] asks less: half of that or below where balls are well below the reach.

mod curvature;
mod irregular;
mod reach;
mod search;
#[cfg(test)]
mod tests;

use super::bezier::BezierPatch;
use super::derivative_nets::DerivativeNets;
use crate::tolerance::{BRACKET_FLAT, CURVATURE_MAX};
pub use irregular::{Irregular, Irregularity};
use nalgebra::Vector3;
use std::fmt;

/// What is proved about a patch. Brackets hold for the exact surface of the given net, rounding included. They are
/// as narrow as [`BRACKET_WIDTH`](crate::tolerance::BRACKET_WIDTH) and
/// [`REACH_WIDTH`](crate::tolerance::REACH_WIDTH) say, or wider where the budget of boxes ended first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// +1 if the balls' side is that of `S_u x S_v`, else -1.
    pub orientation: f64,
    /// Whether the normal exists and points up, `n . up > 0`, over the whole patch; else where it does not (or is not
    /// proved to) and why.
    pub regular: Result<(), Irregular>,
    /// Bracket of the smallest `n . up`: the cosine of the steepest slope.
    pub steepest_cosine: [f64; 2],
    /// Where the slope is steepest.
    pub steepest_at: FloorPlace,
    /// Bracket of the largest principal curvature towards the balls, 1/m; 0 where the floor is nowhere concave. Infinite
    /// unless regular.
    pub curvature: [f64; 2],
    /// Where it curves most.
    pub curvature_at: FloorPlace,
    /// Bracket of the reach, m: the least radius of a ball that lies on the floor and touches it a second time, or
    /// would if it grew. At most 1/curvature, infinite over a convex floor, from 0 unless regular. A ball whose radius
    /// is below the lower end has room wherever it lies.
    pub reach: [f64; 2],
    /// Where the ball of that radius lies, and where it touches again; one place twice if curvature decides.
    pub reach_at: [FloorPlace; 2],
    /// Boxes looked at, a measure of work: single places.
    pub boxes: usize,
    /// The same of pairs of places, for the reach.
    pub pairs: usize,
}

/// A place on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloorPlace {
    /// Parameters.
    pub uv: [f64; 2],
    /// Coordinates, m.
    pub point: Vector3<f64>,
}

impl FloorPlace {
    fn new(patch: &BezierPatch, uv: [f64; 2]) -> Self {
        Self { uv, point: patch.jet(uv[0], uv[1]).point }
    }
}

impl fmt::Display for FloorPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([u, v], p) = (self.uv, self.point);
        write!(f, "u = {u:.6}, v = {v:.6} (x = {:.6}, y = {:.6}, z = {:.6} m)", p.x, p.y, p.z)
    }
}

/// Certifies a patch whose balls' side is the one towards `up` (against gravity, any length).
pub fn certify(patch: &BezierPatch, up: &Vector3<f64>) -> Certificate {
    measured(patch, up, 0.0)
}

/// The same for balls of at most this radius, m: where it is proved that they touch once, the bracket of the reach is
/// no narrower than that needs, which takes a fraction of the time.
pub fn certify_for(patch: &BezierPatch, up: &Vector3<f64>, radius: f64) -> Certificate {
    measured(patch, up, CURVATURE_MAX / radius)
}

/// What touches at less than `ample` curvature, 1/m, is of no interest.
fn measured(patch: &BezierPatch, up: &Vector3<f64>, ample: f64) -> Certificate {
    let orientation = patch.orientation(up);
    let up = up.normalize();
    let nets = DerivativeNets::new(patch);
    let slope = curvature::steepest(&nets, orientation, &up);
    let place = |uv: Option<[f64; 2]>| FloorPlace::new(patch, uv.unwrap_or([0.5; 2]));
    let mut certificate = Certificate {
        orientation,
        regular: Ok(()),
        steepest_cosine: [-slope.upper, -slope.lower],
        steepest_at: place(slope.at),
        curvature: [0.0, f64::INFINITY],
        curvature_at: place(slope.at),
        reach: [0.0, f64::INFINITY],
        reach_at: [place(slope.at); 2],
        boxes: slope.boxes,
        pairs: 0,
    };
    if slope.upper < 0.0 {
        certificate.measure(patch, &nets, ample);
    } else {
        certificate.regular = Err(irregular::irregular(patch, orientation, &up, &slope));
    }
    certificate
}

impl Certificate {
    /// Adds what a regular floor has.
    fn measure(&mut self, patch: &BezierPatch, nets: &DerivativeNets, ample: f64) {
        let size = extent(patch);
        let flat = BRACKET_FLAT / size;
        let place = |uv: [f64; 2]| FloorPlace::new(patch, uv);
        let concave = curvature::largest_curvature(nets, self.orientation, flat);
        self.boxes += concave.boxes;
        self.curvature = [concave.lower.max(0.0), concave.upper.max(0.0)];
        self.curvature_at = place(concave.at.unwrap_or([0.5; 2]));
        let [least, most] = self.curvature;
        self.reach_at = [self.curvature_at; 2];
        self.reach[1] = least.recip();
        // Where curvature alone refuses nothing more is asked.
        if most < f64::INFINITY && (ample == 0.0 || most < ample) {
            let question = reach::Question { curvature: most, ample, size, flat };
            let touch = reach::largest_touch(nets, self.orientation, &question);
            self.pairs = touch.boxes;
            self.reach[0] = touch.upper.recip();
            if let Some(at) = touch.at {
                self.reach[1] = touch.lower.recip();
                self.reach_at = at.map(place);
            } else if let Some(open) = touch.open.filter(|_| touch.upper == f64::INFINITY) {
                self.reach_at = [open.contact, open.touch].map(|r| place(r.middle()));
            }
        }
    }
}

/// Diagonal of the net's bounding box, m.
fn extent(patch: &BezierPatch) -> f64 {
    let first = patch.net()[0];
    let [low, high] = patch.net().iter().fold([first, first], |[low, high], p| [low.inf(p), high.sup(p)]);
    (high - low).norm()
}
