//! Bytes without meaning.

/// Marsaglia's xorshift: the same bytes for the same seed.
pub struct Noise(u64);

impl Noise {
    /// From a seed; 0 would stay 0.
    pub const fn new(seed: u64) -> Self {
        Self(seed | 1 << 63)
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// So many of them.
    pub fn bytes(&mut self, length: usize) -> Vec<u8> {
        (0..length).map(|_| self.next() as u8).collect()
    }
}
