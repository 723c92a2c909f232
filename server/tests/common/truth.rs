//! How far a run of a scene is from where its balls truly are.

use ballroom_physics::{Accuracy, Controller, Scene, Scheme, Time};

const RATE_HZ: u32 = 60;
/// What is true: steps of fixed length, far more exact than any error asked for here, and of another sequence than any tolerance
/// gives.
const TRUE: Accuracy = Accuracy::Fixed(Scheme::Dop853, 1.0 / 300.0);

/// Largest distance of a ball from where it truly is, over all ticks of 10 s, m, and the hits until then.
pub fn error(scene: &Scene, accuracy: Accuracy) -> (f64, u64) {
    let run = |accuracy| Controller::new(&Scene { accuracy, ..scene.clone() }).expect("a loaded scene");
    let (mut run, mut truth) = (run(accuracy), run(TRUE));
    let mut largest = 0.0_f64;
    for tick in 1..=u64::from(10 * RATE_HZ) {
        run.advance_to(Time::of_tick(tick, RATE_HZ));
        truth.advance_to(Time::of_tick(tick, RATE_HZ));
        let apart = run.balls().zip(truth.balls()).map(|(a, b)| (a.center - b.center).norm());
        largest = apart.fold(largest, f64::max);
    }
    let met = run.report().collisions;
    (largest, met.ball_ball + met.ball_wall)
}
