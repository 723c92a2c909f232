//! Floors without an upward normal somewhere: where, and what is wrong.

use crate::surface::bezier::BezierPatch;
use crate::surface::certify::{Irregular, Irregularity, certify};
use nalgebra::Vector3;

/// What is said about a net of rows along v.
fn irregular(degree: [usize; 2], net: Vec<[f64; 3]>) -> Irregular {
    let patch = BezierPatch::new(degree, net.into_iter().map(Vector3::from).collect()).unwrap();
    let certificate = certify(&patch, &Vector3::z());
    assert_eq!((certificate.curvature[1], certificate.reach[0]), (f64::INFINITY, 0.0));
    let fault = certificate.regular.unwrap_err();
    let [u, v] = fault.at.uv;
    assert_eq!(fault.at.point, patch.jet(u, v).point);
    fault
}

/// A profile (x, z) along u, as wide as 1 along y.
fn extruded(profile: &[[f64; 2]]) -> Irregular {
    let net = profile.iter().flat_map(|[x, z]| [[*x, 0.0, *z], [*x, 1.0, *z]]).collect();
    irregular([profile.len() - 1, 1], net)
}

#[test]
fn a_collapsed_border_is_named() {
    for (collapsed, name) in [(0, "u = 0"), (2, "u = 1")] {
        let net = (0..9).map(|n| {
            let (i, j) = (n / 3, n % 3);
            [f64::from(i), if i == collapsed { 0.0 } else { f64::from(j) }, 0.0]
        });
        let fault = irregular([2, 2], net.collect());
        assert_eq!(fault.kind, Irregularity::CollapsedEdge(name));
        assert!((fault.at.uv[0] - f64::from(collapsed) / 2.0).abs() < 1e-6, "{fault:?}");
    }
}

#[test]
fn a_fold_is_named_where_the_normal_turns_over() {
    // x' = 6 (1 - u)^2 - 18 u (1 - u) + 6 u^2 is 0 at u = (5 -+ sqrt 5)/10; beyond them the floor faces up.
    let fault = extruded(&[[0.0, 0.0], [2.0, 0.0], [-1.0, 0.0], [1.0, 0.0]]);
    assert_eq!(fault.kind, Irregularity::Fold);
    let from_middle = (fault.at.uv[0] - 0.5).abs();
    assert!((from_middle - 0.05_f64.sqrt()).abs() < 1e-9, "{fault:?}");
}

#[test]
fn an_overhang_is_named_where_the_floor_is_vertical() {
    let fault = extruded(&[[0.0, 0.0], [1.5, 0.0], [-0.5, 1.0], [1.0, 1.0]]);
    assert_eq!(fault.kind, Irregularity::Overhang);
    // x' = 4.5 (1 - u)^2 - 12 u (1 - u) + 4.5 u^2 = 0.
    let from_middle = (0.25 - 4.5 / 21.0_f64).sqrt();
    assert!(((fault.at.uv[0] - 0.5).abs() - from_middle).abs() < 1e-9, "{fault:?}");
}

#[test]
fn a_cusp_has_no_normal() {
    // (x, z) = (t^3, t^2) about u = 1/2 would turn back; (t^3, 0) only stops.
    let fault = extruded(&[[-1.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [1.0, 0.0]]);
    assert_eq!(fault.kind, Irregularity::NoNormal);
    assert!((fault.at.uv[0] - 0.5).abs() < 1e-4, "{fault:?}");
}

#[test]
fn a_net_without_area_has_no_normal() {
    let line = irregular([1, 1], vec![[0.0; 3], [4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0; 3]]);
    assert_eq!(line.kind, Irregularity::NoNormal);
}
