//! Simulated time: an integer count of a fixed quantum and an offset below one quantum.
//!
//! At t = 1e6 s an absolute f64 has only 1e-10 s left; this keeps 2^-59 s for ever. The quantum is the
//! engine's own and the same for every tick rate, so that ticks never enter the arithmetic.

use std::cmp::Ordering;

/// Length of the quantum, s: 2^-6.
pub const QUANTUM: f64 = 0.015_625;
/// Quanta a second.
pub const QUANTA_PER_SECOND: i64 = 64;

/// A point in simulated time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Time {
    quantum: i64,
    offset: f64,
}

impl Time {
    /// The start.
    pub const ZERO: Self = Self { quantum: 0, offset: 0.0 };
    /// Later than everything.
    pub const NEVER: Self = Self { quantum: i64::MAX, offset: 0.0 };

    /// The start of quantum number `quantum`.
    pub const fn of_quantum(quantum: i64) -> Self {
        Self { quantum, offset: 0.0 }
    }

    /// The time with this quantum and offset, if it is one.
    pub fn of_parts(quantum: i64, offset: f64) -> Option<Self> {
        (0.0..QUANTUM).contains(&offset).then_some(Self { quantum, offset })
    }

    /// `seconds` after the start, exact to 2^-59 s for any finite argument below 1e17.
    pub fn of_seconds(seconds: f64) -> Self {
        Self::ZERO.after(seconds)
    }

    /// Tick `tick` of a clock with `rate_hz` ticks a second, rounded once.
    pub fn of_tick(tick: u64, rate_hz: u32) -> Self {
        let rate = u64::from(rate_hz.max(1));
        // Whole seconds first: no product outgrows its word.
        let (seconds, ticks) = ((tick / rate).cast_signed(), (tick % rate).cast_signed());
        let (scaled, rate) = (ticks * QUANTA_PER_SECOND, rate.cast_signed());
        let quantum = seconds.wrapping_mul(QUANTA_PER_SECOND).wrapping_add(scaled / rate);
        Self { quantum, offset: (scaled % rate) as f64 * QUANTUM / rate as f64 }.normalised()
    }

    /// Number of the quantum it lies in.
    pub const fn quantum(self) -> i64 {
        self.quantum
    }

    /// Seconds since that quantum began.
    pub const fn offset(self) -> f64 {
        self.offset
    }

    /// This time plus `seconds` (of either sign).
    #[must_use]
    pub fn after(self, seconds: f64) -> Self {
        if seconds == f64::INFINITY || self.quantum == i64::MAX {
            return Self::NEVER;
        }
        let (quanta, whole) = floor(seconds * QUANTA_PER_SECOND as f64);
        // Exact: the quantum is a power of two, and `whole` quanta lie within a quantum of `seconds`.
        let rest = seconds - whole * QUANTUM;
        Self { quantum: self.quantum + quanta, offset: self.offset + rest }.normalised()
    }

    /// Seconds from `earlier` to this time.
    pub fn since(self, earlier: Self) -> f64 {
        if self.quantum == i64::MAX {
            return f64::INFINITY;
        }
        (self.quantum - earlier.quantum) as f64 * QUANTUM + (self.offset - earlier.offset)
    }

    /// Seconds since the start, rounded to an f64.
    pub fn seconds(self) -> f64 {
        self.since(Self::ZERO)
    }

    /// An integer that is not smaller for a later time: the offset is rounded down to 2^-36 s, and times from eight years
    /// on are alike, as are those before the start.
    #[inline]
    pub const fn rounded_down(self) -> u64 {
        const QUANTUM_BITS: u32 = 34;
        const OFFSET_BITS: u32 = 64 - QUANTUM_BITS;
        const LAST: i64 = (1 << QUANTUM_BITS) - 1;
        if self.quantum < 0 {
            return 0;
        }
        if self.quantum >= LAST {
            return LAST.cast_unsigned() << OFFSET_BITS;
        }
        let offset = self.offset * ((1_i64 << OFFSET_BITS) * QUANTA_PER_SECOND) as f64;
        (self.quantum << OFFSET_BITS).cast_unsigned() | (offset as i64).cast_unsigned()
    }

    fn normalised(mut self) -> Self {
        if self.offset >= QUANTUM {
            self.offset -= QUANTUM;
            self.quantum += 1;
        } else if self.offset < 0.0 {
            self.offset += QUANTUM;
            self.quantum -= 1;
            // A tiny negative offset rounds up to the whole quantum.
            if self.offset >= QUANTUM {
                self.offset = 0.0;
                self.quantum += 1;
            }
        }
        self
    }
}

/// The largest integer that is not larger, twice; the processor at hand may have no instruction for it.
#[inline]
fn floor(x: f64) -> (i64, f64) {
    let toward_zero = x as i64;
    if toward_zero as f64 > x {
        let below = toward_zero.saturating_sub(1);
        return (below, below as f64);
    }
    (toward_zero, if toward_zero == i64::MAX { x } else { toward_zero as f64 })
}

impl Eq for Time {}

#[allow(clippy::needless_bitwise_bool, reason = "what cannot be foretold is computed, not jumped over")]
impl PartialOrd for Time {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }

    // Nearly all comparisons are these; an offset has a sign only where it is not zero.
    #[inline]
    fn lt(&self, other: &Self) -> bool {
        (self.quantum < other.quantum) | ((self.quantum == other.quantum) & (self.offset < other.offset))
    }

    #[inline]
    fn le(&self, other: &Self) -> bool {
        (self.quantum < other.quantum) | ((self.quantum == other.quantum) & (self.offset <= other.offset))
    }

    #[inline]
    fn gt(&self, other: &Self) -> bool {
        other < self
    }

    #[inline]
    fn ge(&self, other: &Self) -> bool {
        other <= self
    }
}

impl Ord for Time {
    fn cmp(&self, other: &Self) -> Ordering {
        self.quantum.cmp(&other.quantum).then_with(|| self.offset.total_cmp(&other.offset))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_of_any_rate_meet_at_whole_seconds() {
        for rate in [1, 30, 60, 144, 240, 1000] {
            for second in [1_u64, 59, 3600, 1_000_000] {
                assert_eq!(Time::of_tick(second * u64::from(rate), rate), Time::of_seconds(second as f64));
            }
        }
    }

    #[test]
    fn a_common_tick_of_two_rates_is_one_time() {
        for n in 0..10_000_u64 {
            assert_eq!(Time::of_tick(n, 30), Time::of_tick(n * 8, 240));
            assert_eq!(Time::of_tick(n, 60), Time::of_tick(n * 4, 240));
        }
    }

    #[test]
    fn a_million_seconds_in_an_offset_is_still_exact() {
        let late = Time::of_quantum(64_000_000);
        assert_eq!(late.after(1e-13).since(late), 1e-13);
        // An offset keeps 2^-59 s; what is less rounds away and never unsettles the quantum.
        assert_eq!(late.after(-1e-19), late);
    }

    #[test]
    fn a_later_time_never_rounds_to_less() {
        let mut last = 0;
        for quantum in [i64::MIN, -1, 0, 1, 64_000_000, (1 << 34) - 2, (1 << 34) - 1, 1 << 34, 1 << 53] {
            for offset in [0.0, 1e-12, 0.5 * QUANTUM, QUANTUM.next_down()] {
                let rounded = Time { quantum, offset }.rounded_down();
                assert!(last <= rounded, "{quantum} quanta and {offset} s");
                last = rounded;
            }
        }
        assert!(last <= Time::NEVER.rounded_down());
    }
}
