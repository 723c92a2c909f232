//! Where a ball can be.
pub mod bezier;
