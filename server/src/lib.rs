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
//! | [`world`] | what of a run no tick changes: scene, floor, who the balls are |
//! | [`change`] | a world becomes another one while it runs |
//! | [`parameters`] | numbers of a scene that may be read, and some of them set |
//! | [`workshop`] | what takes longer than a tick has, made ready on a thread of its own |
//! | [`checker`] | scenes that are asked about |
//! | [`features`] | what is understood, with limits |
//! | [`bucket`] | how many messages one source may send |
//! | [`inbox`] | commands as they arrive: bounded, in order |
//! | [`wanted`] | players' commands that wait for their ticks |
//! | [`players`] | who drives which ball: claims, windows, dead-man |
//! | [`tick_loop`] | a fixed rate, on a plain thread |
//! | [`crew`] | the threads that run a large scene together |
//! | [`meter`] | how long ticks take |
//! | [`handover`] | from the tick thread to the publisher |
//! | [`history`] | what of a run can be gone back to |
//! | [`checkpoint_file`] | a run saved, to go on with later |
//! | [`recording`] | what a run was given and what became of it, in a file; and the run again |
//! | [`report`] | speed against error, measured and written as a page |
//! | [`shadows`] | how exactly a run is computed, estimated while it runs |
//! | [`rehearsal`] | the tolerance that keeps an error or fits in a budget |
//! | [`screening`] | a recording shown again, at any speed |
//! | `network` | the only place that names Zenoh |
//! | [`terminal`] | keys in, a few lines out, for whoever plays in a terminal |
//! | [`arena`] | all of it together |
//! | [`arenas`] | several of them in one process |

pub mod arena;
pub mod arenas;
pub mod bucket;
pub mod change;
pub mod checker;
pub mod checkpoint_file;
pub mod crew;
pub mod features;
pub mod handover;
pub mod history;
pub mod inbox;
pub mod meter;
mod network;
pub mod parameters;
pub mod players;
pub mod ready;
pub mod recording;
pub mod rehearsal;
pub mod report;
pub mod scene_file;
pub mod screening;
pub mod shadows;
pub mod simulation;
pub mod terminal;
pub mod tick_loop;
pub mod wanted;
pub mod workshop;
pub mod world;

pub use arena::{Arena, ArenaError, ArenaHandle, ArenaOptions, NetworkOptions};
pub use arenas::Arenas;
pub use network::{NetworkError, begin_with_enough_threads};
pub use scene_file::{LoadedScene, SceneError, SceneText};
