//! What a fuzzer's bytes mean: themselves, or something valid with damage done to it as they say. A random engine gets
//! past the first brace this way, and one that follows coverage learns the edits.

/// Bytes of one edit: what, where (two), with what.
const EDIT: usize = 4;
/// What a number may be replaced by.
const TOKENS: [&str; 12] = [
    "0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "18446744073709551616",
    "NaN",
    "inf",
    "null",
    "[]",
    "{}",
    "\"\"",
];

/// The input, or one of `valid` damaged.
pub fn damaged(input: &[u8], valid: &[Vec<u8>]) -> Vec<u8> {
    let Some((&first, rest)) = input.split_first() else { return Vec::new() };
    // One in eight is taken as it stands.
    if first < 32 || valid.is_empty() {
        return rest.to_vec();
    }
    let mut bytes = valid[usize::from(first) % valid.len()].clone();
    for edit in rest.chunks_exact(EDIT) {
        let at = usize::from(u16::from_le_bytes([edit[1], edit[2]])) % (bytes.len() + 1);
        apply(&mut bytes, edit[0] % 8, at, edit[3], valid);
    }
    bytes
}

fn apply(bytes: &mut Vec<u8>, what: u8, at: usize, with: u8, valid: &[Vec<u8>]) {
    let end = (at + usize::from(with)).min(bytes.len());
    match what {
        0 => bytes.insert(at, with),
        1 => bytes.truncate(at),
        2 => drop(bytes.drain(at..end)),
        3 => {
            let again = bytes[at..end].to_vec();
            bytes.splice(at..at, again);
        }
        4 => {
            let other = &valid[usize::from(with) % valid.len()];
            let from = at.min(other.len());
            bytes.truncate(at);
            bytes.extend(&other[from..]);
        }
        5 => replace_number(bytes, at, TOKENS[usize::from(with) % TOKENS.len()]),
        _ => {
            if let Some(byte) = bytes.get_mut(at) {
                *byte = if what == 6 { with } else { *byte ^ (1 << (with % 8)) };
            }
        }
    }
}

/// The first number in text at or after a place becomes something else.
fn replace_number(bytes: &mut Vec<u8>, at: usize, token: &str) {
    let Some(start) = (at..bytes.len()).find(|&i| bytes[i].is_ascii_digit()) else { return };
    let is_number = |b: &u8| b.is_ascii_digit() || b".eE+-_".contains(b);
    let length = bytes[start..].iter().take_while(|b| is_number(b)).count();
    bytes.splice(start..start + length, token.bytes());
}
