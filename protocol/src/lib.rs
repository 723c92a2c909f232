//! What is said on Ballroom's wire, and nothing else: no transport, no physics.
//!
//! | file | what |
//! |---|---|
//! | [`scene`] | the scene file, version 1: what people write and viewers draw |
//! | [`scene_text`] | TOML to a scene, with errors that name file, line and field |
//! | [`command`] | what a client may ask of a running arena, and the answer |
//! | [`steering`] | where a player wants a ball to go |
//! | [`change`] | what of a world a command may change |
//! | [`parameter`] | numbers of a scene that may be read, and some of them set |
//! | [`reply`] | done at which tick, or why not, with a code |
//! | [`player`] | who drives which ball, and what they say while they do |
//! | [`snapshot`] | the state of all balls at a tick |
//! | [`event`] | one hit, with time, place and impulse |
//! | [`state`] | whether the clock runs |
//! | [`arenas`] | several arenas in one process |
//! | [`check`] | whether a scene could be run |
//! | [`report`] | how states reach those who read them |
//! | [`stats`] | what the server says of itself once a second |
//! | [`info`] | frames, units and versions, for whoever asks |
//! | [`listing`] | lists for whoever asks: balls, scenes, features |
//! | [`timeline`] | what of a run can be gone back to: history, slots, a state as a file |
//! | [`keys`] | the names under which all this travels |
//! | [`codec`] | bytes to values and back; every limit on size stands there |

pub mod arenas;
pub mod change;
pub mod check;
pub mod codec;
pub mod command;
pub mod event;
pub mod info;
pub mod keys;
pub mod listing;
pub mod parameter;
pub mod player;
pub mod reply;
pub mod report;
pub mod scene;
pub mod scene_text;
pub mod snapshot;
pub mod state;
pub mod stats;
pub mod steering;
pub mod timeline;
