//! A checkpoint: a run at one instant as plain words, which restore every bit; and the hash of its future.

use super::plain::{Plain, Reader};
use super::{Ball, BallState, Controller};
use crate::detect::broad_phase::Bounds;
use crate::motion::arc::Path;
use crate::motion::body::Stepping;
use crate::scene::{Accuracy, Scheme};
use crate::schedule::event::{Next, What};
use crate::schedule::time::{QUANTUM, Time};
use crate::tolerance::{SANE, STEP_MAX, STEP_MIN, WINDOW_MAX};

/// Changes whenever the words of a checkpoint change their meaning.
const VERSION: u64 = 3;
/// Words before a run's own: version, scene, balls, checksum.
const HEAD: usize = 4;
/// Quanta that no run reaches: sums of times stay far from overflow.
const LATEST: i64 = 1 << 53;

/// A run at one instant, as words. It belongs to one scene and holds what the scene does not say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checkpoint {
    words: Vec<u64>,
}

impl Checkpoint {
    /// Its words, to be kept in any container that returns them unchanged.
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// From words that were kept; they are checked when it is restored.
    pub const fn of_words(words: Vec<u64>) -> Self {
        Self { words }
    }
}

/// Why a checkpoint cannot be restored. The run that was to take it goes on as before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CheckpointFault {
    /// It was written by another version of the engine.
    #[error(
        "the checkpoint has format {0}, and this engine reads {VERSION}: run it with the engine that wrote it"
    )]
    Version(u64),
    /// It was made in another scene.
    #[error("the checkpoint belongs to another scene: load the scene it was made in, unchanged")]
    Scene,
    /// Words are missing, or there are more than there should be.
    #[error("the checkpoint has {have} words where {want} are due: it was cut short or damaged")]
    Length {
        /// How many there are.
        have: usize,
        /// How many there should be.
        want: usize,
    },
    /// Its checksum does not fit, or a word means nothing.
    #[error("the checkpoint is damaged: its words do not fit together")]
    Damaged,
}

impl Controller {
    /// The run as it stands at the controller's time. The list of hits of the last advance is no part of it.
    pub fn checkpoint(&self) -> Checkpoint {
        let mut run = Vec::with_capacity(self.run_words());
        self.write_run(&mut run);
        self.checkpoint_of(&run)
    }

    /// Goes on where `checkpoint` was made, in a controller of the same scene: every bit of every later state is that of
    /// the run that never stopped.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), CheckpointFault> {
        *self = self.at_run(self.run_of(checkpoint)?)?;
        Ok(())
    }

    /// Adds the run's own words to `words`: what counts of a ball is where its arc begins, for the arc follows from it.
    /// Takes no memory when there is room for [`Self::run_words`] more.
    pub fn write_run(&self, words: &mut Vec<u64>) {
        let mut keep = |word| words.push(word);
        [self.time, self.now].all(&mut keep);
        self.report.all(&mut keep);
        for ball in 0..self.balls.len() {
            self.holder(ball).seeds_of(ball, &mut keep);
        }
    }

    /// The words of one ball that its future follows from.
    pub(super) fn seeds_of(&self, ball: usize, keep: &mut impl FnMut(u64)) {
        self.balls[ball].seeds(keep);
        self.arcs[ball].seeds(keep);
        self.queue.of(ball).seeds(keep);
        self.broad_phase.bounds_of(ball).seeds(keep);
    }

    /// Takes over words of [`Self::seeds_of`]; false if another arc comes of them.
    pub(super) fn sow_ball(&mut self, ball: usize, from: &mut Reader<'_>) -> bool {
        self.balls[ball].sow(from);
        self.arcs[ball].sow(from);
        let next = Plain::read(from);
        let bounds = Plain::read(from);
        self.queue.set(ball, next);
        self.broad_phase.file(ball, bounds);
        !from.failed() && self.launch_again(ball)
    }

    /// How many words [`Self::write_run`] writes.
    pub fn run_words(&self) -> usize {
        let mut words = 0;
        let mut count = |_| words += 1;
        [self.time, self.now].all(&mut count);
        self.report.all(&mut count);
        if !self.balls.is_empty() {
            let fixed = std::mem::take(&mut words);
            self.seeds_of(0, &mut |_| words += 1);
            words = fixed + words * self.balls.len();
        }
        words
    }

    /// How many words a checkpoint has.
    pub fn checkpoint_words(&self) -> usize {
        HEAD + self.run_words()
    }

    /// The checkpoint that [`Self::write_run`] wrote the words of.
    pub fn checkpoint_of(&self, run: &[u64]) -> Checkpoint {
        let mut words = vec![VERSION, self.scene_hash(), self.balls.len() as u64, checksum(run)];
        words.extend_from_slice(run);
        Checkpoint { words }
    }

    /// The run's own words in a checkpoint of the same scene.
    pub fn run_of<'a>(&self, checkpoint: &'a Checkpoint) -> Result<&'a [u64], CheckpointFault> {
        let words = &checkpoint.words;
        let want = self.checkpoint_words();
        let length = CheckpointFault::Length { have: words.len(), want };
        let [version, scene, balls, sum] = *words.first_chunk::<HEAD>().ok_or(length)?;
        if version != VERSION {
            return Err(CheckpointFault::Version(version));
        }
        if scene != self.scene_hash() || balls != self.balls.len() as u64 {
            return Err(CheckpointFault::Scene);
        }
        if words.len() != want {
            return Err(length);
        }
        if checksum(&words[HEAD..]) != sum {
            return Err(CheckpointFault::Damaged);
        }
        Ok(&words[HEAD..])
    }

    /// A controller of the same scene at the run whose own words these are. Arcs are launched again, which gives their
    /// every bit. Takes words of [`Self::write_run`] only; a [`Checkpoint`] has a checksum.
    pub fn at_run(&self, words: &[u64]) -> Result<Self, CheckpointFault> {
        let want = self.run_words();
        if words.len() != want {
            return Err(CheckpointFault::Length { have: words.len(), want });
        }
        let mut there = self.clone();
        there.undivide();
        if there.read_run(words) { Ok(there) } else { Err(CheckpointFault::Damaged) }
    }

    /// Takes over a run's words; false if some mean nothing.
    fn read_run(&mut self, words: &[u64]) -> bool {
        let mut from = Reader::new(words);
        [self.time, self.now] = Plain::read(&mut from);
        self.report = Plain::read(&mut from);
        for ball in 0..self.balls.len() {
            self.balls[ball].sow(&mut from);
            self.arcs[ball].sow(&mut from);
            let next = Plain::read(&mut from);
            let bounds: Bounds = Plain::read(&mut from);
            if from.failed() || !self.makes_sense(ball, &next, &bounds) || !self.launch_again(ball) {
                return false;
            }
            self.queue.set(ball, next);
            self.broad_phase.file(ball, bounds);
        }
        self.clear_hits();
        self.is_on_its_floor()
    }

    /// Whether every ball stands where the floor is, with an energy that is a number: what words that fit together may
    /// still not say.
    fn is_on_its_floor(&self) -> bool {
        let near = |x: &f64| (-0.5..=1.5).contains(x);
        let is_near = |ball| {
            let (state, ..) = self.seen(ball);
            self.surface.uv([state[0], state[1]]).iter().all(near)
        };
        self.energy().is_finite() && (0..self.balls.len()).all(is_near)
    }

    /// The largest speed, speed of the skin and change of speed that a force makes in a second, over all balls, m/s. What
    /// it is beyond reason costs time beyond reason.
    pub fn liveliest(&self) -> f64 {
        let of_ball = |(ball, state): (&Ball, BallState)| {
            let drive = ball.drive.map_or(0.0, |drive| (drive.acceleration * drive.direction.norm()).abs());
            let skin = state.omega.norm() * ball.body.radius;
            [state.velocity.norm(), skin, ball.body.applied.norm(), drive]
        };
        // Unlike `f64::max`, this keeps what is not a number.
        let larger = |a: f64, b: f64| if a >= b { a } else { b };
        (0..self.balls.len())
            .map(|ball| &self.holder(ball).balls[ball])
            .zip(self.balls())
            .flat_map(of_ball)
            .fold(0.0, larger)
    }

    /// Whether a ball's words can be those of a run at this time: nothing began later or ends too late, nobody meets
    /// strangers, every number can be worked with.
    fn makes_sense(&self, ball: usize, next: &Next, bounds: &Bounds) -> bool {
        let (body, arc) = (&self.balls[ball].body, &self.arcs[ball]);
        let known = match next.what {
            What::Ball { other, .. } => (other as usize) < self.balls.len(),
            What::Wall { wall } => (wall as usize) < self.walls.len(),
            What::Renew => true,
        };
        let present = self.time.max(self.now);
        let soon = present.after(2.0 * WINDOW_MAX);
        let times = Time::ZERO <= arc.start
            && arc.start <= present
            && present.quantum() < LATEST
            && self.time <= next.time
            && next.time <= soon
            && arc.window_end <= soon;
        let numbers = body.applied.iter().chain(&arc.state).chain(&arc.turning.start).chain(bounds);
        known && times && numbers.into_iter().all(|x| x.abs() <= SANE)
    }

    /// Launches the arc that a ball is on once more; false if another one comes of it.
    fn launch_again(&mut self, ball: usize) -> bool {
        let Self { surface, accuracy, balls, arcs, .. } = self;
        let (body, arc) = (&balls[ball].body, &mut arcs[ball]);
        arc.driven = balls[ball].drive.is_some();
        let (start, state, length, path) = (arc.start, arc.state, arc.length, arc.path);
        let steps = STEP_MIN..=STEP_MAX;
        if !steps.contains(&balls[ball].stepping.try_s) {
            return false;
        }
        if path == Path::Held {
            if !(0.0..=QUANTUM).contains(&length) {
                return false;
            }
            body.hold(surface, (start, &state), length, arc);
        } else {
            if !surface.is_flat() && !steps.contains(&length) {
                return false;
            }
            // The step that was kept is tried first, and kept again.
            let mut stepping = Stepping { try_s: length, steps: 0, forced: 0 };
            body.launch(surface, *accuracy, (start, &state), &mut stepping, arc);
        }
        (arc.length, arc.path) == (length, path) && arc.is_sane()
    }

    /// Hash of everything that influences the future, the scene and its laws too; equal at equal times whatever the tick
    /// rate and the order of the scene's list.
    pub fn state_hash(&self) -> u64 {
        self.state_hash_with([])
    }

    /// The same with `more` words that the caller steers the run by.
    pub fn state_hash_with(&self, more: impl IntoIterator<Item = u64>) -> u64 {
        let mut hash = Hash::new();
        let mut mix = |word| hash.word(word);
        self.laws(&mut mix);
        [self.time, self.now].seeds(&mut mix);
        self.report.seeds(&mut mix);
        more.into_iter().for_each(mix);
        for ball in 0..self.balls.len() {
            // A hash for each: balls do not wait for each other.
            let mut of_ball = Hash::new();
            let at = self.holder(ball);
            at.make_of(ball, &mut |word| of_ball.word(word));
            at.seeds_of(ball, &mut |word| of_ball.word(word));
            hash.word(of_ball.end());
        }
        hash.end()
    }

    /// Whether both were made from the same scene, so that they may exchange runs and checkpoints.
    pub fn shares_scene_with(&self, other: &Self) -> bool {
        self.balls.len() == other.balls.len() && self.scene_hash() == other.scene_hash()
    }

    /// Hash of what a run is given and never changes: controllers that share it may exchange checkpoints.
    fn scene_hash(&self) -> u64 {
        let mut hash = Hash::new();
        let mut mix = |word| hash.word(word);
        self.laws(&mut mix);
        (0..self.balls.len()).for_each(|ball| self.make_of(ball, &mut mix));
        hash.end()
    }

    /// The words of the floor, the walls and the laws.
    fn laws(&self, keep: &mut impl FnMut(u64)) {
        self.patch.net().iter().for_each(|point| point.all(keep));
        self.walls.iter().for_each(|wall| [wall.normal, wall.point].all(keep));
        self.gravity.all(keep);
        self.restitution.all(keep);
        match self.accuracy {
            Accuracy::Tolerance(tolerance) => [0.0, tolerance],
            Accuracy::Fixed(Scheme::Rk4, step) => [1.0, step],
            Accuracy::Fixed(Scheme::Tsit5, step) => [2.0, step],
            Accuracy::Fixed(Scheme::Dop853, step) => [3.0, step],
        }
        .all(keep);
        self.hit_budget.all(keep);
    }

    /// The words of what one ball is made as.
    fn make_of(&self, ball: usize, keep: &mut impl FnMut(u64)) {
        let Ball { body, mass, free_omega, .. } = &self.balls[ball];
        [body.radius, body.inertia_factor, *mass].all(keep);
        free_omega.all(keep);
    }
}

fn checksum(words: &[u64]) -> u64 {
    let mut hash = Hash::new();
    for word in words {
        hash.word(*word);
    }
    hash.end()
}

/// Mixes words in four rows, each of which takes every fourth: a row waits for its own last product only. A row keeps what
/// it was told apart, since each word changes it one to one; the rows are mixed in the end.
struct Hash {
    rows: [u64; 4],
    count: usize,
}

impl Hash {
    /// From the digits of pi.
    const fn new() -> Self {
        let rows =
            [0x243f_6a88_85a3_08d3, 0x1319_8a2e_0370_7344, 0xa409_3822_299f_31d0, 0x082e_fa98_ec4e_6c89];
        Self { rows, count: 0 }
    }

    #[inline(always)]
    const fn word(&mut self, word: u64) {
        let row = &mut self.rows[self.count % 4];
        *row = (*row ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
        self.count += 1;
    }

    /// The hash of all words, by the finaliser of splitmix64 (Steele, Lea, Flood 2014).
    const fn end(&self) -> u64 {
        let [a, b, c, d] = self.rows;
        finish(finish(finish(finish(self.count as u64 ^ a) ^ b) ^ c) ^ d)
    }
}

const fn finish(word: u64) -> u64 {
    let mut x = word.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
