//! An error instead of a tolerance: the whole scene is run beforehand, and the largest tolerance is found with which no ball is
//! farther from where it truly is, at any tick of 10 s.
//!
//! A tolerance alone promises that for smooth rides. Hits and hills multiply what was gathered before them; here they are run
//! through. What is true is told by the smallest tolerance there is, and how far that is to be trusted by a tenfold larger one
//! and by small steps of fixed length, whose rounding is another: where these part by a tenth of what is asked for, no
//! tolerance surely keeps it, and the scene is refused.

use super::{Asked, MOST, Rehearsed, SECONDS, evaluations, tolerance};
use crate::scene_file::{LoadedScene, SceneError};
use ballroom_physics::{Accuracy, Controller, Scene, Scheme, Time};
use nalgebra::Vector3;

/// Ticks that are looked at.
const RATE_HZ: u32 = 60;
const TICKS: u64 = SECONDS as u64 * RATE_HZ as u64;
/// What counts as true.
const EXACT: Accuracy = Accuracy::Tolerance(1e-13);
/// What it is compared with beside the smallest tolerance that is tried.
const STEADY: Accuracy = Accuracy::Fixed(Scheme::Dop853, 1.0 / 256.0);
/// The smallest tolerance that is tried, in quarters of a decade: 1e-12 m.
const LEAST: i32 = -48;
/// Share of what is asked for that is used: what counts as true is not quite.
const SHARE: f64 = 0.9;
/// Share of it by which two runs may part that count as true.
const DOUBT: f64 = 0.1;
/// Most balls.
const BALLS: usize = 1_000;
/// Most work of a run: steps and searches. A second or two.
const WORK: u64 = 1 << 22;

/// Finds the largest tolerance that keeps an error of `error_m`.
pub(super) fn kept(loaded: &LoadedScene, error_m: f64) -> Result<Rehearsed, SceneError> {
    if loaded.controller()?.balls().len() > BALLS {
        return Err(refuse(
            loaded,
            &format!("asks for a run beforehand: at most {BALLS} balls are run; name a tolerance_m"),
        ));
    }
    let exact = Track::of(loaded, EXACT)?;
    let found = |quarters, track: &Track| Rehearsed {
        asked: Asked::Error(error_m),
        tolerance_m: tolerance(quarters),
        evaluations: track.evaluations,
        reached_m: track.distance(&exact),
    };
    if exact.evaluations == 0.0 {
        // Where nothing is integrated every tolerance gives the same run.
        return Ok(found(MOST, &exact));
    }
    let with = |quarters| Track::of(loaded, Accuracy::Tolerance(tolerance(quarters)));
    let (finest, steady) = (with(LEAST)?, Track::of(loaded, STEADY)?);
    let doubts = [&finest, &steady].map(|other| other.parting(&exact, DOUBT * error_m));
    if let Some(tick) = doubts.into_iter().flatten().min() {
        let seconds = tick as f64 / f64::from(RATE_HZ);
        return Err(refuse(
            loaded,
            &format!(
                "is {error_m:e}: hits or hills multiply errors so that no tolerance surely keeps it for longer than \
                 {seconds:.2} s; ask for a larger one, or name a tolerance_m"
            ),
        ));
    }
    // With the least it is kept, and errors grow with the tolerance but for luck: halving finds where it is not kept any more.
    let (mut least, mut most, mut best) = (LEAST, MOST, finest);
    while least < most {
        let middle = (least + most + 1).div_euclid(2);
        let track = with(middle)?;
        if track.parting(&exact, SHARE * error_m).is_none() {
            (least, best) = (middle, track);
        } else {
            most = middle - 1;
        }
    }
    Ok(found(least, &best))
}

/// Where the balls of a run were at each tick.
struct Track {
    centers: Vec<Vector3<f64>>,
    balls: usize,
    evaluations: f64,
}

impl Track {
    fn of(loaded: &LoadedScene, accuracy: Accuracy) -> Result<Self, SceneError> {
        let scene = Scene { accuracy, ..loaded.physics().clone() };
        let mut run = Controller::new(&scene).map_err(|fault| loaded.refused(&fault))?;
        let balls = run.balls().len();
        let mut centers = Vec::with_capacity(balls * TICKS as usize);
        for tick in 1..=TICKS {
            run.advance_to(Time::of_tick(tick, RATE_HZ));
            centers.extend(run.balls().map(|ball| ball.center));
            if run.report().steps + run.report().searches > WORK {
                let most =
                    format!("asks for a run beforehand, which takes more than {WORK} steps and searches");
                return Err(refuse(loaded, &(most + ": name a tolerance_m")));
            }
        }
        Ok(Self { centers, balls, evaluations: evaluations(&run) })
    }

    fn apart<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = f64> + 'a {
        self.centers.iter().zip(&other.centers).map(|(a, b)| (a - b).norm())
    }

    /// The first tick at which a ball is farther than `limit` from where it is in another run.
    fn parting(&self, other: &Self, limit: f64) -> Option<usize> {
        self.apart(other).position(|distance| distance > limit).map(|place| place / self.balls + 1)
    }

    fn distance(&self, other: &Self) -> f64 {
        self.apart(other).fold(0.0, f64::max)
    }
}

fn refuse(loaded: &LoadedScene, message: &str) -> SceneError {
    loaded.source().error("accuracy.error_m", message.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_file::SceneText;
    use protocol::scene::Accuracy as Asks;

    fn load(scene: &str, error_m: f64) -> Result<LoadedScene, SceneError> {
        SceneText::open(scene).unwrap().with_accuracy(Some(Asks::Error { error_m })).load()
    }

    #[test]
    fn a_smaller_error_costs_more_and_is_kept() {
        let [coarse, fine] = [1e-5, 1e-9].map(|error_m| load("trough", error_m).unwrap());
        let [less, more] = [&coarse, &fine].map(|loaded| loaded.rehearsed().unwrap());
        assert!(
            less.evaluations < more.evaluations && more.reached_m < 1e-3 * less.reached_m,
            "{less:?} {more:?}"
        );
        assert_eq!(fine.asked_error_m(), Some(1e-9));
        assert_eq!(fine.physics().accuracy, Accuracy::Tolerance(more.tolerance_m));
        assert_eq!(fine.scene().accuracy, Asks::Tolerance { tolerance_m: more.tolerance_m });
    }

    #[test]
    fn where_nothing_is_integrated_the_largest_tolerance_will_do() {
        let found = load("cradle", 1e-11).unwrap().rehearsed().unwrap();
        assert_eq!((found.tolerance_m, found.evaluations, found.reached_m), (tolerance(MOST), 0.0, 0.0));
    }

    #[test]
    fn what_no_tolerance_keeps_is_refused_with_the_time_that_it_is_kept_for() {
        let why = load("original", 1e-11).unwrap_err();
        assert_eq!(why.field, "accuracy.error_m");
        assert!(why.message.contains("no tolerance surely keeps it for longer than"), "{why}");
        let gas = SceneText::open("gas").unwrap().with_balls(Some(50));
        let many = gas.with_accuracy(Some(Asks::Error { error_m: 1e-3 })).load().unwrap_err();
        assert!(many.message.contains("no tolerance surely keeps it"), "{many}");
    }

    #[test]
    fn what_takes_too_long_to_rehearse_is_refused() {
        let work = load("thousand", 1e-6).unwrap_err();
        assert!(work.message.contains("more than 4194304 steps and searches"), "{work}");
        let scene = SceneText::open("gas").unwrap().with_balls(Some(BALLS as u32 + 1));
        let why = scene.with_accuracy(Some(Asks::Error { error_m: 1e-3 })).load().unwrap_err();
        assert!(why.message.contains("at most 1000 balls"), "{why}");
    }
}
