//! A token bucket: how many one source may send.

use std::time::Instant;

/// Fills at a rate, and holds at most one second's worth.
#[derive(Debug)]
pub struct Bucket {
    per_s: f64,
    tokens: f64,
    filled: Instant,
}

impl Bucket {
    /// A full one.
    pub const fn full(per_s: f64, now: Instant) -> Self {
        Self { per_s, tokens: per_s, filled: now }
    }

    /// How many may be taken now.
    pub fn level(&self, now: Instant) -> f64 {
        let came = now.saturating_duration_since(self.filled).as_secs_f64() * self.per_s;
        (self.tokens + came).min(self.per_s)
    }

    /// Takes one, if there is one.
    pub fn take(&mut self, now: Instant) -> bool {
        let level = self.level(now);
        let allowed = level >= 1.0;
        (self.tokens, self.filled) = (if allowed { level - 1.0 } else { level }, now);
        allowed
    }

    /// Takes so many, if there are any; what is missing has to come in before there are any again.
    pub fn draw(&mut self, amount: f64, now: Instant) -> bool {
        let level = self.level(now);
        let allowed = level > 0.0;
        (self.tokens, self.filled) = (if allowed { level - amount } else { level }, now);
        allowed
    }
}
