//! The controller: owns the balls and advances them from tick to tick.

use crate::diagnostics::{Hit, Report};
use crate::scene::{Scene, SceneFault};
use crate::schedule::time::Time;
use crate::surface::bezier::BezierPatch;
use nalgebra::{Vector2, Vector3};

/// A ball at the controller's time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BallState {
    /// Parameters of the contact point.
    pub uv: Vector2<f64>,
    /// Centre, m.
    pub center: Vector3<f64>,
    /// Unit normal of the floor at the contact point.
    pub normal: Vector3<f64>,
    /// Velocity of the centre, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub omega: Vector3<f64>,
    /// Orientation, ball to world: x, y, z, w.
    pub orientation: [f64; 4],
}

/// A player's held force on a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Horizontal direction, length at most 1.
    pub direction: Vector2<f64>,
    /// Acceleration at length 1, m/s^2.
    pub acceleration: f64,
    /// The drive never raises the speed above this, m/s.
    pub speed_limit: f64,
}

/// The engine: one scene being run. Balls are numbered by the rank of their names in byte order.
pub struct Controller {}

impl Controller {
    /// Checks the scene, certifies the floor and sets every ball on it.
    pub fn new(_scene: &Scene) -> Result<Self, SceneFault> {
        todo!()
    }
    /// The controller's time.
    pub fn time(&self) -> Time {
        todo!()
    }
    /// Advances to `time`: every hit up to and including it is resolved. Earlier times do nothing.
    /// `hits` holds the hits of this call afterwards, up to its capacity set at the start.
    pub fn advance_to(&mut self, _time: Time) {
        todo!()
    }
    /// Hits of the last advance in order of time, at most 65 536.
    pub fn hits(&self) -> &[Hit] {
        todo!()
    }
    /// The balls at the controller's time, by id.
    pub fn balls(&self) -> &[BallState] {
        todo!()
    }
    /// For each id, the ball's place in the scene's list.
    pub fn scene_index(&self) -> &[usize] {
        todo!()
    }
    /// Sums since the start.
    pub fn report(&self) -> Report {
        todo!()
    }
    /// Total energy at the controller's time, J.
    pub fn energy(&self) -> f64 {
        todo!()
    }
    /// Hash of everything that influences the future; equal at equal times whatever the tick rate and the list's order.
    pub fn state_hash(&self) -> u64 {
        todo!()
    }
    /// Adds `delta` (horizontal, m/s) to a ball's velocity inside the tangent plane, without raising the speed above
    /// `speed_limit` (a speed already above it is not raised further).
    pub fn push(&mut self, _ball: usize, _delta: Vector2<f64>, _speed_limit: f64) {
        todo!()
    }
    /// Sets or releases the held force on a ball.
    pub fn drive(&mut self, _ball: usize, _drive: Option<Drive>) {
        todo!()
    }
    /// The floor as its exact net.
    pub fn patch(&self) -> &BezierPatch {
        todo!()
    }
    /// Certified bracket [lo, hi] of the floor's largest concave principal curvature, 1/m (0 when nowhere concave).
    pub fn curvature_bracket(&self) -> [f64; 2] {
        todo!()
    }
}
