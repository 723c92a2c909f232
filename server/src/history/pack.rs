//! Words without the zero bytes at their ends. Counts have zeros above, powers of two below, and what is not there is all
//! zero; of the words of a run this leaves about three fifths.
//!
//! Two words share a byte that says what is left of each: 0 to 8 for so many low bytes, 9 to 15 for 1 to 7 high ones.

const WORD: usize = size_of::<u64>();

/// What is left of `words`.
pub fn pack(words: &[u64]) -> Vec<u8> {
    let mut out = Vec::with_capacity(words.len() * (WORD + 1));
    for pair in words.chunks(2) {
        let kinds = pair.iter().rev().fold(0, |kinds, word| (kinds << 4) | kind(*word));
        out.push(kinds);
        for word in pair {
            let (first, last) = span(kind(*word));
            out.extend_from_slice(&word.to_le_bytes()[first..last]);
        }
    }
    out.shrink_to_fit();
    out
}

/// The words again, and a zero more if they were odd in number; none if that is not what they are.
pub fn unpack(bytes: &[u8]) -> Option<Vec<u64>> {
    let mut words = Vec::with_capacity(bytes.len() / 4);
    let mut rest = bytes;
    while let Some((kinds, mut after)) = rest.split_first() {
        for kind in [kinds & 15, kinds >> 4] {
            let (first, last) = span(kind);
            let (kept, more) = after.split_at_checked(last - first)?;
            let mut word = [0; WORD];
            word[first..last].copy_from_slice(kept);
            words.push(u64::from_le_bytes(word));
            after = more;
        }
        rest = after;
    }
    Some(words)
}

/// The `count` words again.
pub fn unpack_exactly(bytes: &[u8], count: usize) -> Option<Vec<u64>> {
    let mut words = unpack(bytes)?;
    let whole = words.len() == count + count % 2;
    words.truncate(count);
    whole.then_some(words)
}

/// How a word is kept.
fn kind(word: u64) -> u8 {
    let (above, below) = (word.leading_zeros() / 8, word.trailing_zeros() / 8);
    (if below > above { 16 - below } else { 8 - above }) as u8
}

/// Which bytes of a word are kept, the lowest first.
const fn span(kind: u8) -> (usize, usize) {
    let kind = kind as usize;
    if kind <= WORD { (0, kind) } else { (2 * WORD - kind, WORD) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_every_shape_come_back() {
        let mut words =
            vec![0, 1, u64::MAX, 0.5_f64.to_bits(), f64::INFINITY.to_bits(), 1 << 63, 0x00ff_ff00];
        words.extend((0..64).flat_map(|bit| [1 << bit, u64::MAX << bit, u64::MAX >> bit]));
        for count in 0..words.len() {
            assert_eq!(unpack_exactly(&pack(&words[..count]), count).as_deref(), Some(&words[..count]));
        }
        let packed = pack(&words);
        for length in 0..packed.len() {
            assert_eq!(unpack_exactly(&packed[..length], words.len()), None, "cut at {length}");
        }
        assert_eq!(unpack_exactly(&[&packed[..], &[0]].concat(), words.len()), None);
    }

    #[test]
    fn zeros_take_half_a_byte() {
        assert_eq!(pack(&[0; 100]).len(), 50);
        assert_eq!(pack(&[3, 0.25_f64.to_bits()]).len(), 1 + 1 + 2);
    }
}
