//! What players do in a run, and the run itself: beats of 1/30 s, which are ticks of every rate.

use ballroom_physics::{BallState, Controller, Drive, Seat, SeatFault, Time};
use nalgebra::{Vector2, Vector3};
use std::fmt;

/// Beats a second.
pub const BEATS_PER_S: u32 = 30;

/// A deed at a beat.
#[derive(Clone, Copy, Debug)]
pub struct Act {
    pub beat: u64,
    /// Place in the scene's list.
    pub ball: usize,
    pub deed: Deed,
}

#[derive(Clone, Copy, Debug)]
pub enum Deed {
    /// As a player's press: a direction of length at most 1, the speed it adds at length 1, and the speed limit, m/s.
    Push {
        direction: [f64; 2],
        impulse: f64,
        limit: f64,
    },
    /// As a key held: the same with an acceleration, m/s^2.
    Drive {
        direction: [f64; 2],
        acceleration: f64,
        limit: f64,
    },
    Release,
    /// Elsewhere by so many metres, at another velocity and spin, where there is room.
    Set {
        by: [f64; 2],
        velocity: [f64; 2],
        spin: f64,
    },
}

impl fmt::Display for Act {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at {}/{BEATS_PER_S} s, ball[{}]: {:?}", self.beat, self.ball, self.deed)
    }
}

impl Act {
    /// The same in a mirror across x = 0.
    pub fn mirrored(mut self) -> Self {
        match &mut self.deed {
            Deed::Push { direction: way, .. } | Deed::Drive { direction: way, .. } => way[0] = -way[0],
            Deed::Set { by, velocity, spin } => {
                (by[0], velocity[0], *spin) = (-by[0], -velocity[0], -*spin);
            }
            Deed::Release => {}
        }
        self
    }

    /// False if it was refused.
    fn apply(&self, engine: &mut Controller, id: usize) -> bool {
        match self.deed {
            Deed::Push { direction, impulse, limit } => {
                engine.push(id, Vector2::from(direction) * impulse, limit);
            }
            Deed::Drive { direction, acceleration, limit } => {
                let direction = Vector2::from(direction);
                engine.drive(id, Some(Drive { direction, acceleration, speed_limit: limit }));
            }
            Deed::Release => engine.drive(id, None),
            Deed::Set { by, velocity: [vx, vy], spin } => {
                let center = engine.ball(id).center.xy() + Vector2::from(by);
                let Ok(spot) = engine.spot(id, center) else { return false };
                let velocity = Some(Vector3::new(vx, vy, 0.0));
                let seat = Seat { ball: id, spot: Some(spot), velocity, spin: Some(spin) };
                return match engine.set_balls(&[seat]) {
                    Err(SeatFault::Slides { .. }) => engine.set_balls(&[Seat { spin: None, ..seat }]).is_ok(),
                    set => set.is_ok(),
                };
            }
        }
        true
    }
}

/// Does what the script asks for at `beat`; `index` names the scene's list, where a permuted one has another.
/// Returns how much of it was refused.
pub fn act(engine: &mut Controller, script: &[Act], beat: u64, index: impl Fn(usize) -> usize) -> u64 {
    let mut refused = 0;
    for act in script.iter().filter(|act| act.beat == beat) {
        let place = index(act.ball);
        let id = engine.scene_index().iter().position(|p| *p == place);
        refused += u64::from(!act.apply(engine, id.expect("the ball is in the scene")));
    }
    refused
}

/// Advances from one beat to the next by ticks of `rate_hz`.
pub fn advance(engine: &mut Controller, beat: u64, rate_hz: u32) {
    let ticks = u64::from(rate_hz / BEATS_PER_S);
    for tick in 1..=ticks {
        engine.advance_to(Time::of_tick(beat * ticks + tick, rate_hz));
    }
}

/// Every bit of a ball's state.
pub fn bits(ball: &BallState) -> [u64; 18] {
    let mut out = [0; 18];
    let vectors = [ball.center, ball.normal, ball.velocity, ball.omega];
    let numbers = vectors.iter().flat_map(|v| v.iter()).chain(ball.uv.iter()).chain(&ball.orientation);
    for (bits, number) in out.iter_mut().zip(numbers) {
        *bits = number.to_bits();
    }
    out
}
