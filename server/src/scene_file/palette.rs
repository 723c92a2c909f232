//! Colours of balls: as written, or by place in the list.

use super::Placed;

/// Colours that stay apart for most eyes (Okabe and Ito, without black).
const PALETTE: [[u8; 3]; 7] = [
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [240, 228, 66],
    [0, 114, 178],
    [213, 94, 0],
    [204, 121, 167],
];

/// `#rrggbb` as red, green, blue.
pub fn parse(text: &str) -> Option<[u8; 3]> {
    let digits =
        text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let [_, red, green, blue] = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
    Some([red, green, blue])
}

/// The colour of a place in the list.
pub const fn of_place(place: usize) -> [u8; 3] {
    PALETTE[place % PALETTE.len()]
}

/// Gives every ball without a colour the one of its place.
pub fn colour(balls: &mut [Placed]) {
    for (place, ball) in balls.iter_mut().enumerate() {
        ball.card.color_rgb.get_or_insert(of_place(place));
    }
}
