//! The threads that run a large scene together: a shard each, to the same bits as one thread.
//!
//! Shards travel: to a hand through a channel, advanced there, and back; so nothing is shared and nothing is locked. Hands
//! sleep while there is no shard for them, and small scenes never wake them.

use ballroom_physics::{Controller, Report, SHARDS_MAX, Shard, Time};
use std::num::NonZero;
use std::panic::resume_unwind;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

/// Fewest balls that a shard is worth: below, what it copies and compares costs more than what it takes over.
const SHARD_LEAST_BALLS: usize = 2000;

/// A caller and its helping hands.
#[derive(Debug, Default)]
pub struct Crew {
    hands: Vec<Hand>,
}

/// A thread that advances the shards it is given.
#[derive(Debug)]
struct Hand {
    give: Option<SyncSender<(Shard, Time)>>,
    take: Receiver<Shard>,
    thread: Option<JoinHandle<()>>,
}

/// As many threads as the machine has cores for.
pub fn all_cores() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

/// As many, less one for what is not a tick: a server that ticks on all of them publishes late, and then ticks late too.
pub fn cores_to_tick_on() -> usize {
    all_cores().saturating_sub(1).max(1)
}

impl Crew {
    /// A crew of `threads`, the caller's among them, or as many as shards can use.
    pub fn of(threads: usize) -> std::io::Result<Self> {
        let hands = (1..threads.min(SHARDS_MAX)).map(Hand::new).collect::<Result<_, _>>()?;
        Ok(Self { hands })
    }

    /// Advances a run to `time` on as many threads as it is large enough for. The number changes no bit of it.
    ///
    /// # Panics
    /// With the panic of a hand whose shard failed.
    pub fn advance(&mut self, run: &mut Controller, time: Time) -> Report {
        let worth = run.scene_index().len() / SHARD_LEAST_BALLS;
        let shards = (1 + self.hands.len()).min(worth.max(1));
        if run.division().map_or(1, |division| division.shards) != shards {
            run.divide(shards);
        }
        run.advance_divided(time, &mut |shards, until| self.advance_all(shards, until))
    }

    fn advance_all(&mut self, shards: &mut Vec<Shard>, until: Time) {
        // The hands take the last shards, the caller the first.
        let busy = self.hands.len().min(shards.len() - 1);
        for (hand, shard) in self.hands.iter_mut().zip(shards.drain(shards.len() - busy..)) {
            hand.give(shard, until);
        }
        for shard in shards.iter_mut() {
            shard.advance_to(until);
        }
        shards.extend(self.hands[..busy].iter_mut().map(Hand::take));
    }
}

impl Hand {
    fn new(number: usize) -> std::io::Result<Self> {
        let (give, given) = sync_channel::<(Shard, Time)>(1);
        let (done, take) = sync_channel(1);
        let work = move || {
            // It ends when nobody gives or takes any more.
            for (mut shard, until) in given {
                shard.advance_to(until);
                if done.send(shard).is_err() {
                    return;
                }
            }
        };
        let thread = Builder::new().name(format!("shard {number}")).spawn(work)?;
        Ok(Self { give: Some(give), take, thread: Some(thread) })
    }

    fn give(&mut self, shard: Shard, until: Time) {
        if self.give.as_ref().is_none_or(|give| give.send((shard, until)).is_err()) {
            self.fail();
        }
    }

    fn take(&mut self) -> Shard {
        match self.take.recv() {
            Ok(shard) => shard,
            Err(_) => self.fail(),
        }
    }

    /// The thread is gone: the caller fails as it did.
    fn fail(&mut self) -> ! {
        match self.thread.take().map(JoinHandle::join) {
            Some(Err(panic)) => resume_unwind(panic),
            _ => panic!("a thread that advances a shard ended without a word"),
        }
    }
}

impl Drop for Hand {
    fn drop(&mut self) {
        self.give = None;
        if let Some(thread) = self.thread.take() {
            // A panic has been told where the shard was missed.
            drop(thread.join());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file::SceneText;
    use crate::simulation::Simulation;
    use protocol::stats::Stats;
    use std::sync::Arc;

    fn gas(balls: usize) -> Controller {
        SceneText::open("gas").unwrap().with_balls(Some(balls as u32)).load().unwrap().controller().unwrap()
    }

    #[test]
    fn a_large_scene_is_shared_and_has_the_bits_of_one_thread() {
        let mut alone = gas(2 * SHARD_LEAST_BALLS);
        let mut shared = alone.clone();
        let mut crew = Crew::of(3).unwrap();
        for tick in 1..=30 {
            let time = Time::of_tick(tick, 60);
            let told = alone.advance_to(time);
            assert_eq!(crew.advance(&mut shared, time), told, "tick {tick}");
            assert_eq!(shared.state_hash(), alone.state_hash(), "tick {tick}");
        }
        assert_eq!(shared.division().map(|division| division.shards), Some(2));
        assert_eq!(shared.checkpoint(), alone.checkpoint());
    }

    #[test]
    fn statistics_tell_of_every_phase_that_threads_shared() {
        let of = |balls: usize| {
            let loaded = SceneText::open("gas").unwrap().with_balls(Some(balls as u32)).load().unwrap();
            let mut simulation =
                Simulation::new(Arc::new(loaded), 60, 1).unwrap().run_by(Crew::of(2).unwrap());
            (0..12).for_each(|_| simulation.advance());
            let mut stats = Stats::default();
            simulation.write_stats(&mut stats);
            stats.division
        };
        let division = of(2 * SHARD_LEAST_BALLS).unwrap();
        assert_eq!(division.shards, 2);
        assert!(division.copies > 0 && division.kept > 0, "{division:?}");
        assert!(
            division.kept + division.undone + division.in_one >= 12,
            "a tick is a phase or more: {division:?}"
        );
        assert_eq!(of(100), None);
    }

    #[test]
    fn a_small_scene_stays_in_one_piece() {
        let mut run = gas(100);
        Crew::of(2).unwrap().advance(&mut run, Time::of_tick(1, 60));
        assert_eq!(run.division(), None);
    }

    #[test]
    #[should_panic(expected = "ended without a word")]
    fn a_hand_that_is_gone_is_told_and_nobody_waits() {
        let mut hand = Hand::new(1).unwrap();
        hand.give = None;
        hand.take();
    }
}
