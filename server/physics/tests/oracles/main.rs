//! The engine against what is known exactly. Errors are the largest over all tick states.

mod allocation;
mod certified_floors;
mod checkpoints;
mod divided;
mod known_faults;
mod repeatable;
mod scenes;
mod set_balls;
mod succession;
mod tight_floors;
