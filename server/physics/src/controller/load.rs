//! A scene is checked and its balls are set down.

use super::ledger::Ledger;
use super::{Ball, Controller, Work};
use crate::detect::ball_wall::{Plane, room_between};
use crate::detect::broad_phase::BroadPhase;
use crate::diagnostics::Report;
use crate::motion::arc::Arc;
use crate::motion::body::{Body, Stepping};
use crate::motion::law::{ROLLING, State};
use crate::motion::together;
use crate::scene::{Accuracy, BallSpec, Floor, MotionLaw, Scene, SceneFault};
use crate::schedule::queue::Queue;
use crate::schedule::time::Time;
use crate::surface::bezier::BezierPatch;
use crate::surface::certify::{Certificate, Irregular, certify, certify_for};
use crate::surface::chart::Surface;
use crate::surface::place;
use crate::tolerance::{self, CURVATURE_MAX, HITS_KEPT, OVERLAP_ULPS};
use nalgebra::Vector3;

type V3 = Vector3<f64>;

/// Largest coordinate, speed, mass and so on that a scene may name: squares stay far from overflow.
const ABSURD: f64 = 1e12;

impl Controller {
    /// Checks the scene, certifies the floor and sets every ball on it.
    pub fn new(scene: &Scene) -> Result<Self, SceneFault> {
        check_numbers(scene)?;
        let patch = net_of(&scene.floor)?;
        let certificate = certify_for(&patch, &-scene.gravity, largest_radius(scene));
        let mut controller = Self::standing(scene, patch, &certificate, |_| None)?;
        controller.check_room()?;
        for ball in 0..controller.balls.len() {
            let state = controller.arcs[ball].state;
            controller.launch(ball, Time::ZERO, &state);
        }
        for ball in 0..controller.balls.len() {
            controller.predict(ball, Time::ZERO);
        }
        Ok(controller)
    }

    /// Every ball where the scene puts it, or as `known` says of its place in the list: at time zero, not yet on its way,
    /// and not asked whether there is room. The scene's numbers have been checked.
    pub(super) fn standing(
        scene: &Scene,
        patch: BezierPatch,
        certificate: &Certificate,
        known: impl Fn(usize) -> Option<(Ball, State)>,
    ) -> Result<Self, SceneFault> {
        check_floor(scene, &patch, certificate)?;
        let surface = Surface::new(&scene.floor, &patch, certificate.orientation);
        let order = rank_by_name(&scene.balls)?;
        let walls: Vec<Plane> = scene
            .walls
            .iter()
            .map(|w| Plane {
                normal: V3::new(w.normal.x, w.normal.y, 0.0),
                point: V3::new(w.point.x, w.point.y, 0.0),
            })
            .collect();
        let radii: Vec<f64> = order.iter().map(|i| scene.balls[*i].radius).collect();
        let mut balls = Vec::with_capacity(order.len());
        let mut arcs: Vec<Arc> = radii.iter().map(|radius| Arc::empty(*radius)).collect();
        for (index, arc) in order.iter().zip(&mut arcs) {
            let (ball, state) = known(*index).map_or_else(|| set_down(scene, &surface, *index), Ok)?;
            ball.body.hold(&surface, (Time::ZERO, &state), 0.0, arc);
            arc.state = state;
            balls.push(ball);
        }
        let bounds = extent(&patch);
        let work = Work::new(order.len(), together::width(&surface, scene.accuracy));
        Ok(Self {
            broad_phase: BroadPhase::new(&radii, bounds),
            span: (bounds[2] - bounds[0]).max(bounds[3] - bounds[1]),
            queue: Queue::new(order.len()),
            surface,
            patch,
            certificate: *certificate,
            room: room_between(&walls),
            walls,
            gravity: scene.gravity,
            restitution: scene.restitution,
            accuracy: scene.accuracy,
            hit_budget: scene.hit_budget,
            balls,
            arcs,
            scene_index: order,
            time: Time::ZERO,
            now: Time::ZERO,
            hits: Vec::with_capacity(HITS_KEPT),
            report: Report::default(),
            ledger: Ledger::new(),
            work,
            share: None,
            shards: None,
        })
    }

    /// No ball in a wall, none in another.
    fn check_room(&mut self) -> Result<(), SceneFault> {
        let ulps = OVERLAP_ULPS * f64::EPSILON;
        for (ball, arc) in self.arcs.iter().enumerate() {
            let center = arc.center[0];
            let r = self.balls[ball].body.radius;
            for (wall, plane) in self.walls.iter().enumerate() {
                let depth = r - plane.distance(&center);
                if depth > ulps * (center.amax() + plane.point.amax() + r) {
                    return Err(SceneFault::InWall { ball: self.scene_index[ball], wall, depth });
                }
            }
            let bounds = [center.x - r, center.y - r, center.x + r, center.y + r];
            self.broad_phase.file(ball, bounds);
        }
        for ball in 0..self.balls.len() {
            let mut fault = None;
            let center = self.arcs[ball].center[0];
            self.broad_phase.neighbours(ball, |other| {
                let theirs = self.arcs[other].center[0];
                let reach = self.balls[ball].body.radius + self.balls[other].body.radius;
                let depth = reach - (theirs - center).norm();
                if other > ball && depth > ulps * (center.amax() + theirs.amax() + reach) {
                    let [a, b] = [self.scene_index[ball], self.scene_index[other]];
                    fault = Some(SceneFault::Overlap { first: a.min(b), second: a.max(b), depth });
                }
            });
            if let Some(fault) = fault {
                return Err(fault);
            }
        }
        Ok(())
    }
}

fn number(field: String, value: f64, fine: bool, want: &'static str) -> Result<(), SceneFault> {
    if fine { Ok(()) } else { Err(SceneFault::Number { field, value, want }) }
}

pub(super) fn check_numbers(scene: &Scene) -> Result<(), SceneFault> {
    let small = |x: f64| x.abs() <= ABSURD;
    let positive = |x: f64| x > 0.0 && x <= ABSURD;
    for x in scene.gravity.iter() {
        number("gravity".into(), *x, small(*x), "finite and of size at most 1e12")?;
    }
    number("gravity".into(), scene.gravity.z, scene.gravity.z < 0.0, "pointing down: its z below 0")?;
    let e = scene.restitution;
    number("restitution".into(), e, (0.0..=1.0).contains(&e), "between 0 and 1")?;
    match scene.accuracy {
        Accuracy::Tolerance(t) => {
            number(
                "accuracy".into(),
                t,
                (1e-13..=1e-2).contains(&t),
                "a tolerance between 1e-13 and 1e-2 m",
            )?;
        }
        Accuracy::Fixed(_, h) => {
            let want = "a step between 1e-6 and 0.5 s";
            number("accuracy".into(), h, (1e-6..=tolerance::STEP_MAX).contains(&h), want)?;
        }
    }
    number("hit_budget".into(), f64::from(scene.hit_budget), scene.hit_budget > 0, "at least 1")?;
    for (i, wall) in scene.walls.iter().enumerate() {
        for x in wall.point.iter() {
            number(format!("walls[{i}].point"), *x, small(*x), "finite and of size at most 1e12")?;
        }
        let length = wall.normal.norm();
        let unit = (length - 1.0).abs() <= 1e-12;
        number(format!("walls[{i}].normal"), length, unit, "of length 1")?;
    }
    for (i, ball) in scene.balls.iter().enumerate() {
        let field = |name: &str| format!("balls[{i}].{name}");
        number(field("radius"), ball.radius, positive(ball.radius), "above 0 and at most 1e12 m")?;
        number(field("mass"), ball.mass, positive(ball.mass), "above 0 and at most 1e12 kg")?;
        let k = ball.inertia_factor;
        number(field("inertia_factor"), k, (0.0..=1.0).contains(&k), "between 0 and 1")?;
        number(field("spin"), ball.spin, small(ball.spin), "finite and of size at most 1e12 rad/s")?;
        for x in ball.velocity.iter() {
            number(field("velocity"), *x, small(*x), "finite and of size at most 1e12 m/s")?;
        }
        let (crate::Place::Center(p) | crate::Place::Contact(p) | crate::Place::Uv(p)) = ball.place;
        for x in p.iter() {
            number(field("place"), *x, small(*x), "finite and of size at most 1e12")?;
        }
    }
    Ok(())
}

/// The floor's exact net.
pub(crate) fn net_of(floor: &Floor) -> Result<BezierPatch, SceneFault> {
    match floor {
        Floor::Bezier(patch) => Ok(patch.clone()),
        Floor::Polynomial { x, y, terms } => {
            for [low, high] in [x, y] {
                let fine = high > low && low.abs().max(high.abs()) <= ABSURD;
                number("floor border".into(), high - low, fine, "a positive width, of size at most 1e12 m")?;
            }
            let degree = terms.len().max(terms.iter().map(Vec::len).max().unwrap_or(0));
            let want = "finite terms of degree at most 12 in x and in y";
            BezierPatch::from_polynomial(*x, *y, terms).ok_or(SceneFault::Number {
                field: "floor".into(),
                value: degree as f64 - 1.0,
                want,
            })
        }
    }
}

fn check_floor(scene: &Scene, patch: &BezierPatch, certificate: &Certificate) -> Result<(), SceneFault> {
    if let Err(Irregular { kind, at }) = certificate.regular {
        return Err(SceneFault::Degenerate { kind, at });
    }
    // A height field's balls lie on its upper side, which must be the one that gravity presses them to.
    let jet = patch.jet(0.5, 0.5);
    let upper = jet.du.cross(&jet.dv).z * certificate.orientation > 0.0;
    let heights = patch.is_height_field() || matches!(scene.floor, Floor::Polynomial { .. });
    number(
        "gravity".into(),
        scene.gravity.x,
        upper || !heights,
        "pressing balls onto the floor's upper side",
    )?;
    let largest = scene.balls.iter().enumerate().max_by(|a, b| a.1.radius.total_cmp(&b.1.radius));
    if let Some((ball, spec)) = largest {
        let [lo, hi] = certificate.curvature.map(|k| k * spec.radius);
        if hi >= CURVATURE_MAX {
            return Err(SceneFault::TooCurved { ball, lo, hi, at: certificate.curvature_at });
        }
        let fits = |reach: f64| spec.radius <= CURVATURE_MAX * reach * (1.0 + 4.0 * f64::EPSILON);
        if !fits(certificate.reach[0]) {
            // Before a scene is refused the bracket is worth its time.
            let Certificate { reach: [lo, hi], reach_at: [contact, touch], .. } =
                certify(patch, &-scene.gravity);
            if !fits(lo) {
                return Err(SceneFault::SecondTouch { ball, radius: spec.radius, lo, hi, contact, touch });
            }
        }
    }
    // A border whose control points all lie on or behind one wall lies there whole: convex hull.
    let [p, q] = patch.degree();
    let borders: [(&'static str, Vec<V3>); 4] = [
        ("u = 0", (0..=q).map(|j| patch.point(0, j)).collect()),
        ("u = 1", (0..=q).map(|j| patch.point(p, j)).collect()),
        ("v = 0", (0..=p).map(|i| patch.point(i, 0)).collect()),
        ("v = 1", (0..=p).map(|i| patch.point(i, q)).collect()),
    ];
    for (border, points) in borders {
        let behind = scene.walls.iter().any(|w| {
            points.iter().all(|p| {
                let away = (p.xy() - w.point).dot(&w.normal);
                away <= 4.0 * f64::EPSILON * (p.amax() + w.point.amax())
            })
        });
        if !behind {
            return Err(SceneFault::OpenBorder { border });
        }
    }
    Ok(())
}

/// Of the scene's balls, m.
pub(super) fn largest_radius(scene: &Scene) -> f64 {
    scene.balls.iter().map(|ball| ball.radius).fold(0.0, f64::max)
}

/// Places in the scene's list by rank of name.
fn rank_by_name(balls: &[BallSpec]) -> Result<Vec<usize>, SceneFault> {
    let mut order: Vec<usize> = (0..balls.len()).collect();
    order.sort_by(|a, b| balls[*a].name.as_bytes().cmp(balls[*b].name.as_bytes()).then(a.cmp(b)));
    for pair in order.windows(2) {
        if balls[pair[0]].name == balls[pair[1]].name {
            let name = balls[pair[0]].name.clone();
            return Err(SceneFault::SameName { name, first: pair[0], second: pair[1] });
        }
    }
    Ok(order)
}

/// Bounds of the net in x and y.
fn extent(patch: &BezierPatch) -> [f64; 4] {
    patch.net().iter().fold([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY], |b, p| {
        [b[0].min(p.x), b[1].min(p.y), b[2].max(p.x), b[3].max(p.y)]
    })
}

/// Length of the step that a ball tries first, s.
pub(super) const fn first_step(accuracy: Accuracy) -> f64 {
    match accuracy {
        Accuracy::Tolerance(_) => tolerance::STEP_FIRST,
        Accuracy::Fixed(_, h) => h,
    }
}

fn set_down(scene: &Scene, surface: &Surface, index: usize) -> Result<(Ball, State), SceneFault> {
    let spec = &scene.balls[index];
    let rolls = scene.motion == MotionLaw::Rolling;
    let inertia_factor = if rolls { spec.inertia_factor } else { 0.0 };
    let body = Body { radius: spec.radius, inertia_factor, rolls, applied: scene.gravity };
    let q = place::contact(surface, &spec.place, spec.radius)
        .map_err(|why| SceneFault::OffFloor { ball: index, why })?;
    let mut state: State = [0.0; ROLLING];
    state[..2].copy_from_slice(&q);
    let (_, n) = body.seat(surface, &state);
    let w = spec.velocity - n * spec.velocity.dot(&n);
    state[2..5].copy_from_slice(w.as_slice());
    if rolls {
        state[5] = spec.spin * spec.radius;
    }
    let ball = Ball {
        body,
        mass: spec.mass,
        inverse_mass: 1.0 / ((1.0 + inertia_factor) * spec.mass),
        stepping: Stepping { try_s: first_step(scene.accuracy), steps: 0, forced: 0 },
        drive: None,
        hits: 0,
        rest_hits: 0,
        hits_quantum: 0,
        free_omega: if rolls || spec.spin == 0.0 { V3::zeros() } else { n * spec.spin },
    };
    Ok((ball, state))
}
