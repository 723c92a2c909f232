//! Ballroom's server: an authoritative simulation of rolling and colliding balls.
//!
//! A command travels from `network` through the `inbox` to the `tick_loop`, which applies it to the `simulation` at a
//! tick; a state travels from there through the `handover` to the publisher in `network`. One world with all of these is
//! an [`Arena`].
//!
//! | file | what |
//! |---|---|
//! | [`scene_file`] | from the text people write to what the engine takes |
//! | [`simulation`] | commands in, ticks on, states out; no clock, no I/O |
//! | [`places`] | where the balls of a scene may be put |
//! | [`workshop`] | what takes longer than a tick has, made ready on a thread of its own |
//! | [`checker`] | scenes that are asked about |
//! | [`features`] | what is understood, with limits |
//! | [`inbox`] | commands as they arrive: bounded, in order |
//! | [`tick_loop`] | a fixed rate, on a plain thread |
//! | [`meter`] | how long ticks take |
//! | [`handover`] | from the tick thread to the publisher |
//! | [`checkpoint_file`] | a run saved, to go on with later |
//! | [`recording`] | what a run was given and what became of it, in a file; and the run again |
//! | `network` | the only place that names Zenoh |
//! | [`arena`] | all of it together |
//! | [`arenas`] | several of them in one process |

pub mod arena;
pub mod arenas;
pub mod checker;
pub mod checkpoint_file;
pub mod features;
pub mod handover;
pub mod inbox;
pub mod meter;
mod network;
pub mod places;
pub mod recording;
pub mod scene_file;
pub mod simulation;
pub mod tick_loop;
pub mod workshop;

pub use arena::{Arena, ArenaError, ArenaHandle, ArenaOptions, NetworkOptions};
pub use arenas::Arenas;
pub use network::NetworkError;
pub use scene_file::{LoadedScene, SceneError, SceneText};
