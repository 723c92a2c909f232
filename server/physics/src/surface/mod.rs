//! Where a ball can be.
pub mod bezier;
pub mod jet;
mod polynomial;
