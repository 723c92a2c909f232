//! A run in any number of shards is the run in one piece, bit for bit.

use crate::scenes::{all_bits, center, cloud, graph, load, moving, plane, random, still};
use ballroom_cases::gas;
use ballroom_physics::{Controller, Division, Drive, MotionLaw, Scene, Time};
use nalgebra::Vector2;

const RATE_HZ: u32 = 60;

/// Every bit that is shown or counted.
fn shown(engine: &Controller) -> (u64, [u64; 2], String) {
    let numbers = [engine.energy().to_bits(), engine.steering_work().to_bits()];
    let told = format!("{:?} {:?}", engine.report(), engine.time());
    (engine.state_hash(), numbers, told)
}

/// What players do before a tick, to a ball here and there.
fn steer(engine: &mut Controller, tick: u64) {
    let balls = engine.scene_index().len() as u64;
    let ball = |turn: u64| (turn * 7919 % balls) as usize;
    let direction = Vector2::new(0.6, -0.8);
    match tick % 8 {
        2 => engine.push(ball(tick), direction, 5.0),
        4 => engine.drive(ball(1), Some(Drive { direction, acceleration: 2.0, speed_limit: 1.5 })),
        7 => engine.drive(ball(1), None),
        _ => {}
    }
}

/// Runs a scene in one piece and in `shards`, and compares them after every tick. Says how the division went.
fn assert_same(name: &str, scene: &Scene, shards: &[usize], ticks: u64, steered: bool) -> Vec<Division> {
    let mut whole = load(scene);
    let mut divided: Vec<Controller> = shards.iter().map(|_| whole.clone()).collect();
    for (engine, count) in divided.iter_mut().zip(shards) {
        engine.divide(*count);
        assert_eq!(engine.division().map(|division| division.shards), (*count > 1).then_some(*count));
    }
    for tick in 0..ticks {
        if steered {
            steer(&mut whole, tick);
        }
        let time = Time::of_tick(tick + 1, RATE_HZ);
        let told = whole.advance_to(time);
        for (engine, count) in divided.iter_mut().zip(shards) {
            if steered {
                steer(engine, tick);
            }
            let also_told = engine.advance_to(time);
            assert_eq!(shown(engine), shown(&whole), "{name}, {count} shards, tick {tick}");
            assert_eq!(format!("{also_told:?}"), format!("{told:?}"), "{name}, {count} shards, tick {tick}");
            assert!(engine.hits() == whole.hits(), "{name}, {count} shards, tick {tick}");
            if tick % 16 == 5 {
                assert!(engine.checkpoint() == whole.checkpoint(), "{name}, {count} shards, tick {tick}");
                assert_eq!(all_bits(engine), all_bits(&whole), "{name}, {count} shards, tick {tick}");
            }
        }
    }
    divided.iter().filter_map(Controller::division).collect()
}

#[test]
fn a_gas_in_any_number_of_shards_is_the_gas_in_one_piece() {
    for (name, scene) in [("bowl", gas::on_a_bowl(1500)), ("plane", gas::on_a_plane(1500))] {
        for (steered, went) in [false, true].map(|s| (s, assert_same(name, &scene, &[1, 2, 3, 8], 60, s))) {
            println!("{name}, steered {steered}: {went:#?}");
            assert!(went[0].kept >= 100 && went[0].undone <= 6, "{name}: {went:?}");
        }
    }
}

#[test]
fn radii_of_thirty_to_one_in_shards_are_those_in_one_piece() {
    let mut scene = graph(6.0, &[(2, 0, 0.03), (0, 2, 0.03)], MotionLaw::Rolling);
    scene.balls = cloud(400, [0.02, 0.6], 5.0, 2.0, 9);
    let went = assert_same("30 : 1", &scene, &[2, 3, 8], 90, true);
    assert!(went.iter().all(|division| division.kept + division.undone > 0), "{went:?}");
}

/// What crosses all strips in a phase is beyond any halo: such phases are run in one piece.
#[test]
fn a_bullet_through_all_strips_has_its_phases_undone_and_changes_no_bit() {
    let mut scene = plane(6.0);
    scene.balls = cloud(200, [0.05, 0.05], 5.5, 0.5, 4);
    scene.balls.push(moving("bullet", 0.04, center(-5.8, 5.9), 700.0, -30.0));
    let went = assert_same("bullet", &scene, &[2, 3, 8], 60, false);
    assert!(went.iter().all(|division| division.undone > 3), "{went:?}");
}

#[test]
fn a_cradle_across_a_border_hits_as_in_one_piece() {
    let mut scene = plane(8.0);
    let at = |i: u32| center(f64::from(i) * 0.2 - 2.0, 0.0);
    scene.balls = (0..20).map(|i| still(&format!("row {i:02}"), 0.1, at(i))).collect();
    scene.balls.push(moving("striker", 0.1, center(-4.0, 0.0), 3.0, 0.0));
    let beside = |i: u32| center(f64::from(i % 8) * 0.9 - 3.0, f64::from(i / 8) + 1.0);
    scene.balls.extend((0..40).map(|i| moving(&format!("beside {i:02}"), 0.1, beside(i), 0.3, 0.7)));
    assert_same("cradle", &scene, &[2, 3, 8], 240, false);
}

#[test]
fn piles_and_held_balls_in_shards_are_those_in_one_piece() {
    let mut random = random(5);
    for round in 0..3 {
        let bumps = [(2, 0, 0.2), (0, 2, 0.1 + 0.2 * random()), (3, 1, 0.01)];
        let law = if round % 2 == 0 { MotionLaw::Rolling } else { MotionLaw::Frictionless };
        let mut scene = graph(3.0, &bumps, law);
        scene.restitution = 0.5 + 0.1 * f64::from(round);
        scene.balls = cloud(40, [0.05, 0.12], 2.2, 1.0, 20 + u64::from(round as u8));
        assert_same(&format!("pile {round}"), &scene, &[2, 3], 100, round > 1);
    }
}

#[test]
fn a_divided_advance_allocates_nothing_after_its_first_seconds() {
    let mut engine = load(&gas::on_a_bowl(1500));
    engine.divide(2);
    let mut advance = |from: u64, to: u64| {
        for tick in from + 1..=to {
            engine.advance_to(Time::of_tick(tick, RATE_HZ));
        }
    };
    advance(0, 120);
    let info = allocation_counter::measure(|| advance(120, 360));
    assert_eq!(info.count_total, 0, "{info:?}");
}

/// The ticks between which it is divided, and by how much, are nobody's business.
#[test]
fn a_run_is_divided_and_made_whole_again_at_any_time() {
    let scene = gas::on_a_bowl(600);
    let (mut whole, mut divided, mut slow) = (load(&scene), load(&scene), load(&scene));
    slow.divide(2);
    for tick in 0..90 {
        divided.divide((tick / 7 % 4) as usize);
        divided.advance_to(Time::of_tick(tick + 1, RATE_HZ));
        whole.advance_to(Time::of_tick(tick + 1, RATE_HZ));
        assert_eq!(shown(&divided), shown(&whole), "tick {tick}");
    }
    slow.advance_to(Time::of_tick(90, RATE_HZ));
    assert_eq!((slow.state_hash(), slow.report()), (whole.state_hash(), whole.report()));
    let mut loaded = load(&scene);
    loaded.restore(&slow.checkpoint()).unwrap();
    assert!(slow.is_sound() && loaded.state_hash() == whole.state_hash());
}
