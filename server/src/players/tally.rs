//! Which numbered messages have come, although some come late, twice or never.

/// How far back a late message is still told from a repeated one.
const MEMORY: u64 = u128::BITS as u64;

/// Counts of one sender's messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Messages that came, without repetitions.
    pub came: u64,
    /// Messages that came again.
    pub repeated: u64,
    /// Number of the newest.
    pub newest: u64,
    /// Bit i: the message numbered `newest - i` has come.
    recent: u128,
}

impl Tally {
    /// Takes note of a message; 0 is one without a number.
    pub const fn hear(&mut self, number: u64) {
        if number == 0 {
            self.came += 1;
        } else if number > self.newest {
            let ahead = number - self.newest;
            self.recent = if ahead < MEMORY { self.recent << ahead } else { 0 };
            self.recent |= 1;
            self.newest = number;
            self.came += 1;
        } else {
            let back = self.newest - number;
            let bit = if back < MEMORY { 1 << back } else { 0 };
            // One from before memory is taken for a repetition.
            if bit == 0 || self.recent & bit != 0 {
                self.repeated += 1;
            } else {
                self.recent |= bit;
                self.came += 1;
            }
        }
    }

    /// Messages that are missing between those that came.
    pub const fn lost(&self) -> u64 {
        self.newest.saturating_sub(self.came)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(numbers: &[u64]) -> (u64, u64, u64) {
        let mut tally = Tally::default();
        for number in numbers {
            tally.hear(*number);
        }
        (tally.came, tally.repeated, tally.lost())
    }

    #[test]
    fn late_repeated_and_lost_messages_are_told_apart() {
        assert_eq!(after(&[1, 2, 3]), (3, 0, 0));
        assert_eq!(after(&[1, 3]), (2, 0, 1));
        assert_eq!(after(&[1, 3, 2]), (3, 0, 0));
        assert_eq!(after(&[1, 3, 3, 1]), (2, 2, 1));
        assert_eq!(after(&[0, 0]), (2, 0, 0));
        assert_eq!(after(&[1, 1000, 2]), (2, 1, 998));
        assert_eq!(after(&[1, 128, 1, 129, 2]), (4, 1, 125));
    }
}
