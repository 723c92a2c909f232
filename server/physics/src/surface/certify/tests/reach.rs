//! The reach against closed forms, and where sampling would miss it.

use super::{pit_and_hill, polynomial};
use crate::surface::bezier::BezierPatch;
use crate::surface::certify::{Certificate, certify, certify_for};
use crate::tolerance::REACH_WIDTH;
use nalgebra::Vector3;

/// The certificate, once its reach is what it should be, m.
fn assert_reach(patch: &BezierPatch, expected: f64) -> Certificate {
    let certificate = certify(patch, &Vector3::z());
    let [low, high] = certificate.reach;
    assert!(
        low <= expected * (1.0 + 1e-12) && expected * (1.0 - 1e-12) <= high,
        "{expected} {certificate:?}"
    );
    assert!(high / low < 1.0 + 1.3 * REACH_WIDTH, "{certificate:?}");
    certificate
}

/// 1/R of the ball that lies at p and passes through q, m.
fn touch(patch: &BezierPatch, p: [f64; 2], q: [f64; 2]) -> f64 {
    let jet = patch.jet(p[0], p[1]);
    let x = patch.jet(q[0], q[1]).point - jet.point;
    2.0 * jet.normal(patch.orientation(&Vector3::z())).unwrap().dot(&x) / x.norm_squared()
}

#[test]
fn the_vertex_decides_on_paraboloids_and_parabolic_cylinders() {
    let bowl = polynomial([-5.0, 5.0], [-4.0, 5.0], &[vec![0.0, 0.0, 0.05], vec![], vec![0.05]]);
    let certificate = assert_reach(&bowl, 10.0);
    assert_eq!(certificate.reach_at[0], certificate.reach_at[1]);
    assert!(certificate.reach_at[0].point.norm() < 0.2, "{certificate:?}");
    assert_reach(&polynomial([-1.0, 1.5], [-2.0, 2.0], &[vec![], vec![], vec![2.0]]), 0.25);
    // A cylinder that climbs at 45 degrees is as curved as its cross section.
    let oblique = polynomial([-1.0, 1.0], [-2.0, 2.0], &[vec![0.0, 1.0], vec![], vec![0.5]]);
    assert_reach(&oblique, 2.0_f64.sqrt());
}

#[test]
fn where_the_floor_is_nowhere_concave_every_ball_touches_once() {
    let dome = polynomial([-1.0, 1.0], [-1.0, 1.0], &[vec![0.0, 0.0, -1.0], vec![], vec![-0.5]]);
    assert_eq!(certify(&dome, &Vector3::z()).reach, [f64::INFINITY; 2]);
    let plane = polynomial([-1.0, 1.0], [-1.0, 1.0], &[vec![0.0, 0.5], vec![0.25]]);
    assert!(certify(&plane, &Vector3::z()).reach[0] > 1e5);
}

/// A ball between the flanks of z = x^4 touches both at x = 1/sqrt(2) if its radius is sqrt(3)/2, the least that
/// does; but only down to 1/k = 0.465 m does one reach the flanks at all, at x^6 = 1/56.
#[test]
fn in_a_quartic_trough_curvature_stops_a_ball_before_its_flanks_do() {
    let trough = polynomial([-1.0, 1.0], [-1.0, 1.0], &[vec![], vec![], vec![], vec![], vec![1.0]]);
    let at = |x: f64| [0.5 * (x + 1.0), 0.5];
    let flank = 0.5_f64.sqrt();
    let both = touch(&trough, at(-flank), at(flank));
    assert!((both - 2.0 / 3.0_f64.sqrt()).abs() < 1e-12, "{both}");
    let curvature = 12.0 * 56.0_f64.powf(-1.0 / 3.0) / (9.0 / 7.0_f64).powf(1.5);
    let certificate = assert_reach(&trough, 1.0 / curvature);
    assert!((certificate.reach_at[0].point.x.abs() - 56.0_f64.powf(-1.0 / 6.0)).abs() < 0.02);
}

/// z = (x^2 - 1)^2: the largest curvature of its profile, found along a fine line, beats every pair of its places.
#[test]
fn on_a_w_no_pair_of_flanks_is_closer_than_its_bends() {
    let terms = [vec![1.0], vec![], vec![-2.0], vec![], vec![1.0]];
    let w = polynomial([-1.5, 1.5], [-1.0, 1.0], &terms);
    let place = |k: u32| -1.5 + f64::from(k) * 3.0 / 4000.0;
    let curvature = (0..=4000)
        .map(|k| {
            let x = place(k);
            (12.0 * x * x - 4.0) / (1.0 + (4.0 * x * (x * x - 1.0)).powi(2)).powf(1.5)
        })
        .fold(0.0, f64::max);
    let certificate = assert_reach(&w, 1.0 / curvature);
    for i in (0..=4000).step_by(50) {
        for j in (0..=4000).step_by(40).filter(|j| *j != i) {
            let [p, q] = [i, j].map(|k| [f64::from(k) / 4000.0, 0.5]);
            assert!(touch(&w, p, q) * certificate.reach[0] <= 1.0);
        }
    }
}

/// A road along a plane cubic that crosses itself, with the heights of its control points, m.
fn looping_road(heights: [f64; 4]) -> BezierPatch {
    let curve = [[-3.0, 0.0], [9.0, 6.0], [-9.0, 6.0], [3.0, 0.0]].map(|[x, y]| Vector3::new(x, y, 0.0));
    let steps: [Vector3<f64>; 3] = [0, 1, 2].map(|k| 3.0 * (curve[k + 1] - curve[k]));
    // The derivative, raised to the curve's degree.
    let along = [steps[0], (steps[0] + 2.0 * steps[1]) / 3.0, (2.0 * steps[1] + steps[2]) / 3.0, steps[2]];
    let net = (0..4).flat_map(|i| {
        let aside = Vector3::new(-along[i].y, along[i].x, 0.0) * 0.03;
        let height = Vector3::z() * heights[i];
        [curve[i] - aside + height, curve[i] + aside + height]
    });
    BezierPatch::new([3, 1], net.collect()).unwrap()
}

#[test]
fn a_road_that_passes_under_itself_leaves_room_for_half_its_headroom() {
    let road = looping_road([0.0, 0.4, 0.8, 1.2]);
    let certificate = certify(&road, &Vector3::z());
    assert_eq!(certificate.regular, Ok(()));
    let [low, high] = certificate.reach;
    assert!(high * certificate.curvature[1] < 0.5, "curvature decides: {certificate:?}");
    assert!(high / low < 1.0 + 1.3 * REACH_WIDTH, "{certificate:?}");
    // x = (5 t^3 - 3 t)/2 for t = 2 u - 1: the road crosses itself at t^2 = 3/5, with 1.2 sqrt(3/5) m between.
    let [contact, second] = certificate.reach_at;
    assert!(second.point.z - contact.point.z > 0.5, "{certificate:?}");
    assert!((touch(&road, contact.uv, second.uv) * high - 1.0).abs() < 1e-9);
    let headroom = 1.2 * 0.6_f64.sqrt();
    assert!(0.4 * headroom < low && high < 0.5 * headroom, "{headroom} {certificate:?}");
    let mut sampled = 0.0_f64;
    for i in 0..=60 {
        for j in 0..=60 {
            for [a, b] in [[0.0, 0.0], [0.0, 0.5], [0.5, 0.5], [0.5, 1.0], [1.0, 0.0], [1.0, 1.0]] {
                let [u, w] = [f64::from(i) / 60.0, f64::from(j) / 60.0];
                if i != j {
                    sampled = sampled.max(touch(&road, [u, a], [w, b]));
                }
            }
        }
    }
    assert!(sampled * low <= 1.0 && sampled * high > 0.95, "{sampled} {certificate:?}");
}

#[test]
fn a_road_that_crosses_itself_on_the_level_has_no_reach() {
    // Both ways climb to the middle of the loop, so at the crossing one lies above the other on either side.
    let certificate = certify(&looping_road([0.0, 0.8, 0.8, 0.0]), &Vector3::z());
    assert_eq!(certificate.regular, Ok(()));
    let [contact, second] = certificate.reach_at;
    assert!(certificate.reach[0] < 1e-3 && certificate.reach[1] < 1e-2, "{certificate:?}");
    assert!((contact.point - second.point).norm() < 0.02, "{certificate:?}");
    assert!((contact.uv[0] - second.uv[0]).abs() > 0.1, "{certificate:?}");
}

#[test]
fn a_plane_that_covers_itself_twice_is_one_plane_to_a_ball() {
    let certificate = certify(&looping_road([0.0; 4]), &Vector3::z());
    assert_eq!(certificate.regular, Ok(()));
    assert!(certificate.reach[0] > 1e3, "{certificate:?}");
}

/// The floor turns within a centimetre at a place between samples, so that a ball of 2 cm touches both flanks.
#[test]
fn a_slot_between_the_samples_of_a_fine_grid_is_caught() {
    let terms = [vec![0.0, 0.0, 30.0], vec![], vec![50.0]];
    let patch = polynomial([-1.0, 1.01], [-1.02, 1.0], &terms);
    let mut sampled = 0.0_f64;
    for i in 0..64 * 64 {
        for j in (0..64 * 64).step_by(61).filter(|j| *j != i) {
            let [p, q] = [i, j].map(|k| [f64::from(k % 64) / 63.0, f64::from(k / 64) / 63.0]);
            sampled = sampled.max(touch(&patch, p, q));
        }
    }
    assert!(sampled < 50.0, "not a slot: {sampled}");
    assert_reach(&patch, 0.01);
}

#[test]
fn balls_that_fit_are_certified_with_less_work() {
    let patch = pit_and_hill();
    let whole = certify(&patch, &Vector3::z());
    for share in [0.2, 0.7] {
        let radius = share * whole.reach[0];
        let part = certify_for(&patch, &Vector3::z(), radius);
        assert!(
            part.reach[0] * crate::tolerance::CURVATURE_MAX >= radius * (1.0 - 1e-12),
            "{share} {part:?}"
        );
        assert!(part.pairs < whole.pairs, "{share} {part:?}");
    }
    let large = certify_for(&patch, &Vector3::z(), 1.01 * whole.reach[1]);
    assert!(large.reach[0] < whole.reach[1], "{large:?}");
}
