//! Colours: heights of the floor, and what is drawn on it.

use rerun::Color;

/// Stops from the lowest to the highest floor: deep water, sage, sand, clay.
const HEIGHTS: [[f64; 3]; 5] = [
    [22.0, 52.0, 84.0],
    [40.0, 106.0, 122.0],
    [134.0, 166.0, 148.0],
    [226.0, 208.0, 164.0],
    [214.0, 138.0, 92.0],
];

/// Lines on the floor; lines are never seen through, so this lies between the floor's colours.
pub const GRID: [u8; 3] = [112, 128, 124];
/// Walls, seen through.
pub const WALL: [u8; 4] = [170, 190, 215, 26];
/// The floor's control net.
pub const NET: [u8; 3] = [150, 170, 200];
/// Points where balls touch the floor.
pub const CONTACT: [u8; 3] = [255, 96, 160];
/// Velocities.
pub const VELOCITY: [u8; 3] = [92, 214, 192];
/// Reactions of the floor.
pub const REACTION: [u8; 3] = [255, 150, 90];
/// Names of balls that nobody steers.
pub const NAME: [u8; 3] = [200, 205, 215];
/// What marks the player's ball.
pub const PLAYER: [u8; 3] = [255, 200, 40];

/// Opaque colour of red, green, blue.
pub fn color([r, g, b]: [u8; 3]) -> Color {
    Color::from_rgb(r, g, b)
}

/// Translucent colour of red, green, blue, opacity.
pub fn translucent([r, g, b, a]: [u8; 4]) -> Color {
    Color::from_unmultiplied_rgba(r, g, b, a)
}

/// The floor's colour at a height between the lowest and the highest, m.
pub fn of_height(height_m: f64, [lowest, highest]: [f64; 2]) -> Color {
    let span = highest - lowest;
    // A floor without relief takes the middle colour, not noise.
    let t = if span > 1e-9 { ((height_m - lowest) / span).clamp(0.0, 1.0) } else { 0.5 };
    let place = t * (HEIGHTS.len() - 1) as f64;
    let stop = (place as usize).min(HEIGHTS.len() - 2);
    color(mixed(HEIGHTS[stop], HEIGHTS[stop + 1], place - stop as f64))
}

/// A colour `share` of the way from one to another.
pub fn between(from: [u8; 3], to: [u8; 3], share: f64) -> [u8; 3] {
    mixed(from.map(f64::from), to.map(f64::from), share)
}

fn mixed(from: [f64; 3], to: [f64; 3], share: f64) -> [u8; 3] {
    std::array::from_fn(|i| (from[i] + (to[i] - from[i]) * share).round() as u8)
}
