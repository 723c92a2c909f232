//! In which order things happen.
pub mod time;
