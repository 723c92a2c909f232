//! When something happens. Nothing here moves a ball.
//!
//! `root` finds the first time a polynomial turns negative and misses none; `ball_ball` and `ball_wall` pose
//! the question for two arcs and for an arc and a wall; `broad_phase` says whom to ask.

pub mod ball_ball;
pub mod ball_wall;
pub mod broad_phase;
pub mod root;
