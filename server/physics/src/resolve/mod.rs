//! What happens then: hits change velocities, inside the constraint that keeps balls on the floor.

pub mod impact;
pub mod in_turn;
