//! The engine against what is known exactly. Errors are the largest over all tick states.

mod allocation;
mod certified_floors;
mod checkpoints;
mod closed_forms;
mod hard_cases;
mod known_faults;
mod repeatable;
mod scenes;
mod tables;
mod tight_floors;
