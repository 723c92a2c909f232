//! Certificates against samples and closed forms.

mod irregular;
mod reach;

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
    let flat = BRACKET_FLAT / extent(patch);
    assert!(low <= high && high - low <= (1e-3 * high).max(1.001 * flat), "{certificate:?}");
    let [least, most] = certificate.steepest_cosine;
    assert!(least <= most && least <= cosine && most - least < 1e-3 * most, "{cosine} {certificate:?}");
    let at = certificate.curvature_at.uv;
    if low > 0.0 {
        let jet = patch.jet(at[0], at[1]);
        let normal = jet.normal(certificate.orientation).unwrap();
        let there = jet.fundamental_forms(&normal).principal_curvatures()[0];
        assert!((there - low).abs() <= 1e-9 * there.abs().max(1.0), "{there} {certificate:?}");
    }
    certificate
}

fn polynomial(x: [f64; 2], y: [f64; 2], terms: &[Vec<f64>]) -> BezierPatch {
    BezierPatch::from_polynomial(x, y, terms).unwrap()
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
    // Upside down the hill is the pit.
    let convex = certify(&pit_and_hill(), &-Vector3::z()).curvature;
    assert!((1.0 / convex[1] - 1.738).abs() < 1e-3);
}

#[test]
fn a_mirrored_floor_has_the_same_certificate() {
    let patch = pit_and_hill();
    let mirror = |p: &Vector3<f64>| Vector3::new(-p.x, p.y, p.z);
    let net = patch.net().iter().map(mirror).collect();
    let mirrored = certify(&BezierPatch::new(patch.degree(), net).unwrap(), &Vector3::z());
    let straight = certify(&patch, &Vector3::z());
    let place = |at: FloorPlace| FloorPlace { point: mirror(&at.point), ..at };
    let expected = Certificate {
        orientation: -1.0,
        steepest_at: place(straight.steepest_at),
        curvature_at: place(straight.curvature_at),
        reach_at: straight.reach_at.map(place),
        ..straight
    };
    assert_eq!(mirrored, expected);
}

#[test]
fn a_paraboloid_curves_most_at_its_vertex() {
    let terms = [vec![0.0, 0.0, 0.25], vec![], vec![0.75]];
    let patch = BezierPatch::from_polynomial([-1.0, 2.0], [-1.0, 1.0], &terms).unwrap();
    let certificate = assert_holds(&patch);
    assert!(certificate.curvature[0] <= 1.5 && 1.5 <= certificate.curvature[1]);
    assert!((certificate.curvature_at.uv[0] - 1.0 / 3.0).abs() < 0.01, "{certificate:?}");
}

#[test]
fn what_is_nowhere_concave_has_curvature_zero() {
    let plane = BezierPatch::from_polynomial([-3.0, 1.0], [0.0, 1.0], &[vec![0.0, 0.5], vec![-0.3]]).unwrap();
    let [low, high] = assert_holds(&plane).curvature;
    assert!(low == 0.0 && high < 1e-6);
    let dome =
        BezierPatch::from_polynomial([-1.0, 1.0], [-1.0, 1.0], &[vec![0.0, 0.0, -1.0], vec![], vec![-0.5]]);
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
