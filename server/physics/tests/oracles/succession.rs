//! A run goes on with other balls, on another floor, under other laws: who is not concerned keeps every bit, and the
//! books balance.

use crate::scenes::{
    all_bits, as_net, bits, center, cloud, graph, load, moving, original, pit_floor, plane, run, still,
};
use ballroom_physics::surface::bezier::BezierPatch;
use ballroom_physics::{
    Accuracy, BallSpec, CheckpointFault, Controller, Drive, Floor, MotionLaw, Place, Scene, SceneFault,
    SeatFault, Successor, Time,
};
use nalgebra::{Vector2, Vector3};
use std::time::Instant;

const RATE_HZ: u32 = 60;

/// What a run of `was` can go on as: balls of one name are one ball.
fn successor(was: &Scene, scene: &Scene) -> Result<Successor, SceneFault> {
    let kept: Vec<_> =
        scene.balls.iter().map(|ball| was.balls.iter().position(|b| b.name == ball.name)).collect();
    load(was).successor(was, scene, &kept)
}

fn with(scene: &Scene, ball: BallSpec) -> Scene {
    let mut scene = scene.clone();
    scene.balls.push(ball);
    scene
}

/// Sixty balls on bumps, far from the borders.
fn crowd() -> Scene {
    let bumps = [(2, 0, 0.2), (0, 2, 0.25), (3, 1, 0.01), (1, 2, -0.02)];
    let scene = graph(3.0, &bumps, MotionLaw::Rolling);
    Scene { balls: cloud(60, [0.05, 0.12], 1.8, 1.0, 3), ..scene }
}

/// The crowd in a pit, and a ball that stands in the far corner of the hall, at rest but for its spin.
fn aside(scene: &Scene) -> (Scene, BallSpec) {
    let mut scene = scene.clone();
    scene.floor = pit_floor(false);
    scene.walls = crate::scenes::walls([-10.0, 10.0], [-10.0, 10.0]);
    for ball in &mut scene.balls {
        if let Place::Contact(xy) | Place::Center(xy) = &mut ball.place {
            xy.x -= 4.0;
        }
    }
    let ball = BallSpec { spin: 3.0, ..still("ball-030-aside", 0.1, center(9.5, 9.5)) };
    (scene, ball)
}

fn tick(engine: &mut Controller, tick: u64) {
    match tick % 50 {
        7 => engine.push(0, Vector2::new(-0.3, 0.2), 5.0),
        20 => engine.drive(1, Some(Drive { direction: Vector2::x(), acceleration: 1.0, speed_limit: 1.5 })),
        43 => engine.drive(1, None),
        _ => {}
    }
    engine.advance_to(Time::of_tick(tick + 1, RATE_HZ));
}

/// The bits of a scene's balls but one, by name.
fn without(engine: &Controller, scene: &Scene, name: &str) -> Vec<Vec<u64>> {
    let names = engine.scene_index().iter().map(|place| &scene.balls[*place].name);
    let others = names.zip(engine.balls()).filter(|(known, _)| *known != name);
    others.map(|(_, ball)| bits(ball)).collect()
}

#[test]
fn a_ball_that_comes_and_goes_and_meets_nobody_changes_no_bit_of_the_others() {
    let (scene, comer) = aside(&crowd());
    let wider = with(&scene, comer.clone());
    let mut engine = load(&scene);
    let mut twin = load(&scene);
    let (mut comes, mut goes) = (successor(&scene, &wider).unwrap(), successor(&wider, &scene).unwrap());
    let mut hits = 0;
    for t in 0..600 {
        if t == 100 {
            assert_eq!(engine.go_on_as(&mut comes), Ok(0));
            assert_eq!(engine.balls().len(), 61);
        }
        if t == 400 {
            assert_eq!(engine.go_on_as(&mut goes), Ok(0));
        }
        tick(&mut engine, t);
        tick(&mut twin, t);
        let known = if (100..400).contains(&t) { &wider } else { &scene };
        assert_eq!(without(&engine, known, &comer.name), without(&twin, &scene, ""), "tick {t}");
        hits += twin.hits().len();
    }
    assert_eq!(engine.state_hash(), twin.state_hash(), "as if it had never been");
    assert_eq!(engine.checkpoint().words().len(), twin.checkpoint().words().len());
    assert!(hits > 100, "{hits} hits put it to the test");
    assert!(engine.steering_work().abs() > 0.0);
}

#[test]
fn a_ball_that_comes_at_time_zero_is_as_one_of_the_scene() {
    let scene = crowd();
    let whole = with(&scene, moving("ball-030-late", 0.1, center(-2.2, 2.3), 1.0, -1.2));
    let mut engine = load(&scene);
    engine.go_on_as(&mut successor(&scene, &whole).unwrap()).unwrap();
    let mut twin = load(&whole);
    let start = twin.energy();
    assert!((engine.steering_work() - (start - load(&scene).energy())).abs() < 1e-12 * start);
    for t in 0..600 {
        tick(&mut engine, t);
        tick(&mut twin, t);
        assert_eq!(all_bits(&engine), all_bits(&twin), "tick {t}");
        assert_eq!(engine.state_hash(), twin.state_hash(), "tick {t}");
    }
    let late = engine.scene_index().iter().position(|place| *place == 60).unwrap();
    assert!(engine.balls()[late].velocity.norm() > 0.0 && twin.report().collisions.ball_ball > 100);
}

#[test]
fn a_ball_without_room_is_refused_and_the_run_goes_on_as_if_nobody_had_asked() {
    let scene = crowd();
    let mut engine = run(&scene, RATE_HZ, 90, |_, _| {});
    let (before, hash) = (all_bits(&engine), engine.state_hash());
    let there = engine.balls()[17].center;
    let mut try_at = |x: f64, y: f64| {
        let wider = with(&scene, still("comer", 0.1, center(x, y)));
        engine.go_on_as(&mut successor(&scene, &wider).unwrap())
    };
    // Where one is now, not where it was at the start; and in a wall.
    let overlap = try_at(there.x + 0.05, there.y);
    assert!(matches!(overlap, Err(SeatFault::Overlap { ball: 60, other: 17, .. })), "{overlap:?}");
    assert!(matches!(try_at(2.91, 0.0), Err(SeatFault::InWall { ball: 60, .. })));
    assert_eq!((all_bits(&engine), engine.state_hash()), (before, hash), "a refusal left a trace");
    let off = successor(&scene, &with(&scene, still("comer", 0.1, center(4.0, 0.0))));
    assert!(matches!(off, Err(SceneFault::OffFloor { ball: 60, .. })));
    let same = successor(&scene, &with(&scene, still("ball-017", 0.1, center(2.5, 2.5))));
    assert!(matches!(same, Err(SceneFault::SameName { .. })));
    let large = successor(&scene, &with(&scene, still("comer", 2.6, center(0.0, 0.0)))).err();
    assert!(matches!(large, Some(SceneFault::TooCurved { ball: 60, .. })), "{large:?}");
}

#[test]
fn who_was_about_to_meet_one_that_leaves_goes_on_freely() {
    let mut scene = plane(10.0);
    scene.balls = vec![moving("a", 0.5, center(-4.0, 0.0), 2.0, 0.0), still("b", 0.5, center(0.0, 0.0))];
    let mut alone = scene.clone();
    alone.balls.pop();
    let mut engine = load(&scene);
    engine.advance_to(Time::of_seconds(1.0));
    engine.go_on_as(&mut successor(&scene, &alone).unwrap()).unwrap();
    engine.advance_to(Time::of_seconds(2.0));
    assert!((engine.balls()[0].center.x).abs() < 1e-12, "{:?}", engine.balls());
    assert_eq!(engine.report().collisions.ball_ball, 0);
    // And the last may leave too.
    let empty = Scene { balls: vec![], ..alone.clone() };
    engine.go_on_as(&mut successor(&alone, &empty).unwrap()).unwrap();
    engine.advance_to(Time::of_seconds(3.0));
    assert!(engine.balls().is_empty() && engine.energy() == 0.0);
}

/// A floor with one control point raised.
fn raised(scene: &Scene, by: f64) -> Scene {
    let Floor::Bezier(patch) = &scene.floor else { panic!("the scene has no net") };
    let mut net = patch.net().to_vec();
    net[patch.net().len() / 2].z += by;
    Scene { floor: Floor::Bezier(BezierPatch::new(patch.degree(), net).unwrap()), ..scene.clone() }
}

#[test]
fn the_books_balance_over_balls_floors_and_laws_that_come_and_go() {
    let first = as_net(&Scene { balls: cloud(20, [0.05, 0.12], 1.8, 1.0, 3), ..crowd() });
    let spawned = with(&first, moving("comer", 0.1, center(2.5, 2.5), 0.0, -1.0));
    let moved = raised(&spawned, 0.1);
    let lighter = Scene { gravity: Vector3::new(0.5, 0.0, -4.0), ..moved.clone() };
    let finer = Scene { accuracy: Accuracy::Tolerance(1e-13), ..lighter.clone() };
    let fewer = Scene { balls: finer.balls[5..].to_vec(), ..finer.clone() };
    let mut engine = load(&first);
    let start = engine.energy();
    let mut t = 0;
    for pair in [first, spawned, moved, lighter, finer, fewer].windows(2) {
        for _ in 0..95 {
            tick(&mut engine, t);
            t += 1;
            let error = engine.energy() - engine.steering_work() - start;
            assert!(error.abs() < 1e-9 * start.abs(), "tick {t}: {error} J of {start}");
        }
        engine.go_on_as(&mut successor(&pair[0], &pair[1]).unwrap()).unwrap();
        let error = engine.energy() - engine.steering_work() - start;
        assert!(error.abs() < 1e-9 * start.abs(), "after tick {t}: {error} J of {start}");
    }
    assert!(engine.report().collisions.ball_ball > 20);
}

#[test]
fn balls_keep_x_y_spin_and_orientation_when_the_floor_moves_under_them() {
    // Few enough that no two stand so close that a flatter place makes them overlap.
    let scene = as_net(&Scene { balls: cloud(20, [0.05, 0.12], 1.8, 1.0, 3), ..crowd() });
    let moved = raised(&scene, 0.3);
    let mut engine = run(&scene, RATE_HZ, 120, |_, _| {});
    let before = engine.balls().to_vec();
    assert_eq!(engine.go_on_as(&mut successor(&scene, &moved).unwrap()), Ok(0));
    for (now, then) in engine.balls().iter().zip(&before) {
        assert!((now.center - then.center).xy().norm() < 1e-11, "{now:?} {then:?}");
        let w = then.velocity - now.normal * then.velocity.dot(&now.normal);
        assert!((now.velocity - w).norm() < 1e-11);
        let spins = [now, then].map(|ball| ball.omega.dot(&ball.normal));
        assert!((spins[0] - spins[1]).abs() < 1e-10 && now.orientation == then.orientation);
        let foot = engine.patch().jet(now.uv.x, now.uv.y).point;
        assert!(((now.center - foot).normalize() - now.normal).norm() < 1e-9, "it lies on the new floor");
    }
    // Back again, the floor is the former one to the bit, and goes on like it.
    assert_eq!(engine.go_on_as(&mut successor(&moved, &scene).unwrap()), Ok(0));
    assert_eq!(engine.patch().net(), load(&scene).patch().net());
    let folded = successor(&scene, &raised(&scene, 1000.0)).err();
    assert!(matches!(folded, Some(SceneFault::TooCurved { .. })), "{folded:?}");
}

#[test]
fn a_floor_that_rises_into_a_wall_of_balls_is_refused_as_a_whole() {
    let mut scene = as_net(&graph(3.0, &[(2, 0, 0.1), (0, 2, 0.1)], MotionLaw::Rolling));
    // Two that touch on a slope come nearer, seen in space, when it levels.
    scene.balls = vec![still("a", 0.4, center(-0.4, 0.0)), still("b", 0.4, center(0.4, 0.0))];
    let steep = as_net(&graph(3.0, &[(1, 0, 0.5), (2, 0, 0.1), (0, 2, 0.1)], MotionLaw::Rolling));
    let slope = Scene { balls: scene.balls.clone(), ..steep };
    let mut engine = load(&scene);
    engine.go_on_as(&mut successor(&scene, &slope).unwrap()).unwrap();
    let near = Scene {
        balls: vec![still("a", 0.4, center(-0.37, 0.0)), still("b", 0.4, center(0.37, 0.0))],
        ..slope
    };
    let mut engine = load(&near);
    let hash = engine.state_hash();
    let level = Scene { balls: near.balls.clone(), ..scene };
    let refused = engine.go_on_as(&mut successor(&near, &level).unwrap());
    assert!(matches!(refused, Err(SeatFault::Overlap { ball: 0, other: 1, .. })), "{refused:?}");
    assert_eq!(engine.state_hash(), hash);
}

#[test]
fn other_laws_of_hits_change_no_bit_until_the_next_hit() {
    let scene = original();
    let softer = Scene { restitution: 0.5, hit_budget: 1000, ..scene.clone() };
    let (mut engine, mut twin) = (load(&scene), load(&scene));
    engine.go_on_as(&mut successor(&scene, &softer).unwrap()).unwrap();
    let mut same = 0;
    for t in 1..=600 {
        engine.advance_to(Time::of_tick(t, RATE_HZ));
        twin.advance_to(Time::of_tick(t, RATE_HZ));
        if twin.report().collisions == ballroom_physics::Collisions::default() {
            assert_eq!(all_bits(&engine), all_bits(&twin));
            same = t;
        }
    }
    assert!(same > 20 && engine.energy() < twin.energy() - 1.0);
}

#[test]
fn a_checkpoint_belongs_to_the_balls_that_are_there() {
    let scene = crowd();
    let wider = with(&scene, moving("ball-030-late", 0.1, center(-2.2, 2.3), 1.0, -1.2));
    let mut engine = run(&scene, RATE_HZ, 60, |_, _| {});
    let mut next = successor(&scene, &wider).unwrap();
    let mut restored = next.at_start().clone();
    engine.go_on_as(&mut next).unwrap();
    assert_eq!(load(&scene).restore(&engine.checkpoint()), Err(CheckpointFault::Scene));
    restored.restore(&engine.checkpoint()).unwrap();
    for t in 60..360 {
        tick(&mut engine, t);
        tick(&mut restored, t);
        assert_eq!(engine.state_hash(), restored.state_hash(), "tick {t}");
    }
    assert_eq!(engine.checkpoint(), restored.checkpoint());
}

#[test]
fn all_return_to_their_start_only_where_there_is_room() {
    let mut scene = plane(10.0);
    scene.balls = vec![moving("a", 0.5, center(-4.0, 0.0), 2.0, 0.0)];
    let wider = with(&scene, still("b", 0.5, center(-4.0, 0.0)));
    let mut engine = load(&scene);
    engine.advance_to(Time::of_seconds(2.0));
    let mut next = successor(&scene, &wider).unwrap();
    let start = next.at_start().clone();
    engine.go_on_as(&mut next).unwrap();
    let hash = engine.state_hash();
    assert!(matches!(engine.set_as_in(&start), Err(SeatFault::Overlap { ball: 0, other: 1, .. })));
    assert_eq!(engine.state_hash(), hash);
}

#[test]
fn one_ball_more_among_ten_thousand_is_a_copy_and_no_look_ahead_of_all() {
    let scene = Scene { balls: vec![], ..plane(200.0) };
    let ball = |i: u32| {
        let place = center(f64::from(i % 100) * 3.0 - 150.0, f64::from(i / 100) * 3.0 - 150.0);
        moving(&format!("ball-{i:05}"), 0.5, place, f64::from(i % 7) - 3.0, f64::from(i % 5) - 2.0)
    };
    let scene = Scene { balls: (0..10_000).map(ball).collect(), ..scene };
    let wider = with(&scene, still("comer", 0.5, center(180.0, 180.0)));
    let kept: Vec<_> = (0..10_001).map(|i| (i < 10_000).then_some(i)).collect();
    let mut engine = load(&scene);
    engine.advance_to(Time::of_seconds(1.0));
    let began = Instant::now();
    let mut next = engine.successor(&scene, &wider, &kept).unwrap();
    let (prepared, before) = (began.elapsed(), engine.report());
    let began = Instant::now();
    engine.go_on_as(&mut next).unwrap();
    println!("made ready in {prepared:?}, gone over to in {:?}", began.elapsed());
    let looked = engine.report().since(&before);
    assert!(looked.pairs[0] < 100 && looked.steps == 0, "{looked:?}");
}
