//! The main job's terminal: keys in, one status line out. Keys and screen are [`server::terminal`].
//!
//! | file | what |
//! |---|---|
//! | [`pilot`] | from what is wanted to commands, without ever waiting for an answer |
//! | [`status`] | the status line |

pub mod pilot;
pub mod status;

pub use server::terminal::{keys, screen};
