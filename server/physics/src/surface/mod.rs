//! Where a ball can be.
//!
//! `bezier` is the patch as people give it; `chart` holds its fast evaluations, one kernel for a kind of
//! floor (`height`, `net`), chosen once when the scene is loaded; `certify` proves that every ball fits; `place` sets a ball.

mod affine;
mod basis;
pub mod bezier;
pub mod certify;
pub mod chart;
mod derivative_nets;
mod height;
pub mod jet;
mod net;
pub mod place;
mod polynomial;
