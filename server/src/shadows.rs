//! The running error estimate: shadows of a few balls, computed a hundred times more exactly on a thread of their own.
//!
//! A shadow begins where its ball is and goes on alone, with the scene's walls. How far the two have come apart is the error
//! that the ball has gathered since, amplified as the floor amplifies it. A hit with another ball or a player's command
//! begins it anew: the shadow knows of neither. The run knows nothing of shadows: once a second of wall time it leaves eight
//! states at most for them, and it leaves them out when the last ones have not been taken.

use crate::scene_file::LoadedScene;
use crate::simulation::Simulation;
use crate::world::World;
use ballroom_physics::{Accuracy, BallState, Controller, HitPartner, Scene, Seat, Time};
use protocol::stats::ErrorEstimate;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};

/// Most balls that are followed.
pub const SHADOWS_MAX: usize = 8;
/// How much more exactly a shadow moves than its ball.
const TIGHTER: f64 = 100.0;
/// The most exact that there is, m.
const TIGHTEST_M: f64 = 1e-13;
/// How exactly the shadow of a ball moves that takes steps of fixed length, m.
const BESIDE_FIXED_M: f64 = 1e-12;
/// Distance at which a shadow has lost its ball, in radii: beyond it the two move on ground of their own, and how far apart
/// they are says nothing of the integration any more.
const LOST_RADII: f64 = 0.1;

/// What the run leaves for the shadows.
struct Sample {
    world: Arc<World>,
    epoch: u64,
    time: Time,
    states: [BallState; SHADOWS_MAX],
    /// Balls, by place in the sample, whose shadows have to begin anew.
    disturbed: [bool; SHADOWS_MAX],
}

/// The run's end: it is shown every tick, and gives samples away.
pub struct Sampler {
    count: usize,
    disturbed: [bool; SHADOWS_MAX],
    samples: SyncSender<Sample>,
    latest: Arc<Mutex<Option<ErrorEstimate>>>,
}

/// The other end, for a thread of its own.
pub struct Shadows {
    count: usize,
    samples: Receiver<Sample>,
    latest: Arc<Mutex<Option<ErrorEstimate>>>,
}

/// Both ends, for up to `count` shadows.
pub fn shadows(count: usize) -> (Sampler, Shadows) {
    let count = count.min(SHADOWS_MAX);
    let (sender, receiver) = sync_channel(1);
    let latest = Arc::default();
    let sampler =
        Sampler { count, disturbed: [true; SHADOWS_MAX], samples: sender, latest: Arc::clone(&latest) };
    (sampler, Shadows { count, samples: receiver, latest })
}

/// The balls that are followed, evenly spread over the ids.
fn chosen(count: usize, balls: usize) -> impl Iterator<Item = usize> {
    let count = count.min(balls);
    (0..count).map(move |place| place * balls / count)
}

impl Sampler {
    /// Takes note of a tick: whom other balls have hit, and whether anybody is driven.
    pub fn ticked(&mut self, simulation: &Simulation) {
        if simulation.is_any_driven() {
            self.commanded();
            return;
        }
        let balls = simulation.roster().names.len();
        for hit in simulation.hits() {
            let HitPartner::Ball(other) = hit.partner else { continue };
            for (disturbed, ball) in self.disturbed.iter_mut().zip(chosen(self.count, balls)) {
                *disturbed |= ball == hit.ball || ball == other;
            }
        }
    }

    /// Takes note of commands: any may have moved a ball.
    pub const fn commanded(&mut self) {
        self.disturbed = [true; SHADOWS_MAX];
    }

    /// Gives the present states to the shadows, if they have taken the last ones.
    pub fn give(&mut self, simulation: &Simulation) {
        let mut states = [BallState::default(); SHADOWS_MAX];
        let balls = simulation.roster().names.len();
        for (state, ball) in states.iter_mut().zip(chosen(self.count, balls)) {
            *state = simulation.ball_state(ball);
        }
        let sample = Sample {
            world: Arc::clone(simulation.world()),
            epoch: simulation.epoch(),
            time: simulation.time(),
            states,
            disturbed: self.disturbed,
        };
        if self.samples.try_send(sample).is_ok() {
            self.disturbed = [false; SHADOWS_MAX];
        }
    }

    /// What the shadows found last; none while they are busy saying it.
    pub fn latest(&self) -> Option<ErrorEstimate> {
        self.latest.try_lock().ok().and_then(|latest| *latest)
    }
}

/// A ball's shadow.
struct Shadow {
    /// The scene with this ball alone, at its start.
    start: Controller,
    /// The shadow itself; its clock counts from `since`.
    now: Controller,
    since: Time,
    radius: f64,
}

impl Shadow {
    fn new(scene: &Scene, place: usize) -> Option<Self> {
        let ball = scene.balls[place].clone();
        let radius = ball.radius;
        let alone = Scene { balls: vec![ball], accuracy: tighter(scene.accuracy), ..scene.clone() };
        let start = Controller::new(&alone).ok()?;
        Some(Self { now: start.clone(), start, since: Time::ZERO, radius })
    }

    /// Begins anew where the ball is; false if there is no room for it.
    fn begin(&mut self, time: Time, state: &BallState, rolls: bool) -> bool {
        self.now.clone_from(&self.start);
        self.since = time;
        let Ok(spot) = self.start.spot(0, state.center.xy()) else { return false };
        let spin = rolls.then(|| state.omega.dot(&state.normal));
        self.now
            .set_balls(&[Seat { ball: 0, spot: Some(spot), velocity: Some(state.velocity), spin }])
            .is_ok()
    }

    /// Follows to `time`; how far it is from its ball then, m, and how long it has followed, s.
    fn follow(&mut self, time: Time, state: &BallState) -> [f64; 2] {
        let followed = time.since(self.since);
        self.now.advance_to(Time::of_seconds(followed));
        [(self.now.ball(0).center - state.center).norm(), followed]
    }
}

const fn tighter(accuracy: Accuracy) -> Accuracy {
    Accuracy::Tolerance(match accuracy {
        Accuracy::Tolerance(tolerance) => (tolerance / TIGHTER).max(TIGHTEST_M),
        Accuracy::Fixed(..) => BESIDE_FIXED_M,
    })
}

/// The shadows of one world and epoch.
struct Cast {
    world: Arc<World>,
    epoch: u64,
    shadows: Vec<Option<Shadow>>,
    lost: u64,
}

impl Cast {
    fn new(sample: &Sample, count: usize) -> Self {
        let loaded: &LoadedScene = sample.world.loaded();
        let places = sample.world.start().scene_index();
        let shadow = |ball: usize| Shadow::new(loaded.physics(), places[ball]);
        Self {
            world: Arc::clone(&sample.world),
            epoch: sample.epoch,
            shadows: chosen(count, places.len()).map(shadow).collect(),
            lost: 0,
        }
    }

    fn belongs_to(&self, sample: &Sample) -> bool {
        Arc::ptr_eq(&self.world, &sample.world) && self.epoch == sample.epoch
    }

    /// Follows to a sample. Of the balls that were followed up to it, the error of the one that is farthest from its shadow.
    fn follow(&mut self, sample: &Sample) -> Option<ErrorEstimate> {
        let scene = self.world.loaded().physics();
        let rolls = scene.motion == ballroom_physics::MotionLaw::Rolling;
        let mut worst = ErrorEstimate {
            time_s: sample.time.seconds(),
            asked_m: self.world.loaded().asked_error_m(),
            ..ErrorEstimate::default()
        };
        for ((slot, state), disturbed) in self.shadows.iter_mut().zip(&sample.states).zip(sample.disturbed) {
            let Some(shadow) = slot else { continue };
            let mut begins = disturbed;
            if !disturbed {
                let [error_m, followed_s] = shadow.follow(sample.time, state);
                if error_m <= LOST_RADII * shadow.radius {
                    worst.balls += 1;
                    if error_m >= worst.error_m {
                        (worst.error_m, worst.followed_s) = (error_m, followed_s);
                    }
                } else {
                    self.lost += 1;
                    begins = true;
                }
            }
            if begins && !shadow.begin(sample.time, state, rolls) {
                *slot = None;
            }
        }
        worst.lost = self.lost;
        (worst.balls > 0).then_some(worst)
    }
}

impl Shadows {
    /// Follows until the run has ended.
    pub fn run(self) {
        let mut cast: Option<Cast> = None;
        while let Ok(mut sample) = self.samples.recv() {
            if !cast.as_ref().is_some_and(|cast| cast.belongs_to(&sample)) {
                cast = Some(Cast::new(&sample, self.count));
                sample.disturbed = [true; SHADOWS_MAX];
            }
            let found = cast.as_mut().and_then(|cast| cast.follow(&sample));
            *self.latest.lock().unwrap_or_else(PoisonError::into_inner) = found;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file::SceneText;

    /// A solid ball and a hollow one that spins, each on a path of its own.
    const TWO: &str = r#"
        version = 1
        name = "two"
        floor.polynomial = { x_m = [-5.0, 5.0], y_m = [-5.0, 5.0], terms = [{ px = 2, c = 0.1 }, { py = 2, c = 0.1 }] }
        [[ball]]
        name = "inner"
        radius_m = 0.2
        mass_kg = 1.0
        center_m = [0.5, 0.0]
        velocity_m_per_s = [0.0, 0.5, 0.0]
        [[ball]]
        name = "outer"
        radius_m = 0.3
        mass_kg = 1.0
        inertia = "hollow"
        center_m = [3.0, 0.0]
        velocity_m_per_s = [0.0, 3.0, 0.0]
        spin_rad_per_s = 4.0
    "#;

    /// Runs a scene for ten seconds with shadows that take a sample a second; what they say then, and the run.
    fn estimate(scene: &SceneText, tolerance_m: f64) -> (Option<ErrorEstimate>, Simulation) {
        let loaded = scene.clone().with_tolerance(Some(tolerance_m)).load().unwrap();
        let mut simulation = Simulation::new(Arc::new(loaded), 60, 1).unwrap();
        let (mut sampler, shadows) = shadows(SHADOWS_MAX);
        let mut cast = None;
        let mut found = None;
        for tick in 0..=600 {
            if tick > 0 {
                simulation.advance();
                sampler.ticked(&simulation);
            }
            if tick % 60 == 0 {
                sampler.give(&simulation);
                let sample = shadows.samples.recv().unwrap();
                found = cast.get_or_insert_with(|| Cast::new(&sample, SHADOWS_MAX)).follow(&sample);
            }
        }
        (found, simulation)
    }

    /// The error of the farthest of the balls chosen, beside the most exact run.
    fn truth(scene: &SceneText, of: &Simulation) -> f64 {
        let loaded = scene.clone().with_tolerance(Some(TIGHTEST_M)).load().unwrap();
        let mut exact = Simulation::new(Arc::new(loaded), 60, 1).unwrap();
        exact.advance_to(of.time());
        let apart = |ball| (exact.ball_state(ball).center - of.ball_state(ball).center).norm();
        chosen(SHADOWS_MAX, of.roster().names.len()).map(apart).fold(0.0, f64::max)
    }

    #[test]
    fn the_estimate_is_the_error_within_a_tenth_of_it() {
        for scene in [SceneText::open("bicubic").unwrap(), SceneText::new("two.toml", TWO)] {
            for tolerance_m in [1e-6, 1e-8, 1e-9] {
                let (found, run) = estimate(&scene, tolerance_m);
                let found = found.expect("a ball that was followed");
                let exact = truth(&scene, &run);
                assert!(
                    (found.error_m - exact).abs() < 0.1 * exact,
                    "{}: {found:?} of {exact:e}",
                    scene.file()
                );
                assert_eq!((found.followed_s, found.asked_m), (10.0, Some(tolerance_m)));
                assert_eq!(found.balls as usize, run.roster().names.len());
            }
        }
    }

    #[test]
    fn a_shadow_begins_anew_after_a_hit_with_another_ball() {
        let (found, _) = estimate(&SceneText::open("gas").unwrap(), 1e-8);
        // In a gas a ball is hit several times a second: hardly one is followed, and none for long.
        assert!(found.is_none_or(|found| found.followed_s < 5.0), "{found:?}");
    }
}
