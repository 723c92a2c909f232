//! What is demanded of one number.

use std::fmt;

/// Over how much of a run a number is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Span {
    /// Simulated seconds.
    Seconds(f64),
    /// Hits.
    Hits(u64),
    /// Scenes run, each once.
    Runs(u64),
    /// Only the loading of scenes, this many.
    Loads(u64),
}

impl fmt::Display for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Seconds(seconds) => write!(f, "{seconds} s"),
            Self::Hits(hits) => write!(f, "{hits} hits"),
            Self::Runs(runs) => write!(f, "{runs} runs"),
            Self::Loads(loads) => write!(f, "{loads} loads"),
        }
    }
}

/// One number that must not be larger than its limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Demand {
    /// Of what the error is, for instance `centre` or `energy`.
    pub quantity: &'static str,
    /// Its unit; `1` for pure numbers.
    pub unit: &'static str,
    /// How one number is made of many.
    pub norm: &'static str,
    /// Over how much of the run.
    pub span: Span,
    /// The largest that is accepted.
    pub limit: f64,
}

impl Demand {
    /// The largest error over all tick states.
    pub const fn over_ticks(quantity: &'static str, unit: &'static str, span: Span, limit: f64) -> Self {
        Self { quantity, unit, norm: "largest over ticks", span, limit }
    }

    /// The error of the last state.
    pub const fn at_the_end(quantity: &'static str, unit: &'static str, span: Span, limit: f64) -> Self {
        Self { quantity, unit, norm: "at the end", span, limit }
    }

    /// The largest error over all tick states, relative to the value at the start.
    pub const fn relative(quantity: &'static str, span: Span, limit: f64) -> Self {
        Self { quantity, unit: "1", norm: "largest relative over ticks", span, limit }
    }

    /// Distance of a count from the exact one, which must be none.
    pub const fn count(quantity: &'static str, span: Span) -> Self {
        Self { quantity, unit: "1", norm: "difference from the count", span, limit: 0.0 }
    }

    /// How many times something happened that must not.
    pub const fn never(quantity: &'static str, span: Span) -> Self {
        Self { quantity, unit: "1", norm: "times", span, limit: 0.0 }
    }
}
