//! Balls set anew between ticks: all of them or none, and the run goes on as if it had been so.

use crate::scenes::{all_bits, center, graph, load, moving, original, plane, run, still};
use ballroom_physics::{Controller, MotionLaw, Scene, Seat, SeatFault, Time};
use nalgebra::{Vector2, Vector3};

fn spot(engine: &Controller, ball: usize, x: f64, y: f64) -> Seat {
    Seat { ball, spot: Some(engine.spot(ball, Vector2::new(x, y)).unwrap()), ..Seat::default() }
}

fn bowl() -> Scene {
    let mut scene = graph(3.0, &[(2, 0, 0.2), (0, 2, 0.25), (3, 1, 0.01)], MotionLaw::Rolling);
    scene.balls = vec![
        moving("a", 0.2, center(-1.0, 0.0), 1.0, 0.5),
        moving("b", 0.25, center(1.0, 0.0), -1.0, 0.2),
        still("c", 0.2, center(0.0, 1.5)),
    ];
    scene
}

#[test]
fn a_ball_set_at_time_zero_runs_as_one_that_the_scene_put_there() {
    let scene = bowl();
    let mut moved = scene.clone();
    moved.balls[0] = moving("a", 0.2, center(0.4, -0.8), -0.3, 0.7);
    moved.balls[0].spin = 5.0;
    let mut engine = load(&scene);
    let seat =
        Seat { velocity: Some(Vector3::new(-0.3, 0.7, 0.0)), spin: Some(5.0), ..spot(&engine, 0, 0.4, -0.8) };
    engine.set_balls(&[seat]).unwrap();
    let mut twin = load(&moved);
    for tick in 1..=600 {
        engine.advance_to(Time::of_tick(tick, 60));
        twin.advance_to(Time::of_tick(tick, 60));
        assert_eq!(all_bits(&engine), all_bits(&twin), "tick {tick}");
    }
    assert!(twin.report().collisions.ball_ball > 0);
}

#[test]
fn energy_put_in_by_setting_balls_is_steering_work() {
    let mut engine = load(&bowl());
    let start = engine.energy();
    for tick in 1..=900 {
        engine.advance_to(Time::of_tick(tick, 60));
        if tick % 100 == 0 {
            let side = if tick % 200 == 0 { 1.0 } else { -1.0 };
            let seat = Seat {
                velocity: Some(Vector3::new(0.5, side, 0.0)),
                spin: Some(3.0 * side),
                ..spot(&engine, 2, 2.0 * side, -1.9)
            };
            engine.set_balls(&[seat]).unwrap();
        }
        let error = engine.energy() - engine.steering_work() - start;
        assert!(error.abs() < 1e-9 * start.abs(), "tick {tick}: {error} J of {start}");
    }
    assert!(engine.report().collisions.ball_ball > 0);
}

#[test]
fn balls_trade_places_at_once_and_none_is_moved_when_one_cannot() {
    let mut engine = load(&bowl());
    engine.advance_to(Time::of_tick(30, 60));
    let [a, b] = [0, 1].map(|ball| engine.ball(ball).center);
    let (before, hash) = (all_bits(&engine), engine.state_hash());
    let swap = [spot(&engine, 1, a.x, a.y), spot(&engine, 0, b.x, b.y)];
    assert!(matches!(engine.set_balls(&swap[..1]), Err(SeatFault::Overlap { ball: 1, other: 0, .. })));
    let into_the_wall = [swap[0], swap[1], spot(&engine, 2, 2.82, 0.0)];
    assert!(matches!(engine.set_balls(&into_the_wall), Err(SeatFault::InWall { ball: 2, .. })));
    assert_eq!(engine.set_balls(&[swap[0], swap[0]]), Err(SeatFault::Twice { ball: 1 }));
    let nan = Seat { ball: 0, velocity: Some(Vector3::repeat(f64::NAN)), ..Seat::default() };
    assert_eq!(engine.set_balls(&[nan]), Err(SeatFault::Number { ball: 0 }));
    let ghost = Seat { ball: 3, ..Seat::default() };
    assert_eq!(engine.set_balls(&[ghost]), Err(SeatFault::Stranger { ball: 3 }));
    assert!(matches!(engine.spot(0, Vector2::new(4.0, 0.0)), Err(SeatFault::OffFloor { ball: 0, .. })));
    assert_eq!((all_bits(&engine), engine.state_hash()), (before, hash), "a refusal left a trace");
    engine.set_balls(&swap).unwrap();
    let [a_now, b_now] = [0, 1].map(|ball| engine.ball(ball).center);
    assert!((a_now - b).xy().norm() < 1e-12 && (b_now - a).xy().norm() < 1e-12);
}

#[test]
fn a_spot_of_another_floor_and_the_spin_of_a_sliding_ball_are_refused() {
    let mut engine = load(&bowl());
    let mut other = plane(30.0);
    other.balls = vec![still("a", 0.2, center(0.0, 0.0))];
    let mut flat = load(&other);
    let seat = spot(&flat, 0, 1.0, 1.0);
    assert_eq!(engine.set_balls(&[seat]), Err(SeatFault::Stranger { ball: 0 }));
    other.motion = MotionLaw::Frictionless;
    flat = load(&other);
    let spin = Seat { ball: 0, spin: Some(1.0), ..Seat::default() };
    assert_eq!(flat.set_balls(&[spin]), Err(SeatFault::Slides { ball: 0 }));
}

#[test]
fn a_set_ball_meets_those_in_its_new_way_and_no_longer_those_in_its_old_one() {
    let mut scene = plane(10.0);
    scene.balls = vec![
        moving("a", 0.5, center(-4.0, 0.0), 2.0, 0.0),
        still("b", 0.5, center(0.0, 0.0)),
        still("c", 0.5, center(0.0, 4.0)),
    ];
    let mut engine = load(&scene);
    engine.set_balls(&[spot(&engine, 0, -4.0, 4.0)]).unwrap();
    engine.advance_to(Time::of_seconds(2.0));
    let [a, b, c] = [0, 1, 2].map(|ball| engine.ball(ball));
    // Centres meet at x = -1 after 1.5 s; half a second later the struck ball is a metre on.
    assert!((c.center.x - 1.0).abs() < 1e-12 && (a.center.x + 1.0).abs() < 1e-12, "{a:?} {c:?}");
    assert_eq!(b.center.xy(), Vector2::zeros());
    assert_eq!(engine.report().collisions.ball_ball, 1);
}

#[test]
fn setting_balls_is_the_same_at_any_tick_rate_and_after_a_checkpoint() {
    let half = |engine: &mut Controller| {
        let seat = Seat { velocity: Some(Vector3::new(0.3, -2.0, 0.0)), ..spot(engine, 2, 6.0, -6.0) };
        engine.set_balls(&[seat]).unwrap();
    };
    let hashes = [30_u32, 60, 240].map(|rate| {
        let mut engine = run(&original(), rate, u64::from(rate), |_, _| {});
        half(&mut engine);
        let mut restored = load(&original());
        restored.restore(&engine.checkpoint()).unwrap();
        for tick in u64::from(rate) + 1..=20 * u64::from(rate) {
            engine.advance_to(Time::of_tick(tick, rate));
            restored.advance_to(Time::of_tick(tick, rate));
        }
        assert_eq!(engine.state_hash(), restored.state_hash());
        engine.state_hash()
    });
    assert_eq!(hashes, [hashes[0]; 3]);
}

#[test]
fn setting_all_as_at_the_start_keeps_the_clock_and_the_books() {
    let scene = bowl();
    let start = load(&scene);
    let mut engine = run(&scene, 60, 120, |_, _| {});
    engine.set_as_in(&start).unwrap();
    assert_eq!(engine.time(), Time::of_tick(120, 60));
    for (now, then) in engine.balls().zip(start.balls()) {
        assert_eq!(
            (now.center, now.velocity, now.orientation),
            (then.center, then.velocity, then.orientation)
        );
    }
    assert!((engine.energy() - start.energy()).abs() < 1e-12 * start.energy());
    assert!(engine.steering_work().abs() < 1e-9 * start.energy());
}

#[test]
fn the_clock_goes_back_to_zero_under_the_balls() {
    let scene = bowl();
    let start = load(&scene);
    let engine = run(&scene, 60, 90, |_, _| {});
    let fresh = engine.at_time_zero(&start);
    assert_eq!((fresh.time(), fresh.steering_work()), (Time::ZERO, 0.0));
    for (now, then) in fresh.balls().zip(engine.balls()) {
        assert!((now.center - then.center).norm() < 1e-11 && (now.velocity - then.velocity).norm() < 1e-10);
    }
}
