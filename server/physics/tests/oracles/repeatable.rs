//! Runs repeat bit for bit, for an hour of the scene of the program this one grew out of.

use crate::scenes::{all_bits, in_list_order, original, run};
use ballroom_physics::Scene;

const HOUR_S: u64 = 3600;

/// The hash at every tick of 30 Hz, and every bit at every second.
fn trace(scene: &Scene, rate_hz: u32) -> (Vec<u64>, Vec<Vec<u64>>) {
    let (mut hashes, mut states) = (vec![], vec![]);
    let common = u64::from(rate_hz / 30);
    run(scene, rate_hz, HOUR_S * u64::from(rate_hz), |tick, engine| {
        if tick % common == 0 {
            hashes.push(engine.state_hash());
        }
        if tick % u64::from(rate_hz) == 0 {
            states.push(all_bits(engine));
        }
    });
    (hashes, states)
}

#[test]
fn an_hour_is_the_same_twice_at_every_tick_rate_and_in_any_order_of_the_list() {
    let first = trace(&original(), 60);
    assert_eq!(first.0.len(), 108_001);
    assert!(first == trace(&original(), 60), "a second run differs");
    assert!(first == trace(&original(), 30), "30 Hz differs");
    assert!(first == trace(&original(), 240), "240 Hz differs");
    let mut permuted = original();
    permuted.balls.rotate_left(1);
    permuted.balls.swap(0, 1);
    assert!(first == trace(&permuted, 60), "a permuted list differs");
    assert!(first.0[1..].iter().any(|hash| *hash != first.0[0]), "the hash sees nothing");
}

#[test]
fn an_hour_loses_no_ball_and_no_energy() {
    let scene = original();
    let mut start = None;
    let mut worst = [0.0_f64; 2];
    let engine = run(&scene, 60, HOUR_S * 60, |tick, engine| {
        let energy = engine.energy();
        let start = *start.get_or_insert(energy);
        worst[0] = worst[0].max((energy / start - 1.0).abs());
        for (ball, spec) in in_list_order(engine).iter().zip(&scene.balls) {
            let reach = ball.center.x.abs().max(ball.center.y.abs()) + spec.radius - 10.0;
            worst[1] = worst[1].max(reach);
            assert!(ball.center.iter().all(|x| x.is_finite()) && reach < 1e-9, "tick {tick}: {ball:?}");
        }
    });
    assert!(worst[0] < 1e-10, "relative energy error {}", worst[0]);
    let report = engine.report();
    assert!(report.collisions.ball_ball > 100 && report.collisions.ball_wall > 1000, "{report:?}");
    assert!(report.deepest_penetration < 1e-9 && report.fallbacks == 0, "{report:?}");
}
