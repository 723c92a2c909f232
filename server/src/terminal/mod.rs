//! A terminal to play in: keys in, a few lines out.
//!
//! | file | what |
//! |---|---|
//! | [`keys`] | from key presses to what is wanted |
//! | [`screen`] | the terminal: raw mode, log lines above what is shown, and back to normal whatever happens |

pub mod keys;
pub mod screen;
