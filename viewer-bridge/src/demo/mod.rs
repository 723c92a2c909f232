//! The main job's terminal: keys in, one status line out.
//!
//! | file | what |
//! |---|---|
//! | [`keys`] | from key presses to what is wanted |
//! | [`pilot`] | from what is wanted to commands, without ever waiting for an answer |
//! | [`status`] | the status line |
//! | [`screen`] | the terminal: raw mode, log lines above the status line, and back to normal whatever happens |

pub mod keys;
pub mod pilot;
pub mod screen;
pub mod status;
