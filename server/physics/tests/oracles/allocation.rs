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

/// What a thousand more balls cost, everything included: printed by `-- --nocapture`.
#[test]
fn a_ball_takes_less_than_two_kilobytes() {
    let bytes = |count| {
        let mut scene = graph(8.0, &[(2, 0, 0.02), (0, 2, 0.02)], MotionLaw::Rolling);
        scene.balls = cloud(count, [0.05, 0.05], 6.0, 1.0, 5);
        let mut engine = None;
        let info = allocation_counter::measure(|| engine = Some(load(&scene)));
        assert!(engine.is_some());
        info.bytes_current
    };
    // Both are powers of two, as queue and grid are.
    let each = (bytes(2048) - bytes(1024)) / 1024;
    println!("{each} bytes a ball");
    assert!(each < 2048, "{each} bytes a ball");
}
