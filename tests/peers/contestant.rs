//! What every contestant can do.

use super::problem::{Problem, Sample};
use server::report::clock;

/// A world in motion.
pub trait World {
    /// Goes on to sample number `sample` of the problem.
    fn go_to(&mut self, sample: u64);
    /// The balls as they are.
    fn look(&self) -> Sample;
    /// Hits counted since the start; none where they are not counted.
    fn hits(&self) -> Option<u64>;
}

/// Makes a world of a problem.
pub type Make = Box<dyn Fn(&Problem, bool) -> Box<dyn World>>;

/// A way to run a problem.
pub struct Entry {
    /// Name of the engine, with its precision.
    pub engine: &'static str,
    /// Its settings, in few words.
    pub setting: String,
    /// Makes the world; with `true`, one that also counts hits.
    pub make: Make,
}

/// All samples of a run, the start included, and the hits counted.
pub fn ride(problem: &Problem, entry: &Entry) -> (Vec<Sample>, Option<u64>) {
    let mut world = (entry.make)(problem, true);
    let mut samples = vec![world.look()];
    for sample in 1..=problem.samples() {
        world.go_to(sample);
        samples.push(world.look());
    }
    (samples, world.hits())
}

/// CPU seconds per simulated second. In a gas, where every tenth of the run is like the others, the first tenth is the
/// warm-up, outside the clock; elsewhere all of the run counts.
pub fn cost(problem: &Problem, entry: &Entry) -> f64 {
    let (warm, last) = (problem.warm_up(), problem.samples());
    let prepare = || {
        let mut world = (entry.make)(problem, false);
        world.go_to(warm);
        world
    };
    let run = |world: &mut Box<dyn World>| (warm + 1..=last).for_each(|sample| world.go_to(sample));
    clock::cost(prepare, run).seconds * f64::from(problem.sample_hz) / (last - warm) as f64
}
