//! The controller: owns the balls and advances them from tick to tick.
//!
//! | stage | file |
//! |---|---|
//! | a scene is checked and its balls are set down | `load` |
//! | an advance: the first event of all, again and again | `advance` |
//! | what a ball will meet within its window | `predict` |
//! | next arcs, several at once | `prepare` |
//! | landing on hits | `approach` |
//! | hits, several at once | `foresee` |
//! | memory, asked for ahead | `fetch` |
//! | a hit of two | `bounce` |
//! | a hit, whoever else touches | `collide` |
//! | a push, a held force | `steer` |
//! | balls set anew, all or none | `reseat` |
//! | other balls, another floor, other laws from now on | `succeed` |
//! | what a tick shows: states, energy | `observe` |
//! | a run as words: saved, restored, hashed | `checkpoint`, `plain` |
//! | whether words from outside can be a run's | `sound` |
//! | hits and sums, instant by instant | `ledger` |
//! | a run in several parts at once, to the same bits | `shards` |

mod advance;
mod approach;
mod bounce;
pub mod checkpoint;
mod collide;
mod fetch;
mod foresee;
mod ledger;
mod load;
mod observe;
mod plain;
mod predict;
mod prepare;
mod reseat;
mod shards;
mod sound;
mod steer;
mod succeed;

pub use observe::Observer;
pub use reseat::{Seat, SeatFault, Spot};
pub use shards::{Division, SHARDS_MAX, Shard};
pub use succeed::Successor;

use crate::detect::ball_wall::Plane;
use crate::detect::broad_phase::{Bounds, BroadPhase};
use crate::diagnostics::{Hit, Report};
use crate::motion::arc::Arc;
use crate::motion::body::{Body, Stepping};
use crate::resolve::impact::Scratch;
use crate::scene::Accuracy;
use crate::schedule::queue::Queue;
use crate::schedule::time::Time;
use crate::surface::bezier::BezierPatch;
use crate::surface::certify::Certificate;
use crate::surface::chart::Surface;
use crate::tolerance::CLUSTER_MAX;
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

/// What a ball is, does and is about to do, beside its arc and its next event. What every hit asks of it stands first, in two
/// lines of cache.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Ball {
    body: Body,
    /// 1/((1+k) m).
    inverse_mass: f64,
    /// Hits in quantum `hits_quantum`, and the slow ones among them.
    hits: u32,
    rest_hits: u32,
    hits_quantum: i64,
    stepping: Stepping,
    drive: Option<Drive>,
    /// Mass, kg.
    mass: f64,
    /// Angular velocity of a sliding ball, rad/s: constant.
    free_omega: Vector3<f64>,
}

/// The engine: one scene being run. Balls are numbered by the rank of their names in byte order.
#[derive(Clone, Debug)]
pub struct Controller {
    surface: Surface,
    patch: BezierPatch,
    certificate: Certificate,
    walls: Vec<Plane>,
    /// Balls whose bounds lie in it meet no wall.
    room: Bounds,
    /// The longer side of the floor, m.
    span: f64,
    gravity: Vector3<f64>,
    restitution: f64,
    accuracy: Accuracy,
    hit_budget: u32,
    balls: Vec<Ball>,
    arcs: Vec<Arc>,
    broad_phase: BroadPhase,
    queue: Queue,
    scene_index: Vec<usize>,
    /// Time of the caller's last advance.
    time: Time,
    /// Time of the last event; never ahead of `time` but for the polish of a hit.
    now: Time,
    hits: Vec<Hit>,
    report: Report,
    ledger: ledger::Ledger,
    work: Work,
    /// What a shard notes, and the whole of a divided run.
    share: Option<Box<shards::Share>>,
    /// The parts of a divided run.
    shards: Option<Box<shards::Shards>>,
}

/// Balls that one search may find before its list grows.
const FOUND: usize = 1024;

/// Working memory of an advance, kept so that none allocates.
#[derive(Debug)]
struct Work {
    scratch: Scratch,
    cluster: Option<Box<collide::Cluster>>,
    ahead: prepare::Ahead,
    /// Whom a search found.
    found: Vec<predict::Encounter>,
    foresight: foresee::Foresight,
    fetch: fetch::Fetch,
    /// Whether several balls can be computed side by side on this floor and this machine.
    side_by_side: bool,
}

/// A copy has as much room, empty: a run that begins as a copy must not take memory at its first hit.
impl Clone for Work {
    fn clone(&self) -> Self {
        let Self { ahead, foresight, fetch, side_by_side, .. } = self;
        Self {
            scratch: Scratch::with_room(CLUSTER_MAX + 1),
            cluster: Some(Box::new(collide::Cluster::new())),
            ahead: ahead.clone(),
            found: Vec::with_capacity(FOUND),
            foresight: foresight.clone(),
            fetch: fetch.clone(),
            side_by_side: *side_by_side,
        }
    }
}

impl Work {
    /// For so many balls, `width` of which are computed side by side.
    fn new(balls: usize, width: usize) -> Self {
        Self {
            scratch: Scratch::with_room(CLUSTER_MAX + 1),
            cluster: Some(Box::new(collide::Cluster::new())),
            ahead: prepare::Ahead::new(balls, width),
            found: Vec::with_capacity(FOUND),
            foresight: foresee::Foresight::new(balls, width),
            fetch: fetch::Fetch::new(balls),
            side_by_side: width > 1,
        }
    }
}

impl Controller {
    /// The controller's time.
    pub const fn time(&self) -> Time {
        self.time
    }

    /// Hits of the last advance in order of time, those of one instant by ball, at most [`crate::tolerance::HITS_KEPT`].
    pub fn hits(&self) -> &[Hit] {
        &self.hits
    }

    /// For each id, the ball's place in the scene's list.
    pub fn scene_index(&self) -> &[usize] {
        &self.scene_index
    }

    /// Sums since the start.
    pub const fn report(&self) -> Report {
        self.report
    }

    /// The floor as its exact net.
    pub const fn patch(&self) -> &BezierPatch {
        &self.patch
    }

    /// What loading proved about the floor; its reach no more narrowly than the scene's balls need. `certify` finds the rest.
    pub const fn certificate(&self) -> &Certificate {
        &self.certificate
    }
}
