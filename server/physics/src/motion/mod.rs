//! How a ball moves while nothing hits it.
//!
//! `law` holds the equations, `dop853`, `tsit5` and `rk4` step them, `arc` is what a step leaves behind: one
//! polynomial that everything else reads; `take_over` writes it. `step_size` says how long the next step is. `rotation` turns a ball whose
//! motion needs no stepping, `together` computes several balls' steps side by side, `follow` several balls' orientations, and
//! `look` reads several arcs.

pub mod arc;
pub mod body;
pub mod dop853;
mod dop853_tableau;
pub mod follow;
pub mod law;
pub mod look;
pub mod low_order;
pub mod rotation;
pub mod step;
pub mod step_size;
mod take_over;
pub mod together;
