//! The scene file, version 1. Lengths in metres, times in seconds, angles in radians, z up.

use serde::{Deserialize, Serialize};

/// The version this crate reads and writes.
pub const SCENE_VERSION: u32 = 1;

/// A scene as people write it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// File format version, [`SCENE_VERSION`].
    pub version: u32,
    /// Short name, `[a-z0-9_-]`.
    pub name: String,
    /// What to look for, one or two sentences.
    #[serde(default)]
    pub description: String,
    /// Gravity; must point down on the floor's side of the balls.
    #[serde(default = "default_gravity")]
    pub gravity_m_per_s2: [f64; 3],
    /// How balls move on the floor.
    #[serde(default)]
    pub motion: Motion,
    /// Coefficient of restitution of every hit, 0 to 1.
    #[serde(default = "one")]
    pub restitution: f64,
    /// How exactly motion is computed.
    #[serde(default)]
    pub accuracy: Accuracy,
    /// Hits one ball may have within 1/64 s before it is held until they are over: a bound of work.
    #[serde(default = "default_hit_budget")]
    pub hit_budget: u32,
    /// The one floor.
    pub floor: Floor,
    /// Vertical walls.
    #[serde(default)]
    pub walls: Walls,
    /// What a player's key does.
    #[serde(default)]
    pub steering: Steering,
    /// Balls, one by one.
    #[serde(default, rename = "ball", skip_serializing_if = "Vec::is_empty")]
    pub balls: Vec<Ball>,
    /// Balls by the crowd, from a seed.
    #[serde(default, rename = "cloud", skip_serializing_if = "Vec::is_empty")]
    pub clouds: Vec<Cloud>,
}

fn default_gravity() -> [f64; 3] {
    [0.0, 0.0, -9.81]
}
fn default_hit_budget() -> u32 {
    1 << 22
}
fn one() -> f64 {
    1.0
}

/// How balls move on the floor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// Sliding without friction; spin does not act.
    Frictionless,
    /// Rolling without slip, with spin about the normal.
    #[default]
    Rolling,
}

/// How exactly motion is computed: a tolerance, or an error, or a budget of work, or an integrator and a step by name. One of
/// them: a tolerance and a budget together would ask for two answers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    untagged,
    expecting = "write one of tolerance_m = METRES, or error_m = METRES, or budget_evaluations = NUMBER per ball and \
                 simulated second, or integrator = \"rk4\", \"tsit5\" or \"dop853\" with step_s = SECONDS"
)]
pub enum Accuracy {
    /// Largest position error wanted over 10 s of smooth motion.
    #[serde(rename_all = "snake_case")]
    Tolerance {
        /// Metres, 1e-13 to 1e-2.
        tolerance_m: f64,
    },
    /// The largest tolerance with which no ball is farther from where it truly is at any tick of 10 s: the whole scene is run
    /// beforehand to find it, with its walls, hits and hills. Where they multiply errors too much it is refused.
    Error {
        /// Metres, 1e-11 to 1e-2.
        error_m: f64,
    },
    /// The smallest tolerance that so much work pays for: a few balls are run beforehand to find it, counted and not
    /// timed, so that every machine finds the same.
    Budget {
        /// Evaluations of the equations of motion per ball and simulated second, 1 to 1e9.
        budget_evaluations: f64,
    },
    /// A fixed step.
    Fixed {
        /// Which scheme.
        integrator: Integrator,
        /// Seconds.
        step_s: f64,
    },
}

impl Default for Accuracy {
    fn default() -> Self {
        Self::Tolerance { tolerance_m: 1e-9 }
    }
}

/// An explicit Runge-Kutta scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Integrator {
    /// The classical scheme of order 4.
    Rk4,
    /// Tsitouras 5(4).
    Tsit5,
    /// Dormand and Prince 8(5,3).
    Dop853,
}

/// The floor: one tensor-product Bezier patch, written in one of three ways.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Floor {
    /// Control heights over a regular grid; x and y are affine in u and v.
    Grid {
        /// West and east border.
        x_m: [f64; 2],
        /// South and north border.
        y_m: [f64; 2],
        /// `control_heights_m[j][i]`: row j along v (y, south to north), column i along u (x, west to east).
        control_heights_m: Vec<Vec<f64>>,
    },
    /// Control points in full.
    Net {
        /// `control_points_m[j][i] = [x, y, z]`: row j along v, column i along u.
        control_points_m: Vec<Vec<[f64; 3]>>,
    },
    /// z = sum of `c x^px y^py`, turned into its exact net.
    Polynomial {
        /// West and east border.
        x_m: [f64; 2],
        /// South and north border.
        y_m: [f64; 2],
        /// The terms; none is the horizontal plane z = 0.
        #[serde(default)]
        terms: Vec<Term>,
    },
}

/// One term `c x^px y^py` of a polynomial floor, x and y in metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Term {
    /// Power of x.
    #[serde(default)]
    pub px: u32,
    /// Power of y.
    #[serde(default)]
    pub py: u32,
    /// Coefficient, m^(1-px-py).
    pub c: f64,
}

/// Vertical walls: a box, further planes, or both. With neither the box stands on the floor's borders.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Walls {
    /// Four walls along x and y.
    #[serde(default, rename = "box", skip_serializing_if = "Option::is_none")]
    pub bounds: Option<WallBox>,
    /// Further vertical planes.
    #[serde(default, rename = "plane", skip_serializing_if = "Vec::is_empty")]
    pub planes: Vec<WallPlane>,
    /// How high the walls are drawn; balls meet them at any height.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drawn_height_m: Option<f64>,
}

/// Four walls along x and y.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallBox {
    /// West and east wall.
    pub x_m: [f64; 2],
    /// South and north wall.
    pub y_m: [f64; 2],
}

/// A vertical plane that balls stay in front of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallPlane {
    /// A point of the wall (x, y).
    pub point_m: [f64; 2],
    /// Direction into the room (x, y), of any length.
    pub normal: [f64; 2],
}

/// What a player's key does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Steering {
    /// Speed one press adds along its direction.
    pub impulse_m_per_s: f64,
    /// Acceleration while a key is held.
    pub acceleration_m_per_s2: f64,
    /// Steering never raises a ball's speed above this; gravity may.
    pub speed_limit_m_per_s: f64,
}

impl Default for Steering {
    fn default() -> Self {
        Self { impulse_m_per_s: 1.0, acceleration_m_per_s2: 4.0, speed_limit_m_per_s: 8.0 }
    }
}

/// One ball. Its place is given in exactly one of three ways.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ball {
    /// Unique.
    pub name: String,
    /// Radius.
    pub radius_m: f64,
    /// Mass.
    pub mass_kg: f64,
    /// Moment of inertia over m r^2.
    #[serde(default)]
    pub inertia: Inertia,
    /// x and y of the ball's centre.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center_m: Option<[f64; 2]>,
    /// x and y of the point where it touches the floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_m: Option<[f64; 2]>,
    /// The touching point's parameters on the patch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uv: Option<[f64; 2]>,
    /// Velocity of the centre; projected to the tangent plane.
    #[serde(default)]
    pub velocity_m_per_s: [f64; 3],
    /// Spin about the floor's normal.
    #[serde(default)]
    pub spin_rad_per_s: f64,
    /// `#rrggbb`; chosen by place in the list when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<String>,
    /// Whether a player may steer it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub player: bool,
    /// What to select it by, at most [`MAX_TAGS`], each 1 to 32 of `a-z`, `0-9`, `_` and `-`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tags: Vec<String>,
}

/// Most tags of a ball.
pub const MAX_TAGS: usize = 8;

/// Moment of inertia over m r^2: a number, or the name of one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "write \"solid\", \"hollow\" or a number from 0 to 2/3")]
pub enum Inertia {
    /// By name.
    Named(InertiaName),
    /// As a number, 0 to 2/3.
    Factor(f64),
}

impl Default for Inertia {
    fn default() -> Self {
        Self::Named(InertiaName::Solid)
    }
}

impl Inertia {
    /// The factor k.
    pub fn factor(self) -> f64 {
        match self {
            Self::Named(InertiaName::Solid) => 2.0 / 5.0,
            Self::Named(InertiaName::Hollow) => 2.0 / 3.0,
            Self::Factor(k) => k,
        }
    }
}

/// Bodies with a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InertiaName {
    /// Solid sphere, 2/5.
    Solid,
    /// Thin shell, 2/3.
    Hollow,
}

/// Many balls placed at random without overlap inside a disc, repeatably from a seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cloud {
    /// Names are `<name>-0001` and so on, with more digits where `count` has more.
    pub name: String,
    /// How many.
    pub count: u32,
    /// Seed of the generator.
    #[serde(default)]
    pub seed: u64,
    /// Smallest and largest radius, drawn uniformly.
    pub radius_m: [f64; 2],
    /// Density; mass follows from the radius.
    pub density_kg_per_m3: f64,
    /// Moment of inertia over m r^2.
    #[serde(default)]
    pub inertia: Inertia,
    /// Centre of the disc (x, y).
    #[serde(default)]
    pub around_m: [f64; 2],
    /// Radius of the disc that holds all centres.
    pub within_m: f64,
    /// Root mean square of the speed; directions are uniform.
    #[serde(default)]
    pub speed_rms_m_per_s: f64,
    /// What to select its balls by, as a [`Ball`]'s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tags: Vec<String>,
}
