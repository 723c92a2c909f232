//! Certified bounds over a whole patch: is there a normal everywhere, how steep is the floor, how tightly does it
//! curve towards the balls. Sampling would miss a spike between samples; subdivision with enclosures cannot.

use super::affine::Affine;
use super::bezier::BezierPatch;
use super::derivative_nets::{DerivativeNets, Derivatives, Rectangle};
use crate::tolerance::{BRACKET_BOXES_MAX, BRACKET_FLAT, BRACKET_HALVINGS_MAX, BRACKET_WIDTH};
use nalgebra::Vector3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// What is proved about a patch. Brackets hold for the exact surface of the given net, rounding included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// +1 if the balls' side is that of `S_u x S_v`, else -1.
    pub orientation: f64,
    /// Whether the normal exists and points up, `n . up > 0`, over the whole patch; else a place near which it does not
    /// (or is not proved to).
    pub regular: Result<(), [f64; 2]>,
    /// Bracket of the smallest `n . up`: the cosine of the steepest slope.
    pub steepest_cosine: [f64; 2],
    /// Where the slope is steepest.
    pub steepest_at: [f64; 2],
    /// Bracket of the largest principal curvature towards the balls, 1/m; 0 where the floor is nowhere concave. A
    /// ball of radius r has room everywhere if r times the upper end is below 1. Infinite unless regular.
    pub curvature: [f64; 2],
    /// Where it curves most.
    pub curvature_at: [f64; 2],
    /// Bracket of the largest principal curvature away from the balls, 1/m; 0 where the floor is nowhere convex.
    pub convex_curvature: [f64; 2],
    /// Boxes looked at, a measure of work.
    pub boxes: usize,
}

/// Certifies a patch whose balls' side is the one towards `up` (against gravity, any length).
pub fn certify(patch: &BezierPatch, up: &Vector3<f64>) -> Certificate {
    let orientation = patch.orientation(up);
    let up = up.normalize();
    let nets = DerivativeNets::new(patch);
    let cosine = |d: &Derivatives<Affine>| -> Bound {
        let cross = d.cross();
        let against = dot_number(&cross, &up).scaled(-orientation);
        let Some(value) = dot(&cross, &cross).sqrt().and_then(Affine::recip).map(|inverse| against * inverse)
        else {
            return Bound::UNKNOWN;
        };
        Bound { upper: value.range()[1], lower: value.range()[0], corner: steepest_corner(|s| value.at(s)) }
    };
    let slope = maximise(&nets, cosine, |lower, upper| {
        // Once some slope is proved vertical nothing more is asked.
        lower >= 0.0 || (upper < 0.0 && upper - lower <= BRACKET_WIDTH * lower.abs())
    });
    let regular = if slope.upper < 0.0 { Ok(()) } else { Err(slope.at) };
    let [curvature, convex] = [orientation, -orientation].map(|side| match regular {
        Ok(()) => largest_curvature(patch, &nets, side),
        Err(at) => Maximum { upper: f64::INFINITY, lower: 0.0, at, boxes: 0 },
    });
    Certificate {
        orientation,
        regular,
        steepest_cosine: [-slope.upper, -slope.lower],
        steepest_at: slope.at,
        curvature: [curvature.lower.max(0.0), curvature.upper.max(0.0)],
        curvature_at: curvature.at,
        convex_curvature: [convex.lower.max(0.0), convex.upper.max(0.0)],
        boxes: slope.boxes + curvature.boxes + convex.boxes,
    }
}

/// Bracket of the largest principal curvature towards one side (+1 or -1) of `S_u x S_v`.
fn largest_curvature(patch: &BezierPatch, nets: &DerivativeNets, side: f64) -> Maximum {
    let flat = BRACKET_FLAT / extent(patch);
    maximise(
        nets,
        |d| curvature_bound(d, side).unwrap_or(Bound::UNKNOWN),
        |lower, upper| upper < f64::INFINITY && upper - lower.max(0.0) <= (BRACKET_WIDTH * upper).max(flat),
    )
}

/// Diagonal of the net's bounding box, m.
fn extent(patch: &BezierPatch) -> f64 {
    let first = patch.net()[0];
    let [low, high] = patch.net().iter().fold([first, first], |[low, high], p| [low.inf(p), high.sup(p)]);
    (high - low).norm()
}

/// What is known of a function on a box.
#[derive(Clone, Copy, Debug)]
struct Bound {
    /// It is nowhere above.
    upper: f64,
    /// On a box that is a point: it is not below.
    lower: f64,
    /// The corner at which it is probably largest.
    corner: [f64; 2],
}

impl Bound {
    const UNKNOWN: Self = Self { upper: f64::INFINITY, lower: f64::NEG_INFINITY, corner: [-1.0; 2] };
}

const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];

fn steepest_corner(value: impl Fn([f64; 2]) -> f64) -> [f64; 2] {
    CORNERS.into_iter().max_by(|a, b| value(*a).total_cmp(&value(*b))).unwrap_or([-1.0; 2])
}

fn dot(a: &[Affine; 3], b: &[Affine; 3]) -> Affine {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn dot_number(a: &[Affine; 3], b: &Vector3<f64>) -> Affine {
    let number = |k: usize| Affine::number(b[k], 0.0);
    a[0] * number(0) + a[1] * number(1) + a[2] * number(2)
}

/// Bound of the larger eigenvalue of the shape operator. In the orthonormal frame that begins with `S_u` it is the
/// symmetric matrix [a b; b d] with, for C = `S_u x S_v`, J = |C| and f = F/E:
/// a = L/E, b = (M - f L)/J, d = (N - 2 f M + f^2 L) E/J^2, where L J = `S_uu . C` and so on.
/// The larger eigenvalue is convex in the matrix, so its affine part is largest at a corner; the rest moves it by no more
/// than the norm of the matrix of radii. None where the chart may be singular.
fn curvature_bound(d: &Derivatives<Affine>, side: f64) -> Option<Bound> {
    let cross = d.cross();
    let e = dot(&d.u, &d.u);
    let inverse_e = e.recip()?;
    let inverse_j = dot(&cross, &cross).sqrt()?.recip()?;
    let f = dot(&d.u, &d.v) * inverse_e;
    let [l, m, n] = [&d.uu, &d.uv, &d.vv].map(|second| dot(second, &cross).scaled(side));
    let over_j2 = inverse_j * inverse_j;
    let sheared = m - f * l;
    let matrix =
        [l * inverse_e * inverse_j, sheared * over_j2, (n - f * (m + sheared)) * (e * over_j2) * inverse_j];
    let at = |corner| larger_eigenvalue(matrix.map(|entry| entry.at(corner)));
    let corner = steepest_corner(at);
    let radius = larger_eigenvalue(matrix.map(|entry| entry.radius));
    let rounding =
        1e-14 * matrix.iter().map(|entry| entry.center.abs() + entry.at(corner).abs()).sum::<f64>();
    let [upper, lower] = [at(corner) + radius + rounding, at(corner) - radius - rounding];
    (upper.is_finite() && lower.is_finite()).then_some(Bound { upper, lower, corner })
}

fn larger_eigenvalue([a, b, d]: [f64; 3]) -> f64 {
    let half = 0.5 * (a - d);
    0.5 * (a + d) + (half * half + b * b).sqrt()
}

/// Bracket of a maximum over the patch.
struct Maximum {
    upper: f64,
    lower: f64,
    at: [f64; 2],
    boxes: usize,
}

/// A box that may hold the maximum.
struct Candidate {
    upper: f64,
    place: Rectangle,
}

impl Ord for Candidate {
    /// Highest first; among equals the smallest, so that a degenerate place is run to ground before others are opened; then
    /// by place, so that the order is total.
    fn cmp(&self, other: &Self) -> Ordering {
        let halvings = |c: &Self| c.place.halvings[0] + c.place.halvings[1];
        self.upper
            .total_cmp(&other.upper)
            .then_with(|| halvings(self).cmp(&halvings(other)))
            .then_with(|| other.place.index.cmp(&self.place.index))
    }
}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Candidate {}

/// Branch and bound, highest bound first, until `enough(lower, upper)`, a box cannot be split, or the budget is spent.
fn maximise(
    nets: &DerivativeNets,
    bound: impl Fn(&Derivatives<Affine>) -> Bound,
    enough: impl Fn(f64, f64) -> bool,
) -> Maximum {
    let mut found = Maximum { upper: f64::INFINITY, lower: f64::NEG_INFINITY, at: [0.5; 2], boxes: 0 };
    let mut heap = BinaryHeap::from([Candidate { upper: f64::INFINITY, place: Rectangle::WHOLE }]);
    loop {
        // With nothing left above the best sample, that sample is the maximum.
        let Some(top) = heap.pop() else {
            found.upper = found.lower;
            break;
        };
        found.upper = top.upper;
        let splittable = top.place.halvings.iter().all(|h| *h < BRACKET_HALVINGS_MAX);
        if enough(found.lower, found.upper.max(found.lower))
            || found.boxes >= BRACKET_BOXES_MAX
            || !splittable
        {
            if found.upper == f64::INFINITY {
                found.at = top.place.middle();
            }
            break;
        }
        for (place, derivatives) in nets.halves(&top.place) {
            found.boxes += 1;
            let here = bound(&derivatives.enclosures());
            let sample = bound(&derivatives.corner(here.corner));
            if sample.lower > found.lower {
                found.lower = sample.lower;
                found.at = place.corner(here.corner);
            }
            if here.upper > found.lower {
                heap.push(Candidate { upper: here.upper.min(top.upper), place });
            }
        }
    }
    found.upper = found.upper.max(found.lower);
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Largest curvature and smallest n . up over a grid of samples, ends included.
    fn sampled(patch: &BezierPatch, orientation: f64, cells: usize) -> [f64; 2] {
        let mut found = [f64::NEG_INFINITY, f64::INFINITY];
        for i in 0..=cells {
            for j in 0..=cells {
                let jet = patch.jet(i as f64 / cells as f64, j as f64 / cells as f64);
                let normal = jet.normal(orientation).unwrap();
                let curvature = jet.fundamental_forms(&normal).principal_curvatures()[0];
                found = [found[0].max(curvature), found[1].min(normal.z)];
            }
        }
        found
    }

    /// The certificate, once it agrees with samples and its brackets are narrow.
    fn assert_holds(patch: &BezierPatch) -> Certificate {
        let certificate = certify(patch, &Vector3::z());
        assert_eq!(certificate.regular, Ok(()));
        let [low, high] = certificate.curvature;
        let [curvature, cosine] = sampled(patch, certificate.orientation, 60);
        assert!(curvature <= high, "{curvature} above {certificate:?}");
        assert!(low <= high && high - low <= (1e-3 * high).max(1e-5), "{certificate:?}");
        let [least, most] = certificate.steepest_cosine;
        assert!(least <= most && least <= cosine && most - least < 1e-3 * most, "{cosine} {certificate:?}");
        let at = certificate.curvature_at;
        if low > 0.0 {
            let jet = patch.jet(at[0], at[1]);
            let normal = jet.normal(certificate.orientation).unwrap();
            let there = jet.fundamental_forms(&normal).principal_curvatures()[0];
            assert!((there - low).abs() <= 1e-9 * there.abs().max(1.0), "{there} {certificate:?}");
        }
        certificate
    }

    /// The floor of the program this one grew out of: degree 10 x 10, a pit and a hill.
    fn pit_and_hill() -> BezierPatch {
        let mut heights = vec![vec![0.0; 11]; 11];
        heights[5][3] = -70.0;
        heights[5][7] = 40.0;
        BezierPatch::from_heights([-10.0, 10.0], [-10.0, 10.0], &heights).unwrap()
    }

    #[test]
    fn the_pit_and_hill_has_its_known_radius_and_slope() {
        let certificate = assert_holds(&pit_and_hill());
        let radius = 1.0 / certificate.curvature[1];
        assert!((radius - 1.613).abs() < 1e-3, "{certificate:?}");
        let degrees = certificate.steepest_cosine[0].acos().to_degrees();
        assert!((degrees - 52.7).abs() < 0.05, "{degrees}");
        assert!(certificate.boxes < 20_000, "{certificate:?}");
    }

    #[test]
    fn the_other_side_of_the_pit_and_hill_has_its_known_convex_radius() {
        let convex = certify(&pit_and_hill(), &Vector3::z()).convex_curvature;
        assert!((1.0 / convex[1] - 1.738).abs() < 1e-3);
    }

    #[test]
    fn a_mirrored_floor_has_the_same_certificate() {
        let patch = pit_and_hill();
        let net = patch.net().iter().map(|p| Vector3::new(-p.x, p.y, p.z)).collect();
        let mirrored = certify(&BezierPatch::new(patch.degree(), net).unwrap(), &Vector3::z());
        let straight = certify(&patch, &Vector3::z());
        assert_eq!(mirrored, Certificate { orientation: -1.0, ..straight });
    }

    #[test]
    fn a_paraboloid_curves_most_at_its_vertex() {
        let terms = [vec![0.0, 0.0, 0.25], vec![], vec![0.75]];
        let patch = BezierPatch::from_polynomial([-1.0, 2.0], [-1.0, 1.0], &terms).unwrap();
        let certificate = assert_holds(&patch);
        assert!(certificate.curvature[0] <= 1.5 && 1.5 <= certificate.curvature[1]);
        assert!((certificate.curvature_at[0] - 1.0 / 3.0).abs() < 0.01, "{certificate:?}");
    }

    #[test]
    fn what_is_nowhere_concave_has_curvature_zero() {
        let plane =
            BezierPatch::from_polynomial([-3.0, 1.0], [0.0, 1.0], &[vec![0.0, 0.5], vec![-0.3]]).unwrap();
        let [low, high] = assert_holds(&plane).curvature;
        assert!(low == 0.0 && high < 1e-6);
        let dome = BezierPatch::from_polynomial(
            [-1.0, 1.0],
            [-1.0, 1.0],
            &[vec![0.0, 0.0, -1.0], vec![], vec![-0.5]],
        );
        assert_eq!(assert_holds(&dome.unwrap()).curvature, [0.0, 0.0]);
        let ridge =
            BezierPatch::from_polynomial([-1.0, 1.0], [-1.0, 1.0], &[vec![], vec![], vec![-0.5]]).unwrap();
        let [low, high] = assert_holds(&ridge).curvature;
        assert!(low == 0.0 && high < 1e-6);
    }

    #[test]
    fn a_trough_is_bracketed_along_its_whole_length() {
        let terms = [vec![], vec![], vec![2.0]];
        let patch = BezierPatch::from_polynomial([-1.0, 1.5], [-20.0, 20.0], &terms).unwrap();
        let [low, high] = assert_holds(&patch).curvature;
        assert!(low <= 4.0 && 4.0 <= high);
    }

    #[test]
    fn a_spike_between_the_samples_of_a_fine_grid_is_caught() {
        // In a deep valley the floor turns within a millimetre, and beside it the slope hides the bend.
        let terms = [vec![0.0, 0.0, 300.0], vec![], vec![500.0]];
        let patch = BezierPatch::from_polynomial([-1.0, 1.01], [-1.02, 1.0], &terms).unwrap();
        let coarse = sampled(&patch, 1.0, 64)[0];
        let certificate = certify(&patch, &Vector3::z());
        assert!(coarse < 200.0, "not a spike: {coarse}");
        let [low, high] = certificate.curvature;
        assert!(low <= 1000.0 && 1000.0 <= high && high - low < 1.0, "{certificate:?}");
    }

    #[test]
    fn a_collapsed_edge_is_named() {
        let net = (0..9).map(|n| {
            let (i, j) = (n / 3, n % 3);
            Vector3::new(f64::from(i), if i == 0 { 0.0 } else { f64::from(j) }, 0.0)
        });
        let patch = BezierPatch::new([2, 2], net.collect()).unwrap();
        let [u, _] = certify(&patch, &Vector3::z()).regular.unwrap_err();
        assert!(u < 1e-6);
    }

    #[test]
    fn a_fold_and_an_overhang_are_named() {
        let fold = [0.0, 2.0, -1.0, 1.0].map(|x| [0.0, 1.0].map(|y| Vector3::new(x, y, 0.0))).concat();
        assert!(certify(&BezierPatch::new([3, 1], fold).unwrap(), &Vector3::z()).regular.is_err());
        let overhang = [[0.0, 0.0], [1.5, 0.0], [-0.5, 1.0], [1.0, 1.0]]
            .map(|[x, z]| [0.0, 1.0].map(|y| Vector3::new(x, y, z)));
        let certificate = certify(&BezierPatch::new([3, 1], overhang.concat()).unwrap(), &Vector3::z());
        assert!(certificate.regular.is_err());
        assert_eq!(certificate.curvature[1], f64::INFINITY);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn no_sample_of_a_random_floor_lies_outside_its_certificate(
            heights in (2..=7_usize, 2..=7_usize).prop_flat_map(|(rows, columns)|
                prop::collection::vec(prop::collection::vec(-1.0..1.0_f64, columns), rows)),
            width in 1.0..4.0_f64,
        ) {
            assert_holds(&BezierPatch::from_heights([-width, width], [0.0, 3.0], &heights).unwrap());
        }

        #[test]
        fn no_sample_of_a_random_warped_floor_lies_outside_its_certificate(
            shifts in prop::collection::vec([-0.25..0.25_f64, -0.25..0.25, -0.5..0.5], 20),
        ) {
            let net = shifts.iter().enumerate().map(|(n, [x, y, z])|
                Vector3::new((n / 5) as f64 + x, (n % 5) as f64 + y, *z));
            assert_holds(&BezierPatch::new([3, 4], net.collect()).unwrap());
        }
    }

    #[test]
    fn a_floor_a_million_metres_away_is_still_certified() {
        let terms = [vec![0.0, 0.0, 0.5], vec![], vec![0.5]];
        let near = BezierPatch::from_polynomial([-1.0, 1.0], [-1.0, 1.0], &terms).unwrap();
        let net = near.net().iter().map(|p| p + Vector3::new(1e6, -1e6, 0.0)).collect();
        let [low, high] = certify(&BezierPatch::new(near.degree(), net).unwrap(), &Vector3::z()).curvature;
        assert!(low <= 1.0 && 1.0 <= high && high - low < 1e-3);
    }
}
