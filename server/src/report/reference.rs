//! What is taken for true, how far it is, and for how long.
//!
//! A run at the tightest tolerance is compared, tick by tick, with a run by another scheme at a small fixed step, and
//! with a shadow: the same run whose starting velocities differ in their last bit. Where the two runs part, the reference
//! is no better than that; where the shadow parts, no arithmetic of this width can say where the balls are.

use super::ReportError;
use super::subject::{Subject, centers, seconds, tick, words};
use ballroom_physics::{Accuracy, Controller, Scene, Scheme};
use nalgebra::Vector3;

/// The tightest setting there is.
const TIGHTEST: Accuracy = Accuracy::Tolerance(1e-13);
/// Steps of the second reference, s; the one that agrees best counts, since shorter ones round more often.
const STEPS: [f64; 3] = [1.0 / 256.0, 1.0 / 512.0, 1.0 / 1024.0];
/// Errors are taken for as long as the references agree to this, m: well below every error worth a curve.
const AGREED_M: f64 = 1e-11;
/// A place is lost when it is wrong by this part of the smallest radius: hits then happen to others.
const LOST_RADII: f64 = 0.1;
/// Change of the starting velocities of a shadow, relative to the fastest: a few last bits.
const SHADOW: f64 = 1e-15;

/// What is taken for true.
#[derive(Clone, Debug)]
pub struct Reference {
    balls: usize,
    /// Centres of all balls, tick after tick, from the start on, m.
    centers: Vec<Vector3<f64>>,
    /// The second reference, in words.
    pub checked_by: String,
    /// Largest distance of any centre from the second reference, up to each tick, m.
    pub disagreement: Vec<f64>,
    /// The same from the shadow, m.
    pub sensitivity: Vec<f64>,
    /// Ticks over which errors are taken.
    pub span: usize,
    /// Distance at which a place counts as lost, m.
    pub lost_m: f64,
    /// First tick at which a place is lost between the references or their shadow, if there is one.
    pub horizon: Option<usize>,
}

impl Reference {
    /// Of the first `ticks` ticks of a scene.
    pub fn new(subject: &Subject, ticks: usize) -> Result<Self, ReportError> {
        let mut truth = Self {
            balls: subject.balls(),
            centers: Vec::new(),
            checked_by: String::new(),
            disagreement: Vec::new(),
            sensitivity: Vec::new(),
            span: ticks,
            lost_m: LOST_RADII * subject.smallest_radius(),
            horizon: None,
        };
        let mut run = subject.start(TIGHTEST)?;
        for n in 0..=ticks {
            run.advance_to(tick(n));
            truth.centers.extend(centers(&run));
        }
        truth.sensitivity = truth.errors(&mut subject.start_of(&shadow(subject))?, ticks);
        for step in STEPS {
            let setting = Accuracy::Fixed(Scheme::Tsit5, step);
            let errors = truth.errors(&mut subject.start(setting)?, ticks);
            let best = truth.checked_by.is_empty() || sooner(&truth.disagreement) > sooner(&errors);
            if best {
                (truth.checked_by, truth.disagreement) = (words(setting), errors);
            }
        }
        let apart: Vec<f64> =
            truth.disagreement.iter().zip(&truth.sensitivity).map(|(a, b)| a.max(*b)).collect();
        let first_over = |limit: f64| apart.iter().position(|&d| d.is_nan() || d > limit);
        truth.span = first_over(AGREED_M).map_or(ticks, |first| first.saturating_sub(1)).max(1);
        truth.horizon = first_over(truth.lost_m);
        Ok(truth)
    }

    /// The first reference, in words.
    pub fn setting() -> String {
        words(TIGHTEST)
    }

    /// Ticks it knows.
    pub fn ticks(&self) -> usize {
        self.centers.len() / self.balls.max(1) - 1
    }

    /// Its own error over the span, m.
    pub fn error(&self) -> f64 {
        self.disagreement[self.span]
    }

    /// Seconds of the span.
    pub fn span_s(&self) -> f64 {
        seconds(self.span)
    }

    /// Largest distance of any ball's centre from the reference up to each of the first ticks, m; not a number from where
    /// a place is none. `run` stands at the start.
    pub fn errors(&self, run: &mut Controller, ticks: usize) -> Vec<f64> {
        let mut largest = 0.0_f64;
        let advance = |(n, truth): (usize, &[Vector3<f64>])| {
            run.advance_to(tick(n));
            for (center, truth) in centers(run).zip(truth) {
                let error = (center - truth).norm();
                // `max` would forget what is not a number.
                largest = if error.is_nan() || largest.is_nan() { f64::NAN } else { largest.max(error) };
            }
            largest
        };
        self.centers.chunks_exact(self.balls.max(1)).enumerate().take(ticks + 1).map(advance).collect()
    }

    /// Largest error of a setting over the span, m.
    pub fn error_of(&self, subject: &Subject, setting: Accuracy) -> Result<f64, ReportError> {
        Ok(self.errors(&mut subject.start(setting)?, self.span)[self.span])
    }

    /// Seconds in which the distance of two neighbouring runs grows tenfold, from where they part until a place is lost;
    /// none if it does not grow that far.
    pub fn tenfold_s(&self) -> Option<f64> {
        let lost = self.sensitivity.iter().position(|&d| d > self.lost_m)?;
        let begin = self.sensitivity.iter().position(|&d| d > 1e3 * SHADOW)?;
        let decades = (self.sensitivity[lost] / self.sensitivity[begin]).log10();
        (lost > begin && decades > 3.0).then(|| seconds(lost - begin) / decades)
    }
}

/// How far two references are apart: first by when they part, then by how far.
fn sooner(disagreement: &[f64]) -> (usize, f64) {
    let agreed = disagreement.iter().take_while(|&&d| d <= AGREED_M).count();
    (disagreement.len() - agreed, disagreement[agreed.max(1) - 1])
}

/// The scene with starting velocities that differ in their last bits, each ball's in another direction. Balls at rest
/// stay so unless all are: a rack that touches is to go on touching.
fn shadow(subject: &Subject) -> Scene {
    let mut scene = Scene { accuracy: TIGHTEST, ..subject.scene().clone() };
    let fastest = scene.balls.iter().map(|ball| ball.velocity.norm()).fold(0.0, f64::max);
    let change = SHADOW * if fastest > 0.0 { fastest } else { 1.0 };
    for (i, ball) in scene.balls.iter_mut().enumerate() {
        if fastest > 0.0 && ball.velocity.norm() == 0.0 {
            continue;
        }
        // The golden angle: no two alike, and along no axis.
        let (sin, cos) = (2.4 * (i + 1) as f64).sin_cos();
        ball.velocity += change * Vector3::new(cos, sin, 0.0);
    }
    scene
}
