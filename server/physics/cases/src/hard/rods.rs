//! Balls on a line between two walls, unfolded.

/// Positions on a line of equal rods that hit each other and two ends elastically: their centres at any time, exactly.
/// Without their lengths they are points; points of equal mass pass through each other as far as places are concerned; an
/// end unfolds into a mirror.
pub fn rods(starts: &[(f64, f64)], radius: f64, ends: [f64; 2], t: f64) -> Vec<f64> {
    let shorter = |rank: usize| (2 * rank + 1) as f64 * radius;
    let length = ends[1] - ends[0] - 2.0 * radius * starts.len() as f64;
    let mut places: Vec<f64> = starts
        .iter()
        .enumerate()
        .map(|(rank, (x, v))| {
            let unfolded = (x - ends[0] - shorter(rank) + v * t).rem_euclid(2.0 * length);
            if unfolded > length { 2.0 * length - unfolded } else { unfolded }
        })
        .collect();
    places.sort_by(f64::total_cmp);
    places.iter().enumerate().map(|(rank, x)| x + ends[0] + shorter(rank)).collect()
}

#[cfg(test)]
mod tests {
    use super::rods;

    #[test]
    fn equal_rods_exchange_their_velocities() {
        // Two unit rods, the left one at 2 m/s onto the resting right one, walls at 0 and 10.
        let starts = [(0.5, 2.0), (5.5, 0.0)];
        assert_eq!(rods(&starts, 0.5, [0.0, 10.0], 1.0), [2.5, 5.5]);
        assert_eq!(rods(&starts, 0.5, [0.0, 10.0], 3.0), [4.5, 7.5]);
        assert_eq!(rods(&starts, 0.5, [0.0, 10.0], 5.0), [4.5, 7.5]);
    }
}
