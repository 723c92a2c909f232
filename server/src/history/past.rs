//! A moment of the past, packed, with the world it belongs to; and as a file or a command carries it.

use super::pack::{pack, unpack, unpack_exactly};
use crate::simulation::{Ground, Moment, Simulation};
use ballroom_physics::{Checkpoint, CheckpointFault};
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use protocol::timeline::{HeldForce, SAVED_STATE_FORMAT, SAVED_STATE_VERSION, SavedState};
use std::sync::Arc;

/// A moment that can be gone back to.
pub struct Past {
    ground: Arc<Ground>,
    /// Without its words.
    moment: Moment,
    words: Vec<u8>,
}

impl Past {
    /// A moment of a world.
    pub fn new(ground: &Arc<Ground>, moment: &Moment) -> Self {
        let words = pack(&moment.words);
        let moment = Moment { words: Vec::new(), held: moment.held.clone(), ..*moment };
        Self { ground: ground.clone(), moment, words }
    }

    /// The run at that moment.
    pub fn simulation(&self) -> Result<Simulation, CheckpointFault> {
        let words =
            unpack_exactly(&self.words, self.ground.stand().run_words()).ok_or(CheckpointFault::Damaged)?;
        self.ground.at(&Moment { words, held: self.moment.held.clone(), ..self.moment })
    }

    /// Epoch and tick.
    pub const fn place(&self) -> (u64, u64) {
        (self.moment.epoch, self.moment.tick)
    }

    /// Simulated time, s.
    pub const fn time_s(&self) -> f64 {
        self.moment.time_s
    }

    /// The world it belongs to.
    pub const fn ground(&self) -> &Arc<Ground> {
        &self.ground
    }

    /// The memory it takes beside its world, bytes.
    pub fn bytes(&self) -> u64 {
        (size_of::<Self>() + self.words.capacity() + self.moment.held.capacity() * size_of::<(usize, u64)>())
            as u64
    }

    /// As a file holds it.
    pub fn to_saved(&self) -> Result<SavedState, CheckpointFault> {
        let stand = self.ground.stand();
        let run = unpack_exactly(&self.words, stand.run_words()).ok_or(CheckpointFault::Damaged)?;
        let held =
            |(ball, until_tick): &(usize, u64)| HeldForce { ball: *ball as u32, until_tick: *until_tick };
        Ok(SavedState {
            format: SAVED_STATE_FORMAT.into(),
            version: SAVED_STATE_VERSION,
            scene: self.ground.loaded().scene().name.clone(),
            time_s: self.moment.time_s,
            tick_rate_hz: self.ground.tick_rate_hz(),
            tick: self.moment.tick,
            energy_at_start_j: self.moment.energy_at_start,
            held: self.moment.held.iter().map(held).collect(),
            words: BASE64.encode(pack(stand.checkpoint_of(&run).words())),
        })
    }

    /// From a file of a run in `world`. The tick is the last one at or before its time, whatever the rate was.
    pub fn of_saved(ground: &Arc<Ground>, saved: &SavedState) -> Result<Self, CheckpointFault> {
        let stand = ground.stand();
        let damaged = CheckpointFault::Damaged;
        let bytes = BASE64.decode(&saved.words).map_err(|_| damaged)?;
        let mut words = unpack(&bytes).ok_or(damaged)?;
        // A zero may have been added to an odd number.
        if words.len() == stand.checkpoint_words() + 1 {
            words.pop();
        }
        let run = stand.run_of(&Checkpoint::of_words(words))?.to_vec();
        let rates = [ground.tick_rate_hz(), saved.tick_rate_hz.max(1)].map(u128::from);
        let held = |force: &HeldForce| {
            // At another rate the force ends at the first tick at or after its end.
            let until = (u128::from(force.until_tick) * rates[0]).div_ceil(rates[1]);
            (force.ball as usize, until as u64)
        };
        let time = stand.at_run(&run)?.time();
        let tick = Simulation::last_tick_at(time, ground.tick_rate_hz());
        let moment = Moment {
            epoch: 0,
            tick,
            time_s: time.seconds(),
            energy_at_start: saved.energy_at_start_j,
            held: saved.held.iter().map(held).collect(),
            words: run,
        };
        let past = Self::new(ground, &moment);
        past.simulation()?;
        Ok(past)
    }
}
