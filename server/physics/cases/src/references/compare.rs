//! A reference beside the engine's run.

use super::charts::Shape;
use super::floors::Chart;
use super::table::{RATE_HZ, SECONDS, Table};
use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::ride::{Largest, run};
use crate::scenes::{contact, in_list_order, scene, still};
use ballroom_physics::{BallSpec, BallState, MotionLaw, Scene, SceneFault, Wall};
use nalgebra::{Quaternion, UnitQuaternion, Vector2, Vector3};
use std::sync::Arc;

/// A floor, and what of it is the same for every ball.
#[derive(Clone, Debug)]
pub struct Ground {
    /// Its surface.
    pub shape: Shape,
    /// Walls stand at [-half, half]^2, m.
    pub half: f64,
    /// m/s^2, down.
    pub gravity: f64,
    /// How it is given to the engine; each makes a case.
    pub charts: &'static [Chart],
}

/// A ball at the start.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// m.
    pub radius: f64,
    /// Inertia factor; 0 slides.
    pub k: f64,
    /// x and y of the contact point, m.
    pub contact: [f64; 2],
    /// Horizontal velocity before it is projected to the tangent plane, m/s.
    pub velocity: [f64; 2],
    /// About the normal, rad/s.
    pub spin: f64,
    /// kg.
    pub mass: f64,
}

/// A generated file and the scene it is about.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Of the file and the case.
    pub name: &'static str,
    /// What happens.
    pub title: &'static str,
    /// The file.
    pub text: &'static str,
    /// The floor.
    pub ground: Ground,
    /// The balls.
    pub balls: Vec<Start>,
    /// Walls besides those of the box: points and inward normals of any length.
    pub walls: Vec<[[f64; 2]; 2]>,
    /// Coefficient of restitution.
    pub restitution: f64,
}

impl Reference {
    fn rolls(&self) -> bool {
        self.balls[0].k > 0.0
    }

    /// Its scene on one of the charts.
    pub fn scene(&self, chart: Chart) -> Scene {
        let Ground { shape, half, gravity, .. } = &self.ground;
        let border = [-half, *half];
        let motion = if self.rolls() { MotionLaw::Rolling } else { MotionLaw::Frictionless };
        let mut scene = scene(chart.floor(shape, *half), border, border, motion);
        scene.gravity = Vector3::new(0.0, 0.0, -gravity);
        scene.restitution = self.restitution;
        scene.walls.extend(self.walls.iter().map(|[point, inward]| {
            let normal = Vector2::from(*inward).normalize();
            Wall { point: Vector2::from(*point), normal }
        }));
        scene.balls = self.balls.iter().enumerate().map(|(n, start)| start.ball(n)).collect();
        scene
    }

    fn demands(&self) -> Vec<Demand> {
        let span = Span::Seconds(f64::from(SECONDS));
        let over_ticks = |quantity, unit, limit| Demand::over_ticks(quantity, unit, span, limit);
        let mut demands = vec![over_ticks("centre", "m", 1e-11), over_ticks("velocity", "m/s", 1e-10)];
        if self.rolls() {
            // What a point of the ball's skin may be off is what its centre may be.
            let radius = self.balls.iter().map(|ball| ball.radius).fold(1.0, f64::min);
            demands.push(over_ticks("angular velocity", "rad/s", 1e-10 / radius));
            demands.push(over_ticks("orientation", "rad", 1e-11 / radius));
        }
        if self.meets() {
            demands.push(Demand { norm: "largest over hits", ..over_ticks("time of impact", "s", 1e-11) });
        }
        demands.push(Demand::at_the_end("time the floor would have to pull", "s", span, 0.0));
        demands
    }

    fn meets(&self) -> bool {
        self.balls.len() > 1 || !self.walls.is_empty()
    }

    /// Largest errors of centre, velocity, angular velocity, orientation and times of impact, and the time during which the
    /// floor would have had to pull, where the scene would no longer be one of balls that roll.
    pub fn errors(&self, scene: &Scene) -> Result<[f64; 6], SceneFault> {
        let table = Table::read(self.text);
        let mut largest = [Largest::default(); 5];
        let mut hits = vec![];
        let engine = run(scene, RATE_HZ, u64::from(RATE_HZ * SECONDS), |tick, engine| {
            hits.extend(engine.hits().iter().map(|hit| hit.time.seconds()));
            for (own, exact) in in_list_order(engine).iter().zip(&table.ticks[tick as usize]) {
                largest[0].see_center(own, exact.center);
                largest[1].see((own.velocity - exact.velocity).norm());
                if let Some((omega, orientation)) = &exact.turning {
                    largest[2].see((own.omega - omega).norm());
                    largest[3].see(angle_between(own, orientation));
                }
            }
        })?;
        if hits.len() == table.hits.len() {
            hits.iter().zip(&table.hits).for_each(|(own, exact)| largest[4].see(own - exact));
        } else {
            largest[4].see(f64::INFINITY);
        }
        let [center, velocity, spin, orientation, time] = largest.map(Largest::value);
        Ok([center, velocity, spin, orientation, time, engine.report().negative_reaction])
    }

    fn measure(&self, chart: Chart) -> Result<Vec<f64>, SceneFault> {
        let [center, velocity, spin, orientation, time, pull] = self.errors(&self.scene(chart))?;
        let turning = if self.rolls() { vec![spin, orientation] } else { vec![] };
        let times = if self.meets() { vec![time] } else { vec![] };
        Ok([vec![center, velocity], turning, times, vec![pull]].concat())
    }

    /// A case for each chart.
    pub fn cases(self) -> Vec<Case> {
        let reference = Arc::new(self);
        let charts = reference.ground.charts;
        charts
            .iter()
            .map(|chart| {
                let reference = Arc::clone(&reference);
                let id = format!("R/{}{}", reference.name, chart.suffix());
                let title =
                    format!("{}; known to {:e}", reference.title, Table::own_error_of(reference.text));
                Case::with(id, title, reference.demands(), move || reference.measure(*chart))
            })
            .collect()
    }
}

impl Start {
    fn ball(&self, number: usize) -> BallSpec {
        let [x, y] = self.contact;
        BallSpec {
            mass: self.mass,
            // A sliding ball's inertia acts on nothing, but there must be one.
            inertia_factor: if self.k > 0.0 { self.k } else { crate::scenes::SOLID },
            velocity: Vector3::new(self.velocity[0], self.velocity[1], 0.0),
            spin: self.spin,
            ..still(&number.to_string(), self.radius, contact(x, y))
        }
    }
}

/// The angle of the rotation from one orientation to the other, rad; exact also where it is tiny.
pub fn angle_between(own: &BallState, exact: &UnitQuaternion<f64>) -> f64 {
    let [x, y, z, w] = own.orientation;
    let between = exact.conjugate().into_inner() * Quaternion::new(w, x, y, z);
    2.0 * between.imag().norm().atan2(between.w.abs())
}
