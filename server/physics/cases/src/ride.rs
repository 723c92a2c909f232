//! Running a scene and keeping the largest error.

use ballroom_physics::{BallState, Controller, Scene, SceneFault, Time};
use nalgebra::Vector3;

/// Advances tick by tick up to and including `ticks`, showing every tick's state, the start included.
pub fn run(
    scene: &Scene,
    rate_hz: u32,
    ticks: u64,
    mut look: impl FnMut(u64, &Controller),
) -> Result<Controller, SceneFault> {
    let mut engine = Controller::new(scene)?;
    look(0, &engine);
    for tick in 1..=ticks {
        engine.advance_to(Time::of_tick(tick, rate_hz));
        look(tick, &engine);
    }
    Ok(engine)
}

/// Hits of any kind since the start.
pub fn hits(engine: &Controller) -> u64 {
    let collisions = engine.report().collisions;
    collisions.ball_ball + collisions.ball_wall
}

/// Distance of a count from the exact one.
pub fn miscount(counted: u64, exact: u64) -> f64 {
    counted.abs_diff(exact) as f64
}

/// The largest of what it was shown; not a number once it was shown one, which meets no demand.
#[derive(Clone, Copy, Debug, Default)]
pub struct Largest(f64);

impl Largest {
    /// Takes an error into account, by its size.
    pub fn see(&mut self, error: f64) {
        let error = error.abs();
        if error > self.0 || error.is_nan() {
            self.0 = error;
        }
    }

    /// Takes the distance of a ball's centre from the exact one into account, m.
    pub fn see_center(&mut self, ball: &BallState, exact: Vector3<f64>) {
        self.see((ball.center - exact).norm());
    }

    /// The largest yet.
    pub const fn value(self) -> f64 {
        self.0
    }
}

/// Watches a quantity that must stay what it was at first.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drift {
    first: Option<f64>,
    largest: Largest,
}

impl Drift {
    /// Takes the present value into account.
    pub fn see(&mut self, value: f64) {
        let first = *self.first.get_or_insert(value);
        self.largest.see(value / first - 1.0);
    }

    /// The largest relative difference from the first value.
    pub const fn value(self) -> f64 {
        self.largest.value()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_error_does_not_forget_what_is_not_a_number() {
        let mut largest = Largest::default();
        for x in [0.5, -2.0, 1.0] {
            largest.see(x);
        }
        assert_eq!(largest.value(), 2.0);
        for x in [f64::NAN, 3.0] {
            largest.see(x);
        }
        assert!(largest.value().is_nan());
    }
}
