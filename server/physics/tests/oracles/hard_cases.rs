//! Impacts whose outcome is known exactly.

use crate::scenes::{self, assert_mirrors, center, graph, load, moving, plane, rods, run, still};
use ballroom_physics::{BallSpec, Controller, MotionLaw, Scene};
use nalgebra::Vector3;

fn hits(engine: &Controller) -> u64 {
    let collisions = engine.report().collisions;
    collisions.ball_ball + collisions.ball_wall
}

/// Five touching balls, `swung` of them a metre to the left with speed 2.
fn cradle(swung: usize, motion: MotionLaw) -> Scene {
    let mut scene = graph(32.0, &[], motion);
    for n in 0..5 {
        let place = n as f64 - if n < swung { 1.0 } else { 0.0 };
        let speed = if n < swung { 2.0 } else { 0.0 };
        scene.balls.push(moving(&format!("{n}"), 0.5, center(place, 0.0), speed, 0.0));
    }
    scene
}

#[test]
fn touching_balls_at_rest_stay_at_rest() {
    let mut scene = cradle(0, MotionLaw::Rolling);
    scene.balls.push(still("above", 0.5, center(0.5, 0.75_f64.sqrt())));
    let start = scenes::all_bits(&load(&scene));
    let engine = run(&scene, 1, 600, |_, _| {});
    assert_eq!(scenes::all_bits(&engine), start);
    assert_eq!(hits(&engine), 0);
}

#[test]
fn a_ball_onto_two_touching_ones_comes_back_with_a_fifth() {
    for motion in [MotionLaw::Frictionless, MotionLaw::Rolling] {
        let mut scene = graph(32.0, &[], motion);
        let v = 3.0;
        scene.balls = vec![
            moving("0", 0.5, center(-2.0, 0.0), v, 0.0),
            still("1", 0.5, center(0.0, -0.5)),
            still("2", 0.5, center(0.0, 0.5)),
        ];
        let hit = (2.0 - 0.75_f64.sqrt()) / v;
        let out = 2.0 * 3.0_f64.sqrt() / 5.0 * v;
        run(&scene, 60, 240, |tick, engine| {
            let t = tick as f64 / 60.0;
            let after = (t - hit).max(0.0);
            let aside = out * 0.5 * after;
            let along = out * 0.75_f64.sqrt() * after;
            let first = -2.0 + v * t.min(hit) - v / 5.0 * after;
            let exact = [[first, 0.0], [along, -0.5 - aside], [along, 0.5 + aside]];
            for (ball, [x, y]) in engine.balls().iter().zip(exact) {
                let error = (ball.center - Vector3::new(x, y, 0.5)).norm();
                assert!(error < 1e-12, "tick {tick}: {error}");
            }
        });
    }
}

/// Fifteen touching balls in a triangle and one that comes along its axis, y.
fn rack(half: f64) -> Scene {
    let mut scene = graph(half, &[], MotionLaw::Rolling);
    for row in 0..5 {
        for place in 0..=row {
            let x = f64::from(place) - 0.5 * f64::from(row);
            let y = f64::from(row) * 0.75_f64.sqrt();
            scene.balls.push(still(&format!("{row}{place}"), 0.5, center(x, y)));
        }
    }
    scene.balls.push(moving("cue", 0.5, center(0.0, -3.0), 0.0, 9.0));
    scene
}

#[test]
fn a_break_is_mirrored_bit_for_bit() {
    assert_mirrors(&rack(12.0), 60, 300);
    let mut aside = rack(12.0);
    aside.balls[15].place = center(0.3, -3.0);
    assert_mirrors(&aside, 60, 300);
}

#[test]
fn a_break_along_the_axis_keeps_the_triangle_s_symmetry() {
    // Before the first walls are reached; later the break is chaotic and rounding grows.
    run(&rack(64.0), 60, 120, |tick, engine| {
        let balls = scenes::in_list_order(engine);
        for row in 0..5_usize {
            for place in 0..=row {
                let first = row * (row + 1) / 2;
                let image = scenes::mirrored_state(&balls[first + row - place]);
                let error = (balls[first + place].center - image.center).norm();
                assert!(error < 1e-12, "ball {row}{place}, tick {tick}: {error}");
            }
        }
        assert!(balls[15].center.x.abs() < 1e-12);
    });
}

#[test]
fn a_break_on_a_curved_floor_is_mirrored_bit_for_bit() {
    let mut scene = graph(8.0, &[(2, 0, 0.03), (0, 2, 0.02), (1, 1, 0.01)], MotionLaw::Rolling);
    scene.balls = scenes::cloud(12, [0.2, 0.4], 4.0, 2.0, 7);
    assert_mirrors(&scene, 60, 300);
    assert_mirrors(&scenes::original(), 60, 600);
}

#[test]
fn a_bullet_of_a_thousand_diameters_a_tick_hits_every_time() {
    let mut scene = plane(16.0);
    scene.walls = scenes::walls([-8.0, 8.0], [-8.0, 8.0]);
    let radius = 1.0 / 64.0;
    let speed = 1000.0 * 2.0 * radius * 60.0;
    let starts = [(-3.0, speed), (2.5, 0.0)];
    scene.balls = starts
        .iter()
        .enumerate()
        .map(|(n, (x, v))| moving(&format!("{n}"), radius, center(*x, 0.0), *v, 0.0))
        .collect();
    let mut worst = 0.0_f64;
    let engine = run(&scene, 60, 60, |tick, engine| {
        let exact = rods(&starts, radius, [-8.0, 8.0], tick as f64 / 60.0);
        for (ball, x) in engine.balls().iter().zip(exact) {
            worst = worst.max((ball.center - Vector3::new(x, 0.0, radius)).norm());
        }
    });
    assert!(worst < 1e-12, "{worst}");
    assert!(hits(&engine) > 200, "{}", hits(&engine));
}

#[test]
fn chains_of_balls_with_gaps_are_exact() {
    let mut scene = plane(16.0);
    let radius = 0.25;
    let starts = [(-9.0, 5.0), (-3.0, 0.0), (-1.5, -1.0), (0.5, 0.25), (4.0, -3.0)];
    scene.balls = starts
        .iter()
        .enumerate()
        .map(|(n, (x, v))| moving(&format!("{n}"), radius, center(*x, 0.0), *v, 0.0))
        .collect();
    let mut worst = 0.0_f64;
    let engine = run(&scene, 60, 1200, |tick, engine| {
        let exact = rods(&starts, radius, [-16.0, 16.0], tick as f64 / 60.0);
        for (ball, x) in engine.balls().iter().zip(exact) {
            worst = worst.max((ball.center - Vector3::new(x, 0.0, radius)).norm());
        }
    });
    assert!(worst < 1e-12, "{worst}");
    assert!(hits(&engine) > 20);
}

#[test]
fn touching_balls_that_move_together_but_for_rounding_go_on_together() {
    for noise in [0.0, 1e-15, -1e-15, 1e-13, 1e-9] {
        let mut scene = plane(32.0);
        for (n, excess) in [noise, 0.0, -noise].into_iter().enumerate() {
            scene.balls.push(moving(&format!("{n}"), 0.5, center(n as f64, 0.0), 2.0 + excess, 0.0));
        }
        run(&scene, 60, 60, |tick, engine| {
            for (n, ball) in engine.balls().iter().enumerate() {
                let exact = n as f64 + 2.0 * tick as f64 / 60.0;
                let error = (ball.center.x - exact).abs();
                assert!(error < 1e-12 + noise.abs(), "noise {noise}, ball {n}, tick {tick}: {error}");
            }
        });
    }
}

#[test]
fn both_walls_of_a_corner_turn_a_ball_at_one_instant() {
    for motion in [MotionLaw::Frictionless, MotionLaw::Rolling] {
        let mut scene = graph(8.0, &[], motion);
        scene.balls = vec![moving("ball", 0.5, center(4.5, 4.5), 3.0, 3.0)];
        let mut worst = 0.0_f64;
        run(&scene, 60, 1200, |tick, engine| {
            let [x] = rods(&[(4.5, 3.0)], 0.5, [-8.0, 8.0], tick as f64 / 60.0)[..] else { unreachable!() };
            worst = worst.max((engine.balls()[0].center - Vector3::new(x, x, 0.5)).norm());
        });
        assert!(worst < 1e-12, "{motion:?}: {worst}");
    }
}

#[test]
fn a_grazing_ball_hits_or_misses_as_it_should() {
    // A ball passes another at rest at a distance of (1 + margin) diameters.
    for exponent in 3..=14 {
        for sign in [-1.0, 1.0] {
            let margin = sign * 10.0_f64.powi(-exponent);
            for offset in [0.0, 0.123, 0.777] {
                let mut scene = plane(16.0);
                scene.balls = vec![
                    moving("a", 0.5, center(-5.0 + offset, 1.0 + margin), 3.0, 0.0),
                    still("b", 0.5, center(0.0, 0.0)),
                ];
                let engine = run(&scene, 60, 180, |_, _| {});
                assert_eq!(hits(&engine), u64::from(margin < 0.0), "margin {margin}, offset {offset}");
            }
        }
    }
}

#[test]
fn exact_tangency_gives_next_to_no_impulse() {
    let mut scene = plane(16.0);
    scene.balls = vec![moving("a", 0.5, center(-5.0, 1.0), 3.0, 0.0), still("b", 0.5, center(0.0, 0.0))];
    let engine = run(&scene, 60, 180, |_, _| {});
    assert!((engine.balls()[0].velocity - Vector3::new(3.0, 0.0, 0.0)).norm() <= 3e-7);
}

#[test]
fn balls_a_thousandfold_apart_in_size_meet_exactly() {
    let mut scene = plane(16.0);
    let small = BallSpec { mass: 1e-9, ..moving("small", 0.001, center(-6.0, 0.0), 4.0, 0.0) };
    let large = BallSpec { mass: 1.0, ..still("large", 1.0, center(0.0, 0.0)) };
    scene.balls = vec![small, large];
    let engine = run(&scene, 60, 120, |_, _| {});
    let balls = scenes::in_list_order(&engine);
    // The centres lie at heights of their own: they meet when a horizontal leg closes the reach.
    let leg = (1.001_f64 * 1.001 - 0.999 * 0.999).sqrt();
    let hit = (6.0 - leg) / 4.0;
    let [heavy, light] = [1.0, 1e-9];
    let turned = 4.0 * (light - heavy) / (light + heavy);
    let exact = -leg + turned * (2.0 - hit);
    assert!((balls[0].center.x - exact).abs() < 1e-12, "{} for {exact}", balls[0].center.x);
    let pushed = 8.0 * light / (light + heavy) * (2.0 - hit);
    assert!((balls[1].center.x - pushed).abs() < 1e-12);
}

#[test]
fn a_free_group_keeps_its_momentum_at_any_restitution() {
    for (e, count) in [(0.9, 8), (0.5, 5), (0.1, 3), (0.0, 2)] {
        let mut scene = plane(64.0);
        scene.restitution = e;
        scene.balls.push(BallSpec { mass: 1000.0, ..moving("heavy", 0.25, center(2.0, 0.0), -1.0, 0.0) });
        for n in 0..count {
            let place = center(-0.625 * f64::from(n), 0.0);
            scene.balls.push(moving(&format!("light-{n}"), 0.25, place, 2.0, 0.0));
        }
        let exact = 2.0 * f64::from(count) - 1000.0;
        let mut worst = 0.0_f64;
        run(&scene, 60, 600, |_, engine| {
            let balls = scenes::in_list_order(engine);
            let momentum: f64 =
                balls.iter().zip(&scene.balls).map(|(b, spec)| b.velocity.x * spec.mass).sum();
            worst = worst.max((momentum / exact - 1.0).abs());
        });
        assert!(worst < 1e-12, "restitution {e}, {count} light balls: {worst}");
    }
}
