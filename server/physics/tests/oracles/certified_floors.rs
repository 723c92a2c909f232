//! Certificates of random floors against dense samples that are polished uphill, and what scenes they refuse.

use crate::scenes;
use ballroom_physics::surface::bezier::BezierPatch;
use ballroom_physics::surface::certify::{Certificate, certify};
use ballroom_physics::surface::jet::Jet;
use ballroom_physics::tolerance::{
    BRACKET_BOXES_MAX, BRACKET_FLAT, BRACKET_WIDTH, REACH_PAIRS_MAX, REACH_WIDTH,
};
use ballroom_physics::{Controller, Floor, MotionLaw, Place, SceneFault};
use nalgebra::{Vector2, Vector3};

/// A sampled value may lie outside its bracket by its own rounding, relative.
const ROUNDING: f64 = 1e-9;

/// Certificates of more pairs than this take longest.
const DEAR_PAIRS: usize = 10_000;

/// Boxes and pairs that no floor here needs: far from the budgets, whose end would leave a bracket wide.
const MOST_WORK: [usize; 2] = [5_000, 100_000];
const _: () = assert!(10 * MOST_WORK[0] < BRACKET_BOXES_MAX && 4 * MOST_WORK[1] < REACH_PAIRS_MAX);

/// Numbers from a seed (Marsaglia's xorshift).
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        Self((seed + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// 1 to 12, low degrees more often.
    fn degree(&mut self) -> usize {
        (1.0 + 12.0 * self.between(0.0, 1.0).powi(3)) as usize
    }
}

/// A height field or a net whose control points are shifted all three ways.
fn random_patch(seed: u64) -> BezierPatch {
    let mut random = Random::new(seed);
    let [p, q] = [random.degree(), random.degree()];
    let amplitude = random.between(0.1, 2.0);
    let shift = if seed.is_multiple_of(2) { 0.0 } else { random.between(0.0, 0.4) };
    let mut net = Vec::new();
    for i in 0..=p {
        for j in 0..=q {
            let mut place = |k: usize, n: usize| (k as f64 + random.between(-shift, shift)) / n as f64;
            let [x, y] = [place(i, p), place(j, q)];
            net.push(Vector3::new(4.0 * x, 3.0 * y, random.between(-amplitude, amplitude)));
        }
    }
    BezierPatch::new([p, q], net).unwrap()
}

/// The best of a coarse lattice and what uphill steps along the axes make of it.
fn highest<const N: usize>(value: impl Fn([f64; N]) -> f64, lattice: &[[f64; N]]) -> f64 {
    let mut at = lattice[0];
    let mut best = f64::NEG_INFINITY;
    for place in lattice {
        let here = value(*place);
        if here > best {
            (best, at) = (here, *place);
        }
    }
    let mut step = 0.05;
    while step > 1e-4 {
        let mut better = false;
        for k in 0..N {
            for sign in [-1.0, 1.0] {
                let mut next = at;
                next[k] = (next[k] + sign * step).clamp(0.0, 1.0);
                let there = value(next);
                if there > best {
                    (best, at, better) = (there, next, true);
                }
            }
        }
        if !better {
            step *= 0.5;
        }
    }
    best
}

fn normal(jet: &Jet, certificate: &Certificate) -> Vector3<f64> {
    jet.normal(certificate.orientation).unwrap()
}

fn curvature(jet: &Jet, certificate: &Certificate) -> f64 {
    jet.fundamental_forms(&normal(jet, certificate)).principal_curvatures()[0]
}

/// 1/R of the ball that lies at p and passes through q.
fn touch(p: &Jet, q: &Jet, certificate: &Certificate) -> f64 {
    let x = q.point - p.point;
    if x.norm() < 1e-3 { 0.0 } else { 2.0 * normal(p, certificate).dot(&x) / x.norm_squared() }
}

fn assert_holds(patch: &BezierPatch, certificate: &Certificate, name: &str) {
    let jet = |u: f64, v: f64| patch.jet(u, v);
    let at = |place: [f64; 2]| jet(place[0], place[1]);
    let places: Vec<[f64; 2]> =
        (0..=8).flat_map(|i| (0..=8).map(move |j| [f64::from(i) / 8.0, f64::from(j) / 8.0])).collect();

    let [least, most] = certificate.steepest_cosine;
    let steepest = -highest(|[u, v]| -normal(&jet(u, v), certificate).z, &places);
    assert!(steepest >= least - ROUNDING, "{name}: slope {steepest} {certificate:?}");
    let named = normal(&at(certificate.steepest_at.uv), certificate).z;
    assert!(least - ROUNDING <= named && named <= most + ROUNDING, "{name}: {named} {certificate:?}");

    let [low, high] = certificate.curvature;
    let sampled = highest(|[u, v]| curvature(&jet(u, v), certificate), &places);
    assert!(sampled <= high * (1.0 + ROUNDING) + ROUNDING, "{name}: curvature {sampled} {certificate:?}");
    // A larger curvature of the other sign takes digits from this one.
    let jet_there = at(certificate.curvature_at.uv);
    let both = jet_there.fundamental_forms(&normal(&jet_there, certificate)).principal_curvatures();
    let error = (both[0].max(0.0) - low).abs();
    assert!(error <= ROUNDING * (1.0 + both[0].abs() + both[1].abs()), "{name}: {both:?} {certificate:?}");
    assert!(high - low <= 1.001 * BRACKET_WIDTH * high + BRACKET_FLAT, "{name}: {certificate:?}");

    let [low, high] = certificate.reach;
    let pairs: Vec<[f64; 4]> = places
        .iter()
        .step_by(3)
        .flat_map(|p| places.iter().step_by(5).map(move |q| [p[0], p[1], q[0], q[1]]))
        .filter(|[a, b, c, d]| a != c || b != d)
        .collect();
    let sampled = highest(|[a, b, c, d]| touch(&jet(a, b), &jet(c, d), certificate), &pairs);
    assert!(sampled * low <= 1.0 + ROUNDING, "{name}: touch {sampled} {certificate:?}");
    let [contact, second] = certificate.reach_at.map(|place| at(place.uv));
    let named = if contact == second {
        curvature(&contact, certificate).max(0.0)
    } else {
        touch(&contact, &second, certificate)
    };
    assert!((named * high - 1.0).abs() <= 1e-6 || high == f64::INFINITY, "{name}: {named} {certificate:?}");
    let width = 1.0 / low - 1.0 / high;
    let narrow = width <= (REACH_WIDTH + 1.001 * BRACKET_WIDTH) / low + BRACKET_FLAT;
    assert!(narrow, "{name}: {certificate:?}");
    let work = [certificate.boxes, certificate.pairs];
    assert!(work[0] <= MOST_WORK[0] && work[1] <= MOST_WORK[1], "{name}: {work:?}");
}

/// What the engine says to one ball of this radius on a floor without walls.
fn fault(patch: &BezierPatch, radius: f64) -> SceneFault {
    let everywhere = [-1e3, 1e3];
    let mut scene = scenes::scene(Floor::Bezier(patch.clone()), everywhere, everywhere, MotionLaw::Rolling);
    scene.walls.clear();
    scene.balls.push(scenes::still("one", radius, Place::Uv(Vector2::new(0.5, 0.5))));
    Controller::new(&scene).unwrap_err()
}

/// A ball that fits is not refused for the floor's shape, one that does not is, whatever the bracket's width.
fn assert_refuses(patch: &BezierPatch, certificate: &Certificate, name: &str) {
    let [low, high] = certificate.reach;
    if low.is_finite() && low < 1e3 {
        let fits = fault(patch, 0.98 * low);
        assert!(matches!(fits, SceneFault::OpenBorder { .. }), "{name}: {fits:?} {certificate:?}");
    }
    if high.is_finite() && high < 1e3 {
        let refused = fault(patch, 1.02 * high);
        let named = matches!(refused, SceneFault::TooCurved { .. } | SceneFault::SecondTouch { .. });
        assert!(named, "{name}: {refused:?} {certificate:?}");
    }
}

fn assert_certified(seeds: std::ops::Range<u64>) {
    let count = seeds.end - seeds.start;
    let mut regular = 0;
    for seed in seeds {
        let patch = random_patch(seed);
        let name = format!("seed {seed}, degree {:?}", patch.degree());
        let certificate = certify(&patch, &Vector3::z());
        if certificate.regular.is_ok() {
            regular += 1;
            assert_holds(&patch, &certificate, &name);
            // The dearest are left out to save time: one in ten.
            if certificate.pairs < DEAR_PAIRS {
                assert_refuses(&patch, &certificate, &name);
            }
        } else {
            assert!(!seed.is_multiple_of(2), "{name}: a height field has a normal: {certificate:?}");
            assert!(matches!(fault(&patch, 0.1), SceneFault::Degenerate { .. }), "{name}");
        }
    }
    assert!(10 * regular >= 9 * count, "{regular} of {count} floors are regular");
}

// A thousand floors in all, in four parts that run side by side.
#[test]
fn certificates_hold_on_random_floors_0_to_249() {
    assert_certified(0..250);
}

#[test]
fn certificates_hold_on_random_floors_250_to_499() {
    assert_certified(250..500);
}

#[test]
fn certificates_hold_on_random_floors_500_to_749() {
    assert_certified(500..750);
}

#[test]
fn certificates_hold_on_random_floors_750_to_999() {
    assert_certified(750..1000);
}

/// A road along a cubic that crosses itself, climbing all the way; its control points are moved at random.
fn random_road(seed: u64) -> BezierPatch {
    let mut random = Random::new(seed);
    let rise = random.between(1.0, 2.5);
    let curve = [[-3.0, 0.0], [9.0, 6.0], [-9.0, 6.0], [3.0, 0.0]]
        .map(|[x, y]| Vector3::new(x + random.between(-0.5, 0.5), y + random.between(-0.5, 0.5), 0.0));
    let steps: [Vector3<f64>; 3] = [0, 1, 2].map(|k| 3.0 * (curve[k + 1] - curve[k]));
    // The derivative, raised to the curve's degree.
    let along = [steps[0], (steps[0] + 2.0 * steps[1]) / 3.0, (2.0 * steps[1] + steps[2]) / 3.0, steps[2]];
    let width = random.between(0.01, 0.04);
    let net = (0..4).flat_map(|i| {
        let aside = Vector3::new(-along[i].y, along[i].x, 0.0) * width;
        let height = Vector3::z() * (rise * i as f64 / 3.0 + random.between(-0.1, 0.1));
        [curve[i] - aside + height, curve[i] + aside + height]
    });
    BezierPatch::new([3, 1], net.collect()).unwrap()
}

/// Random floors rarely have a reach below their radius of curvature; these have.
#[test]
fn certificates_hold_where_a_road_passes_under_itself() {
    let mut under = 0;
    for seed in 0..40 {
        let patch = random_road(seed);
        let name = format!("road {seed}");
        let certificate = certify(&patch, &Vector3::z());
        assert_eq!(certificate.regular, Ok(()), "{name}");
        assert_holds(&patch, &certificate, &name);
        assert_refuses(&patch, &certificate, &name);
        under += u32::from(certificate.reach[1] * certificate.curvature[1] < 0.9);
    }
    assert!(under >= 20, "only {under} roads are low above themselves");
}
