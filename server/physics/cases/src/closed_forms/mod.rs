//! Motion and hits of few balls with exact answers.

use crate::case::Case;

/// Every case of this room.
pub fn cases() -> Vec<Case> {
    vec![]
}
