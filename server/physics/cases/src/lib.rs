//! Closed forms and hard cases as data: each a scene, its exact answer and what is demanded of the engine.
//!
//! The tests, `ballroom hardcases` and reports read the same rows. No clock, no I/O: who runs a case measures its time.
//!
//! | room | what |
//! |---|---|
//! | [`case`], [`demand`] | a row: what is demanded, what was measured |
//! | [`mod@select`] | all rows, and some of them by the beginning of their ids |
//! | [`hard`] | cases that break typical engines, one family a file |
//! | [`closed_forms`] | motion and hits with exact answers |
//! | [`references`] | trajectories on any floor, from another formulation in 33 and 42 digits |
//! | [`scenes`], [`ride`], [`mirror`] | scenes in few words, and ways to run and compare them |
//! | [`gas`] | a gas of any number of balls, to measure with |
//! | [`small`] | small scenes to time and to count, which differ in one feature each |

pub mod case;
pub mod closed_forms;
pub mod demand;
pub mod gas;
pub mod hard;
pub mod mirror;
pub mod references;
pub mod ride;
pub mod scenes;
pub mod select;
pub mod small;

pub use case::{Case, Row};
pub use demand::{Demand, Span};
pub use select::{UnknownCase, all, select};
