//! In which order things happen.
//!
//! `time` is the clock, `event` what can come next for a ball and the one total order of ties, `queue` finds
//! the first of all, `calendar` some of the next, `clearance` is a span in which nothing can touch.

pub mod calendar;
pub mod clearance;
pub mod event;
pub mod queue;
pub mod time;
