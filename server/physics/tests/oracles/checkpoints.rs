//! A run that is saved, loaded and continued is the run that never stopped.

use crate::scenes::{all_bits, bits, center, cloud, graph, load, moving, original, plane, random};
use ballroom_physics::{
    Accuracy, Checkpoint, CheckpointFault, Controller, Drive, MotionLaw, Observer, Scene, Scheme, Time,
};
use nalgebra::Vector2;

const RATE_HZ: u32 = 60;

/// Curved and flat, rolling and sliding, elastic and piling up, every way to integrate.
fn scenes() -> Vec<(&'static str, Scene)> {
    let bumps = [(2, 0, 0.2), (0, 2, 0.25), (3, 1, 0.01), (1, 2, -0.02)];
    let crowd = |scene: Scene, count| Scene { balls: cloud(count, [0.05, 0.12], 1.8, 1.0, 3), ..scene };
    let rolling = crowd(graph(3.0, &bumps, MotionLaw::Rolling), 60);
    let sliding = crowd(graph(3.0, &bumps, MotionLaw::Frictionless), 60);
    let fixed = |scheme| Scene { accuracy: Accuracy::Fixed(scheme, 1.0 / 128.0), ..rolling.clone() };
    let mut flat = plane(3.0);
    flat.balls =
        vec![moving("a", 0.2, center(0.0, 0.0), 3.0, 1.0), moving("b", 0.3, center(1.0, 0.5), -1.0, 0.3)];
    vec![
        ("original", original()),
        ("rolling crowd", rolling.clone()),
        ("sliding crowd", sliding),
        ("pile", Scene { restitution: 0.5, ..crowd(graph(3.0, &bumps, MotionLaw::Rolling), 12) }),
        ("plane", flat),
        ("rk4", fixed(Scheme::Rk4)),
        ("tsit5", fixed(Scheme::Tsit5)),
    ]
}

/// What a player does at `tick`: the same whenever it is asked.
fn steer(engine: &mut Controller, tick: u64) {
    let direction = Vector2::new(0.6, -0.8);
    match tick % 50 {
        7 => engine.push(0, direction, 5.0),
        20 => engine.drive(1, Some(Drive { direction, acceleration: 2.0, speed_limit: 3.0 })),
        43 => engine.drive(1, None),
        _ => {}
    }
}

fn tick(engine: &mut Controller, tick: u64) {
    steer(engine, tick);
    engine.advance_to(Time::of_tick(tick + 1, RATE_HZ));
}

#[test]
fn an_observer_sees_every_ball_as_it_is_seen_alone_whatever_it_saw_before() {
    for (name, scene) in scenes() {
        let (mut engine, mut observer) = (load(&scene), Observer::default());
        let start = engine.checkpoint();
        for again in 0..2 {
            for at in 0..60 {
                // At the first all arcs begin, later at no two balls the same.
                engine.advance_to(Time::of_tick(at, 17 + 6 * again));
                let mut seen = 0;
                engine.observe(&mut observer, |ball, state| {
                    assert_eq!(ball, seen);
                    assert_eq!(bits(state), bits(&engine.ball(ball)), "{name}, ball {ball} at {at}");
                    seen += 1;
                });
                assert_eq!(seen, engine.balls().len());
            }
            engine.restore(&start).expect("its own checkpoint");
        }
    }
}

/// Every bit that is shown or counted.
fn shown(engine: &Controller) -> (Vec<u64>, u64, [u64; 2], String) {
    let numbers = [engine.energy().to_bits(), engine.steering_work().to_bits()];
    let told = format!("{:?} {:?} {:?}", engine.report(), engine.hits(), engine.time());
    (all_bits(engine), engine.state_hash(), numbers, told)
}

#[test]
fn saved_loaded_and_continued_equals_never_having_stopped() {
    for (name, scene) in scenes() {
        let mut straight = load(&scene);
        let mut stopped: Option<Controller> = None;
        let mut at = random(11);
        for t in 0..300 {
            if at() < 0.1 {
                let words = straight.checkpoint().words().to_vec();
                let mut fresh = load(&scene);
                fresh.restore(&Checkpoint::of_words(words)).unwrap();
                assert_eq!(fresh.checkpoint(), straight.checkpoint(), "{name}, tick {t}");
                stopped = Some(fresh);
            }
            tick(&mut straight, t);
            if let Some(stopped) = &mut stopped {
                tick(stopped, t);
                assert_eq!(shown(stopped), shown(&straight), "{name}, tick {t}");
            }
        }
        assert!(stopped.is_some());
    }
}

#[test]
fn a_run_is_rewound_in_place() {
    let scene = original();
    let mut engine = load(&scene);
    let start = engine.checkpoint();
    let run = |engine: &mut Controller| {
        (0..200)
            .map(|t| {
                tick(engine, t);
                shown(engine)
            })
            .collect::<Vec<_>>()
    };
    let first = run(&mut engine);
    engine.restore(&start).unwrap();
    assert_eq!(run(&mut engine), first);
}

#[test]
fn what_is_no_checkpoint_of_the_scene_is_refused_and_changes_nothing() {
    let scene = original();
    let mut engine = load(&scene);
    for t in 0..40 {
        tick(&mut engine, t);
    }
    let before = shown(&engine);
    let whole = engine.checkpoint();
    let mut refuse = |words: Vec<u64>| {
        let fault = engine.restore(&Checkpoint::of_words(words)).unwrap_err();
        assert_eq!(shown(&engine), before);
        fault
    };
    let words = whole.words();
    for length in [0, 1, 3, 4, 5, words.len() - 1] {
        let fault = refuse(words[..length].to_vec());
        assert_eq!(fault, CheckpointFault::Length { have: length, want: words.len() });
    }
    let longer = refuse(words.iter().copied().chain([0]).collect());
    assert_eq!(longer, CheckpointFault::Length { have: words.len() + 1, want: words.len() });
    for place in 0..words.len() {
        let mut wrong = words.to_vec();
        wrong[place] ^= 1 << (place % 64);
        let fault = refuse(wrong);
        let right = match place {
            0 => matches!(fault, CheckpointFault::Version(_)),
            1 | 2 => fault == CheckpointFault::Scene,
            _ => fault == CheckpointFault::Damaged,
        };
        assert!(right, "word {place}: {fault}");
    }
    let mut heavier = scene;
    heavier.balls[0].mass *= 1.0 + f64::EPSILON;
    assert_eq!(load(&heavier).restore(&whole), Err(CheckpointFault::Scene));
}

/// A checksum keeps accidents out, not intent: whatever the words say, they are refused or a run that goes on.
#[test]
fn words_that_fit_together_are_refused_or_run_on() {
    let odd = [0, 1, 7, u64::MAX, 1 << 63, 1e-300_f64.to_bits(), 1e300_f64.to_bits(), f64::NAN.to_bits()];
    for (name, scene) in scenes() {
        let start = load(&scene);
        let mut engine = start.clone();
        (0..30).for_each(|t| tick(&mut engine, t));
        let mut run = Vec::new();
        engine.write_run(&mut run);
        let mut at = random(23);
        let mut taken = 0;
        for _ in 0..200 {
            let mut wrong = run.clone();
            let place = (at().abs() * wrong.len() as f64) as usize % wrong.len();
            wrong[place] = match (at().abs() * 12.0) as usize {
                which @ 0..8 => odd[which],
                _ => wrong[place] ^ (1 << ((at().abs() * 64.0) as u32 % 64)),
            };
            let mut other = start.clone();
            // Speed is worth its time, and whoever takes words from strangers asks for both.
            let fits = other.restore(&engine.checkpoint_of(&wrong)).is_ok();
            if fits && other.liveliest() < 1e3 && other.is_sound() {
                taken += 1;
                other.advance_to(other.time().after(0.25));
            }
        }
        println!("{name}: {taken} of 200 are taken");
        assert!(engine.is_sound(), "{name}");
        assert!(taken < 200, "{name}");
    }
}

/// What an arc is made of follows from its start: it is launched again and not kept.
#[test]
fn a_checkpoint_takes_a_third_of_a_kilobyte_a_ball() {
    for (name, scene) in scenes() {
        let words = |count: usize| {
            let balls = scene.balls[..count].to_vec();
            load(&Scene { balls, ..scene.clone() }).checkpoint().words().len()
        };
        let a_ball = 8 * (words(2) - words(1));
        println!("{name}: {a_ball} B a ball");
        assert!(a_ball <= 320, "{name}: {a_ball} B");
    }
}

#[test]
fn balls_set_as_in_another_run_go_on_turning_from_there() {
    let scene = original();
    let start = load(&scene);
    let mut engine = load(&scene);
    (0..97).for_each(|t| tick(&mut engine, t));
    engine.set_as_in(&start).unwrap();
    let mut twin = load(&scene);
    // The first step of either is the same, and so is how it turns.
    for t in 1..=6 {
        engine.advance_to(Time::of_tick(97 + t, RATE_HZ));
        twin.advance_to(Time::of_tick(t, RATE_HZ));
        for (a, b) in engine.balls().zip(twin.balls()) {
            let apart =
                a.orientation.iter().zip(b.orientation).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-9, "tick {t}: {:?} {:?}", a.orientation, b.orientation);
        }
    }
}

/// Nothing of the future is left to chance: a run restored from a checkpoint has the same words, and another place of
/// one ball, by one bit, another hash.
#[test]
fn the_hash_sees_a_single_bit_of_a_single_ball() {
    let scene = scenes().swap_remove(1).1;
    let hash = |nudge: bool| {
        let mut scene = scene.clone();
        if nudge {
            let x = &mut scene.balls[17].velocity.x;
            *x = f64::from_bits(x.to_bits() ^ 1);
        }
        let engine = load(&scene);
        (engine.state_hash(), bits(&engine.ball(0)))
    };
    let (one, other) = (hash(false), hash(true));
    assert_ne!(one.0, other.0);
    assert_eq!(one.1, other.1);
}

/// A change of a scene, by name.
type Change = (&'static str, fn(&mut Scene));

#[test]
fn the_hash_sees_every_law_and_what_every_ball_is_made_as() {
    let changes: [Change; 9] = [
        ("mass", |scene| scene.balls[17].mass *= 2.0),
        ("radius", |scene| scene.balls[17].radius *= 0.999),
        ("inertia factor", |scene| scene.balls[17].inertia_factor *= 0.5),
        ("spin", |scene| scene.balls[17].spin += 1.0),
        ("restitution", |scene| scene.restitution = 0.5),
        ("gravity", |scene| scene.gravity.z *= 1.5),
        ("a wall", |scene| scene.walls[0].point.x += 1e-9),
        ("accuracy", |scene| scene.accuracy = Accuracy::Tolerance(1e-10)),
        ("hit budget", |scene| scene.hit_budget += 1),
    ];
    let scenes = scenes();
    for (name, scene) in &scenes[1..3] {
        let plain = load(scene);
        for (what, change) in changes {
            // Without friction nothing turns a ball: how hard that is does not matter.
            if what == "inertia factor" && scene.motion == MotionLaw::Frictionless {
                continue;
            }
            let mut scene = scene.clone();
            change(&mut scene);
            let changed = load(&scene);
            assert_ne!(changed.state_hash(), plain.state_hash(), "{name}: {what}");
        }
    }
}
