//! A tick allocates nothing once the first second has sized the buffers.

use crate::scenes::{cloud, graph, load};
use ballroom_physics::{Accuracy, MotionLaw, Time};

#[test]
fn an_advance_allocates_nothing_after_the_first_second() {
    let mut scene = graph(4.0, &[(2, 0, 0.05), (0, 2, 0.05)], MotionLaw::Rolling);
    scene.accuracy = Accuracy::Tolerance(1e-9);
    scene.balls = cloud(100, [0.05, 0.12], 2.4, 1.0, 5);
    let mut engine = load(&scene);
    for tick in 1..=60 {
        engine.advance_to(Time::of_tick(tick, 60));
    }
    let before = engine.report().collisions.ball_ball;
    let info = allocation_counter::measure(|| {
        for tick in 61..=600 {
            engine.advance_to(Time::of_tick(tick, 60));
        }
    });
    let hits = engine.report().collisions.ball_ball - before;
    assert!(hits > 500, "{hits}");
    assert_eq!(info.count_total, 0, "{info:?} in {hits} hits");
}
