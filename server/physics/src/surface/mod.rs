//! Where a ball can be.
//!
//! `bezier` is the patch as people give it; `chart` holds its fast evaluations, one kernel for a kind of
//! floor, chosen once when the scene is loaded; `certify` proves that every ball fits; `place` sets a ball.

mod affine;
pub mod bezier;
pub mod certify;
pub mod chart;
mod derivative_nets;
pub mod jet;
pub mod place;
mod polynomial;
