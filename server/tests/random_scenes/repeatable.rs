//! The same run in another guise: bit for bit the same.

use crate::generate::{BEATS, bystander};
use crate::physical::Run;
use crate::random::Random;
use crate::reloaded;
use crate::script::{Act, act, advance, bits};
use ballroom_cases::mirror::{mirrored, mirrored_state};
use ballroom_cases::scenes::as_net;
use ballroom_physics::{BallState, Controller, Floor, HitPartner};
use server::LoadedScene;

/// Compares a run with the first one from `from` on, beat by beat.
fn follow(
    claim: &str,
    engine: &mut Controller,
    script: &[Act],
    run: &Run,
    (from, rate_hz): (u64, u32),
    index: impl Fn(usize) -> usize,
) -> Result<(), String> {
    for beat in from..BEATS {
        act(engine, script, beat, &index);
        advance(engine, beat, rate_hz);
        if engine.state_hash() != run.hashes[beat as usize] {
            return Err(format!("{claim}: the state hash differs after beat {beat}"));
        }
    }
    let same = engine.balls().zip(&run.last).position(|(a, b)| bits(&a) != bits(b));
    same.map_or(Ok(()), |id| Err(format!("{claim}: ball {id} differs though the hash does not")))
}

pub fn hold_at_other_rates(start: &Controller, script: &[Act], run: &Run) -> Result<(), String> {
    for rate_hz in [30, 240] {
        let claim = format!("at {rate_hz} Hz");
        follow(&claim, &mut start.clone(), script, run, (0, rate_hz), |place| place)?;
    }
    Ok(())
}

pub fn hold_when_restored(seed: u64, start: &Controller, script: &[Act], run: &Run) -> Result<(), String> {
    let saved_at = Random::new(seed ^ 1).below(BEATS as usize) as u64;
    let mut engine = start.clone();
    for beat in 0..saved_at {
        act(&mut engine, script, beat, |place| place);
        advance(&mut engine, beat, 60);
    }
    let words = engine.checkpoint().words().to_vec();
    let mut restored = start.clone();
    let checkpoint = ballroom_physics::Checkpoint::of_words(words);
    restored.restore(&checkpoint).map_err(|fault| format!("its checkpoint is refused: {fault}"))?;
    let claim = format!("saved and restored at beat {saved_at}");
    follow(&claim, &mut restored, script, run, (saved_at, 60), |place| place)
}

pub fn hold_when_permuted(seed: u64, loaded: &LoadedScene, script: &[Act], run: &Run) -> Result<(), String> {
    let mut random = Random::new(seed ^ 2);
    let mut order: Vec<usize> = (0..loaded.scene().balls.len()).collect();
    for last in (1..order.len()).rev() {
        order.swap(last, random.below(last + 1));
    }
    let mut scene = (**loaded.scene()).clone();
    scene.balls = order.iter().map(|i| loaded.scene().balls[*i].clone()).collect();
    let permuted = reloaded(&scene).ok_or("with its list permuted, it is refused")?;
    let mut engine = permuted.controller().map_err(|e| format!("with its list permuted: {e}"))?;
    let index = |place: usize| order.iter().position(|i| *i == place).unwrap_or_default();
    follow("with its list permuted", &mut engine, script, run, (0, 60), index)
}

/// The scene as a net and its mirror image across x = 0 run as mirror images. The mirror negates coordinates and keeps
/// parameters. Returns false if the net is refused.
pub fn hold_in_a_mirror(loaded: &LoadedScene, start: &Controller, script: &[Act]) -> Result<bool, String> {
    let mut scene = loaded.physics().clone();
    let mut engine = start.clone();
    if matches!(scene.floor, Floor::Polynomial { .. }) {
        scene = as_net(&scene);
        // What a net rounds may lie outside by an ulp.
        let Ok(net) = Controller::new(&scene) else { return Ok(false) };
        engine = net;
    }
    let mut image = Controller::new(&mirrored(&scene)).map_err(|e| format!("its mirror image: {e}"))?;
    let reflected: Vec<Act> = script.iter().map(|act| act.mirrored()).collect();
    for beat in 0..BEATS {
        act(&mut engine, script, beat, |place| place);
        act(&mut image, &reflected, beat, |place| place);
        advance(&mut engine, beat, 30);
        advance(&mut image, beat, 30);
        // 0 and -0 are one number.
        let mut pairs = engine.balls().zip(image.balls());
        if let Some(id) = pairs.position(|(ball, seen)| mirrored_state(&ball) != seen) {
            return Err(format!("in a mirror, ball {id} differs after beat {beat}"));
        }
    }
    Ok(true)
}

/// With a ball added that meets nobody: it is known to have met nobody because no hit of the run names it and another
/// ball. Returns whether it was so.
pub fn hold_beside_a_bystander(
    seed: u64,
    loaded: &LoadedScene,
    script: &[Act],
    run: &Run,
) -> Result<bool, String> {
    let mut scene = (**loaded.scene()).clone();
    scene.balls.push(bystander(seed, &scene));
    // It may stand in a wall, in another ball or where the floor is too tight for it.
    let Some(Ok(mut engine)) = reloaded(&scene).map(|loaded| loaded.controller()) else { return Ok(false) };
    let added = added_to(&engine);
    let others = |engine: &Controller| -> Vec<BallState> {
        let all = engine.balls().enumerate();
        all.filter(|(id, _)| *id != added).map(|(_, ball)| ball).collect()
    };
    let mut refused = 0;
    for beat in 0..BEATS {
        refused += act(&mut engine, script, beat, |place| place);
        advance(&mut engine, beat, 30);
        if has_met(&engine, added) {
            return Ok(false);
        }
    }
    // It stood where a ball was to be put.
    if refused != run.refused {
        return Ok(false);
    }
    let differs = others(&engine).iter().zip(&run.last).position(|(a, b)| bits(a) != bits(b));
    match differs {
        Some(id) => Err(format!("beside a ball that meets nobody, ball {id} differs at the end")),
        None => Ok(true),
    }
}

/// Id of the last ball of the list.
fn added_to(engine: &Controller) -> usize {
    let last = engine.balls().len() - 1;
    engine.scene_index().iter().position(|place| *place == last).unwrap_or_default()
}

/// Whether a ball hit another one in the last advance.
fn has_met(engine: &Controller, ball: usize) -> bool {
    engine.hits().iter().any(|hit| match hit.partner {
        HitPartner::Ball(other) => hit.ball == ball || other == ball,
        HitPartner::Wall(_) => false,
    })
}

/// A ball comes amid the run and goes again. If it met nobody and was about to meet nobody, the run ends as it does
/// without. Returns whether it was so.
pub fn hold_when_one_comes_and_goes(
    seed: u64,
    loaded: &LoadedScene,
    start: &Controller,
    script: &[Act],
    run: &Run,
) -> Result<bool, String> {
    let mut scene = (**loaded.scene()).clone();
    scene.balls.push(bystander(seed, &scene));
    let Some(wider) = reloaded(&scene) else { return Ok(false) };
    let mut random = Random::new(seed ^ 3);
    let comes_at = random.below(BEATS as usize - 2) as u64;
    let goes_at = comes_at + 1 + random.below((BEATS - comes_at - 1) as usize) as u64;
    let few: Vec<Option<usize>> = (0..start.balls().len()).map(Some).collect();
    let many: Vec<Option<usize>> = few.iter().copied().chain([None]).collect();
    // Not where the floor is too tight for it.
    let Ok(mut comes) = start.successor(loaded.physics(), wider.physics(), &many) else { return Ok(false) };
    let goes = comes.at_start().successor(wider.physics(), loaded.physics(), &few);
    let mut goes = goes.map_err(|fault| format!("without the ball that came: {fault}"))?;
    let mut engine = start.clone();
    let books = |engine: &Controller| engine.energy() - engine.steering_work();
    let mut refused = 0;
    for beat in 0..BEATS {
        if beat == comes_at {
            let before = books(&engine);
            // It may stand in a wall or in another ball.
            if engine.go_on_as(&mut comes).is_err() {
                return Ok(false);
            }
            let size = before.abs() + engine.energy().abs() + engine.steering_work().abs();
            if (books(&engine) - before).abs() > 1e-12 * size {
                return Err(format!("one that comes at beat {beat} is not in the books"));
            }
        }
        // Who was about to meet it looks ahead anew.
        if beat == goes_at && engine.go_on_as(&mut goes) != Ok(0) {
            return Ok(false);
        }
        refused += act(&mut engine, script, beat, |place| place);
        advance(&mut engine, beat, 30);
        if (comes_at..goes_at).contains(&beat) && has_met(&engine, added_to(&engine)) {
            return Ok(false);
        }
    }
    // It stood where a ball was to be put.
    if refused != run.refused {
        return Ok(false);
    }
    let differs = engine.balls().zip(&run.last).position(|(a, b)| bits(&a) != bits(b));
    let claim = format!("one came at beat {comes_at} and went at {goes_at}");
    differs.map_or(Ok(true), |id| Err(format!("{claim}, and ball {id} differs at the end")))
}
