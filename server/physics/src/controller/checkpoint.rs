//! A checkpoint: a run at one instant as plain words, which restore every bit; and the hash of its future.

use super::Controller;
use super::plain::{Plain, Reader};
use crate::scene::{Accuracy, Scheme};
use crate::schedule::event::What;

/// Changes whenever the words of a checkpoint change their meaning.
const VERSION: u64 = 1;
/// Words before a run's own: version, scene, balls, checksum.
const HEAD: usize = 4;

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
        let mut words = vec![VERSION, self.scene_hash(), self.balls.len() as u64, 0];
        let mut keep = |word| words.push(word);
        [self.time, self.now].all(&mut keep);
        self.report.all(&mut keep);
        for ball in 0..self.balls.len() {
            self.balls[ball].all(&mut keep);
            self.arcs[ball].all(&mut keep);
            self.queue.of(ball).all(&mut keep);
            self.broad_phase.bounds_of(ball).all(&mut keep);
        }
        words[HEAD - 1] = checksum(&words[HEAD..]);
        Checkpoint { words }
    }

    /// Goes on where `checkpoint` was made, in a controller of the same scene: every bit of every later state is that of
    /// the run that never stopped.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), CheckpointFault> {
        let words = &checkpoint.words;
        let want = self.checkpoint().words.len();
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
        let mut restored = self.clone();
        if checksum(&words[HEAD..]) != sum || !restored.read(&words[HEAD..]) {
            return Err(CheckpointFault::Damaged);
        }
        *self = restored;
        Ok(())
    }

    /// Takes over a run's words; false if some mean nothing.
    fn read(&mut self, words: &[u64]) -> bool {
        let mut from = Reader::new(words);
        [self.time, self.now] = Plain::read(&mut from);
        self.report = Plain::read(&mut from);
        let (balls, walls) = (self.balls.len(), self.walls.len());
        for ball in 0..balls {
            self.balls[ball] = Plain::read(&mut from);
            self.arcs[ball] = Plain::read(&mut from);
            let next = Plain::read(&mut from);
            self.queue.set(ball, next);
            self.broad_phase.file(ball, Plain::read(&mut from));
            let known = match next.what {
                What::Ball { other, .. } => (other as usize) < balls,
                What::Wall { wall } => (wall as usize) < walls,
                What::Renew => true,
            };
            if from.failed() || !known || !self.arcs[ball].is_sane() {
                return false;
            }
        }
        self.hits.clear();
        self.observe();
        self.is_on_its_floor()
    }

    /// Whether every ball stands where the floor is, with an energy that is a number: what words that fit together may
    /// still not say.
    fn is_on_its_floor(&self) -> bool {
        let near = |x: &f64| (-0.5..=1.5).contains(x);
        self.energy().is_finite() && self.states.iter().all(|state| state.uv.iter().all(near))
    }

    /// Hash of everything that influences the future; equal at equal times whatever the tick rate and the order
    /// of the scene's list.
    pub fn state_hash(&self) -> u64 {
        let mut hash = Hash::new();
        let mut mix = |word| hash.word(word);
        [self.time, self.now].seeds(&mut mix);
        self.report.seeds(&mut mix);
        for ball in 0..self.balls.len() {
            self.balls[ball].seeds(&mut mix);
            self.arcs[ball].seeds(&mut mix);
            self.queue.of(ball).seeds(&mut mix);
            self.broad_phase.bounds_of(ball).seeds(&mut mix);
        }
        hash.0
    }

    /// Hash of what a run is given and never changes: controllers that share it may exchange checkpoints.
    fn scene_hash(&self) -> u64 {
        let mut hash = Hash::new();
        let mut mix = |word| hash.word(word);
        self.patch.net().iter().for_each(|point| point.all(&mut mix));
        self.walls.iter().for_each(|wall| [wall.normal, wall.point].all(&mut mix));
        self.gravity.all(&mut mix);
        self.restitution.all(&mut mix);
        match self.accuracy {
            Accuracy::Tolerance(tolerance) => [0.0, tolerance],
            Accuracy::Fixed(Scheme::Rk4, step) => [1.0, step],
            Accuracy::Fixed(Scheme::Tsit5, step) => [2.0, step],
            Accuracy::Fixed(Scheme::Dop853, step) => [3.0, step],
        }
        .all(&mut mix);
        self.hit_budget.all(&mut mix);
        for ball in &self.balls {
            [ball.body.radius, ball.body.inertia_factor, ball.mass].all(&mut mix);
            ball.free_omega.all(&mut mix);
        }
        hash.0
    }
}

fn checksum(words: &[u64]) -> u64 {
    let mut hash = Hash::new();
    for word in words {
        hash.word(*word);
    }
    hash.0
}

/// Mixes words one by one with the finaliser of splitmix64 (Steele, Lea, Flood 2014).
struct Hash(u64);

impl Hash {
    const fn new() -> Self {
        Self(0x243f_6a88_85a3_08d3)
    }

    const fn word(&mut self, word: u64) {
        let mut x = (self.0 ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        self.0 = x ^ (x >> 31);
    }
}
