//! Runs repeat bit for bit, for an hour of the scene of the program this one grew out of.

use crate::scenes::{all_bits, in_list_order, original, run};
use ballroom_physics::{Accuracy, Report, Scene};
use std::thread;

const HOUR_S: u64 = 3600;

/// The hour, at a tolerance that leaves its energy ten times closer than claimed.
fn hour() -> Scene {
    Scene { accuracy: Accuracy::Tolerance(1e-11), ..original() }
}

/// What an hour leaves behind.
struct Trace {
    /// The state's hash at every tick of 30 Hz.
    hashes: Vec<u64>,
    /// Every bit at every second.
    states: Vec<Vec<u64>>,
    /// Largest relative error of the energy over all ticks.
    energy_error: f64,
    /// Deepest a ball reached into a wall at any tick, m.
    deepest: f64,
    report: Report,
}

fn trace(scene: &Scene, rate_hz: u32) -> Trace {
    let mut trace = Trace {
        hashes: vec![],
        states: vec![],
        energy_error: 0.0,
        deepest: f64::MIN,
        report: Report::default(),
    };
    let mut start = None;
    let engine = run(scene, rate_hz, HOUR_S * u64::from(rate_hz), |tick, engine| {
        if tick.is_multiple_of(u64::from(rate_hz / 30)) {
            trace.hashes.push(engine.state_hash());
        }
        if tick.is_multiple_of(u64::from(rate_hz)) {
            trace.states.push(all_bits(engine));
        }
        let energy = engine.energy();
        let start = *start.get_or_insert(energy);
        trace.energy_error = trace.energy_error.max((energy / start - 1.0).abs());
        for (ball, spec) in in_list_order(engine).iter().zip(&scene.balls) {
            assert!(ball.center.iter().all(|x| x.is_finite()), "tick {tick}: {ball:?}");
            trace.deepest =
                trace.deepest.max(ball.center.x.abs().max(ball.center.y.abs()) + spec.radius - 10.0);
        }
    });
    trace.report = engine.report();
    trace
}

#[test]
fn an_hour_loses_no_energy_and_no_ball_and_no_bit_differs_between_runs_rates_and_orders_of_the_list() {
    let mut permuted = hour();
    permuted.balls.rotate_left(1);
    permuted.balls.swap(0, 1);
    let runs = [
        ("first", hour(), 60),
        ("second run", hour(), 60),
        ("30 Hz", hour(), 30),
        ("240 Hz", hour(), 240),
        ("permuted list", permuted, 60),
    ];
    let traces = thread::scope(|scope| {
        let threads = runs.each_ref().map(|(_, scene, rate_hz)| scope.spawn(|| trace(scene, *rate_hz)));
        threads.map(|thread| thread.join().unwrap())
    });
    let first = &traces[0];
    assert_eq!(first.hashes.len(), 108_001);
    for (other, (name, ..)) in traces.iter().zip(&runs) {
        let hash = first.hashes.iter().zip(&other.hashes).position(|(a, b)| a != b);
        let state = first.states.iter().zip(&other.states).position(|(a, b)| a != b);
        assert_eq!(
            [hash, state],
            [None, None],
            "{name}: first different hash (of 30 Hz) and state (of 1 Hz)"
        );
        assert_eq!([other.hashes.len(), other.states.len()], [first.hashes.len(), first.states.len()]);
        assert!(other.energy_error < 1e-10, "{name}: relative energy error {}", other.energy_error);
        assert!(other.deepest < 1e-9, "{name}: {} m into a wall", other.deepest);
    }
    assert!(first.hashes[1..].iter().all(|hash| *hash != first.hashes[0]), "the hash sees nothing");
    let Report { collisions, deepest_penetration, fallbacks, .. } = first.report;
    assert!(collisions.ball_ball > 100 && collisions.ball_wall > 1000, "{collisions:?}");
    assert!(deepest_penetration < 1e-9 && fallbacks == 0, "{:?}", first.report);
}
