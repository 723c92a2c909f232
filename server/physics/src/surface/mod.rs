//! Where a ball can be.
mod affine;
pub mod bezier;
pub mod certify;
mod derivative_nets;
pub mod jet;
mod polynomial;
