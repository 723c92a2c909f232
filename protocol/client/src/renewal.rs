//! How often a held force is renewed: the server lets go of what it does not hear of for half a simulated second.

use std::time::Duration;

/// At least.
const AT_LEAST: Duration = Duration::from_millis(100);
/// The same in simulated seconds: well within the half second after which the server lets go.
const AT_LEAST_SIMULATED_S: f64 = 0.2;
/// At most: a player's budget is 120 commands a second, and a release must find room in it.
const AT_MOST: Duration = Duration::from_millis(10);

/// Wall time between two renewals at this many simulated seconds a second.
pub fn renew_every(speed_factor: f64) -> Duration {
    let simulated = Duration::try_from_secs_f64(AT_LEAST_SIMULATED_S / speed_factor).unwrap_or(AT_LEAST);
    simulated.clamp(AT_MOST, AT_LEAST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_force_is_renewed_before_the_server_lets_go_at_every_speed() {
        for speed in [1.0 / 64.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0] {
            assert!(renew_every(speed).as_secs_f64() * speed < 0.5 / 2.0, "{speed}");
        }
        assert_eq!([renew_every(1.0), renew_every(100.0)], [AT_LEAST, AT_MOST]);
    }
}
