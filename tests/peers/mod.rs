//! Other engines beside ours, on the same cases in the same run.
//!
//! | file | what |
//! |---|---|
//! | [`problem`], [`standard`] | a case as every contestant is told it; the standard ones |
//! | [`contestant`] | what a contestant can do, and how it is run and timed |
//! | [`ours`], [`rapier`] | the contestants of this process |
//! | [`knobs`] | what can be set in Rapier |
//! | [`measure`] | error, energy, overlap |
//! | [`rows`] | best rows, ratios, and where a peer wins |

pub mod contestant;
pub mod knobs;
pub mod measure;
pub mod others;
pub mod ours;
pub mod problem;
pub mod rapier;
pub mod rows;
pub mod run;
pub mod section;
pub mod standard;
