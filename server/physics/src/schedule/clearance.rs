//! When two things are surely clear of each other: a span of time, rounded so that it never says too much.

use super::time::Time;

/// A span in which nothing can touch; where nothing is known it is empty.
#[derive(Clone, Copy, Debug)]
pub struct Clearance {
    from: u64,
    until: u64,
}

impl Clearance {
    /// At all times.
    pub const ALWAYS: Self = Self { from: 0, until: u64::MAX };
    /// At no time that is known.
    pub const UNKNOWN: Self = Self { from: 0, until: 0 };

    /// After `time`.
    #[inline]
    pub const fn after(time: Time) -> Self {
        Self { from: time.rounded_down() + 1, until: u64::MAX }
    }

    /// Before `time`.
    #[inline]
    pub const fn before(time: Time) -> Self {
        Self { from: 0, until: time.rounded_down() }
    }

    /// Of one as well as of the other.
    #[inline]
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { from: self.from.max(other.from), until: self.until.min(other.until) }
    }

    /// Whether it surely holds at `time`.
    #[inline]
    pub const fn holds_at(self, time: Time) -> bool {
        let time = time.rounded_down();
        self.from <= time && time < self.until
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_never_adds_a_time() {
        for seconds in [0.3, 1.0, 0.1 + 3e-17, 12_345.678_9, 3e7] {
            let time = Time::of_seconds(seconds);
            assert!(!Clearance::after(time).holds_at(time));
            assert!(!Clearance::before(time).holds_at(time));
            assert!(Clearance::after(time).holds_at(time.after(1e-9)));
            assert!(Clearance::before(time).holds_at(time.after(-1e-9)));
            assert!(!Clearance::before(time).and(Clearance::after(time)).holds_at(time.after(1e-9)));
            assert!(Clearance::ALWAYS.holds_at(time) && !Clearance::UNKNOWN.holds_at(time));
        }
    }
}
