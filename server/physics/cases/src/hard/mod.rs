//! Hard cases: what breaks typical engines, each with its exact answer. One family a file.

pub mod cradle;
pub mod galperin;
pub mod rods;

use crate::case::Case;

/// Every case of this room, family by family.
pub fn cases() -> Vec<Case> {
    [galperin::cases(), cradle::cases()].into_iter().flatten().collect()
}
