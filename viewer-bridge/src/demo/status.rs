//! The status line.

use crate::slot::News;
use protocol::snapshot::Collisions;

/// What the line tells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Status {
    /// Whether the clock stands.
    pub paused: bool,
    speed_factor: Option<f64>,
    real_time_factor: Option<f64>,
    tick: u64,
    time_s: f64,
    collisions: Collisions,
    epoch: u64,
    energy_j: f64,
    first_energy_j: f64,
    seen: bool,
}

impl Status {
    /// Takes in what came.
    pub fn update(&mut self, news: &News) {
        let states = [news.world.as_ref().map(|world| &world.snapshot), news.state.as_deref()];
        for state in states.into_iter().flatten() {
            let energy_j = state.energy_j - state.steering_work_j;
            if !self.seen || self.epoch != state.epoch {
                (self.seen, self.epoch, self.first_energy_j) = (true, state.epoch, energy_j);
            }
            (self.paused, self.tick, self.time_s) = (state.paused, state.tick, state.time_s);
            (self.collisions, self.energy_j) = (state.collisions, energy_j);
        }
        if let Some(stats) = &news.stats {
            self.speed_factor = Some(stats.speed_factor);
            self.real_time_factor = Some(stats.real_time_factor);
        }
    }

    /// Simulated seconds wanted per wall second, as the server last said; arenas begin at 1.
    pub fn speed_factor(&self) -> f64 {
        self.speed_factor.unwrap_or(1.0)
    }

    /// The line, with the speed that is wanted, without a viewer's address.
    pub fn line(&self, speed: f64) -> String {
        if !self.seen {
            return "waiting for the first state".into();
        }
        let state = if self.paused { "paused " } else { "running" };
        let reached = self.real_time_factor.map_or_else(|| "-".into(), |factor| format!("{factor:.2}"));
        let scale = if self.first_energy_j == 0.0 { 1.0 } else { self.first_energy_j.abs() };
        let energy = (self.energy_j - self.first_energy_j) / scale;
        let Collisions { ball_ball, ball_wall } = self.collisions;
        format!(
            "{state} x{speed:<4} reached {reached} | tick {} {:.1} s | hits: balls {ball_ball}, walls {ball_wall} \
             | energy drift {energy:+.0e}",
            self.tick, self.time_s
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::snapshot::Snapshot;
    use std::sync::Arc;

    fn state(epoch: u64, energy_j: f64) -> News {
        let collisions = Collisions { ball_ball: 3, ball_wall: 8 };
        let state = Snapshot { epoch, tick: 90, time_s: 1.5, energy_j, collisions, ..Snapshot::default() };
        News { state: Some(Arc::new(state)), ..News::default() }
    }

    #[test]
    fn the_line_tells_state_hits_and_energy_against_the_epochs_first() {
        let mut status = Status::default();
        status.update(&state(1, 200.0));
        status.update(&state(1, 201.0));
        let line = status.line(1.0);
        for part in ["running", "x1 ", "tick 90 1.5 s", "balls 3, walls 8", "energy drift +5e-3"] {
            assert!(line.contains(part), "{part} in {line}");
        }
        status.update(&state(2, 100.0));
        assert!(status.line(1.0).contains("energy drift +0e0"));
    }
}
