//! The engine room: balls rolling and colliding on Bezier floors, by event.
//!
//! No bytes, no time of day, no threads, no files, no I/O: a run is a function of the scene and of the
//! pushes between ticks. SI units throughout.
//!
//! | room | question |
//! |---|---|
//! | [`surface`] | where a ball can be |
//! | [`motion`] | how it moves |
//! | [`detect`] | when something happens |
//! | [`resolve`] | what happens then |
//! | [`schedule`] | in which order |

#![allow(clippy::inline_always, reason = "what is compiled for wide vectors must be inlined whole")]

pub mod controller;
pub mod detect;
pub mod diagnostics;
mod lanes;
pub mod motion;
pub mod number;
pub mod resolve;
pub mod scene;
pub mod schedule;
pub mod surface;
pub mod tolerance;

pub use controller::checkpoint::{Checkpoint, CheckpointFault};
pub use controller::{
    BallState, Controller, Division, Drive, Observer, SHARDS_MAX, Seat, SeatFault, Shard, Spot, Successor,
};
pub use diagnostics::{Collisions, Hit, HitPartner, Report};
pub use scene::{Accuracy, BallSpec, Floor, HIT_BUDGET, MotionLaw, Place, Scene, SceneFault, Scheme, Wall};
pub use schedule::time::Time;
