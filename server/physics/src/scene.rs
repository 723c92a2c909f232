//! What the engine is given: a scene without words, files or defaults.

use crate::surface::bezier::BezierPatch;
use crate::surface::certify::{FloorPlace, Irregularity};
use nalgebra::{Vector2, Vector3};

/// A scene as the engine takes it.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The floor.
    pub floor: Floor,
    /// Vertical planes that hold the balls in.
    pub walls: Vec<Wall>,
    /// The balls, in any order; the engine orders them by name.
    pub balls: Vec<BallSpec>,
    /// Gravity, m/s^2.
    pub gravity: Vector3<f64>,
    /// How balls move.
    pub motion: MotionLaw,
    /// Coefficient of restitution, 0 to 1.
    pub restitution: f64,
    /// How exactly.
    pub accuracy: Accuracy,
    /// Hits that one ball may have within a quantum of 1/64 s before it is held until the quantum ends: a bound of work,
    /// never of wall time, so that a slow machine computes the same run. [`HIT_BUDGET`] is the usual one.
    pub hit_budget: u32,
}

/// The hit budget of scenes that name none. The 3 141 592 hits of a light ball between a wall and a ball 1e12 times as
/// heavy fit in.
pub const HIT_BUDGET: u32 = 1 << 22;

/// The floor, as one Bezier patch over (u, v) in the unit square.
#[derive(Clone, Debug, PartialEq)]
pub enum Floor {
    /// A net of control points.
    Bezier(BezierPatch),
    /// z = sum over i, j of `terms[i][j]` x^i y^j over a rectangle; exact also where a net would round.
    Polynomial {
        /// West and east border, m.
        x: [f64; 2],
        /// South and north border, m.
        y: [f64; 2],
        /// Coefficients, m^(1-i-j); `terms[i]` belongs to x^i. Empty is the plane z = 0.
        terms: Vec<Vec<f64>>,
    },
}

/// A vertical plane; centres stay a radius in front of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// A point of the plane (x, y), m.
    pub point: Vector2<f64>,
    /// Unit normal into the room (x, y).
    pub normal: Vector2<f64>,
}

/// How balls move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionLaw {
    /// Sliding without friction.
    Frictionless,
    /// Rolling without slip, with spin about the normal.
    Rolling,
}

/// How exactly motion is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accuracy {
    /// Position error wanted over 10 s of smooth motion, m.
    Tolerance(f64),
    /// A scheme and its step, s.
    Fixed(Scheme, f64),
}

/// An explicit Runge-Kutta scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Classical, order 4.
    Rk4,
    /// Tsitouras 5(4).
    Tsit5,
    /// Dormand and Prince 8(5,3).
    Dop853,
}

/// One ball at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct BallSpec {
    /// Unique.
    pub name: String,
    /// Radius, m.
    pub radius: f64,
    /// Mass, kg.
    pub mass: f64,
    /// Moment of inertia over m r^2.
    pub inertia_factor: f64,
    /// Where.
    pub place: Place,
    /// Velocity of the centre, m/s; projected to the tangent plane.
    pub velocity: Vector3<f64>,
    /// Spin about the floor's normal, rad/s.
    pub spin: f64,
}

/// Where a ball starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// x and y of its centre, m.
    Center(Vector2<f64>),
    /// x and y of its contact point, m.
    Contact(Vector2<f64>),
    /// Parameters of its contact point.
    Uv(Vector2<f64>),
}

/// Why a scene cannot run. `ball` and `wall` are places in the scene's own lists.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneFault {
    /// A number that is not finite or out of its range.
    #[error("{field} is {value}: {want}")]
    Number {
        /// Which, for instance `balls[2].radius` or `gravity`.
        field: String,
        /// What it is.
        value: f64,
        /// What would be right.
        want: &'static str,
    },
    /// Two balls of one name.
    #[error("balls {first} and {second} share the name {name:?}: give each ball a name of its own")]
    SameName {
        /// The name.
        name: String,
        /// Places in the list.
        first: usize,
        /// See `first`.
        second: usize,
    },
    /// Two balls overlap.
    #[error("balls {first} and {second} overlap by {depth:e} m: move them apart")]
    Overlap {
        /// Places in the list.
        first: usize,
        /// See `first`.
        second: usize,
        /// How deep, m.
        depth: f64,
    },
    /// A ball is not over the floor.
    #[error("ball {ball} is not over the floor: {why}")]
    OffFloor {
        /// Place in the list.
        ball: usize,
        /// What was tried.
        why: &'static str,
    },
    /// A ball overlaps a wall.
    #[error("ball {ball} reaches {depth:e} m into wall {wall}: move it inside")]
    InWall {
        /// Place in the list.
        ball: usize,
        /// Place in the list.
        wall: usize,
        /// How deep, m.
        depth: f64,
    },
    /// A border of the floor is not behind a wall.
    #[error("the floor's border {border} is not behind any wall: balls could leave the floor there")]
    OpenBorder {
        /// `u = 0`, `u = 1`, `v = 0` or `v = 1`.
        border: &'static str,
    },
    /// The floor has no upward normal somewhere, or is not proved to have one.
    #[error("the floor {kind}, near {at}")]
    Degenerate {
        /// What is wrong.
        kind: Irregularity,
        /// Where.
        at: FloorPlace,
    },
    /// The floor is too tightly curved for a ball.
    #[error(
        "the floor's curvature times radius reaches {lo} to {hi} at {at} for ball {ball}: it must stay below 1"
    )]
    TooCurved {
        /// Place in the list.
        ball: usize,
        /// Certified bracket of the largest concave curvature times radius.
        lo: f64,
        /// See `lo`.
        hi: f64,
        /// Where it is largest.
        at: FloorPlace,
    },
    /// A ball may touch the floor in two places at once.
    #[error(
        "ball {ball} of radius {radius} m may lie on the floor at {contact} and touch it again at {touch}: only balls \
         smaller than {lo} to {hi} m touch it once"
    )]
    SecondTouch {
        /// Place in the list.
        ball: usize,
        /// Its radius, m.
        radius: f64,
        /// Certified bracket of the reach, m.
        lo: f64,
        /// See `lo`.
        hi: f64,
        /// Where the ball of that radius lies.
        contact: FloorPlace,
        /// Where it touches again.
        touch: FloorPlace,
    },
}
