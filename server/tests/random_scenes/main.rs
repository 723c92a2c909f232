//! Random scenes, and what must hold in every one of them.
//!
//! `BALLROOM_SEED` chooses the first seed and `BALLROOM_SCENES` how many; a scene that fails names its own seed, is
//! written out as a file that `ballroom simulate` runs and with its commands as one that `ballroom replay` runs, and is tried
//! again by `BALLROOM_SEED=<seed> BALLROOM_SCENES=1`. An hour of it:
//! `BALLROOM_SEED=1 BALLROOM_SCENES=120000 cargo test --release -p server --test random_scenes -- --nocapture`.

mod asked;
mod generate;
mod halted;
mod physical;
mod random;
mod repeatable;
mod scheme;
mod script;
mod written;

#[path = "../common/truth.rs"]
mod truth;

use generate::{Case, case};
use halted::Looks;
use physical::Laws;
use server::{LoadedScene, SceneText};
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// Scenes of a run that nobody asked for more, and how many of them must be accepted.
const SCENES: u64 = 2400;
/// See [`SCENES`].
const HELD: u64 = 2000;
/// The first seed of such a run.
const SEED: u64 = 20_161_122;
/// Failures after which a run ends.
const ENOUGH: usize = 20;

/// What became of a scene.
enum Outcome {
    Refused,
    Held(Tally),
}

/// What scenes put to the test, added up.
#[derive(Default)]
struct Tally {
    refused: u64,
    held: u64,
    bystanders: u64,
    guests: u64,
    piled: u64,
    mirrored: u64,
    hits: u64,
    /// Deepest overlap at a tick, over the smaller radius: with a tolerance, and with a fixed step.
    deepest: [f64; 2],
    looks: Looks,
    failures: Vec<String>,
}

#[test]
fn random_scenes_repeat_bit_for_bit_and_keep_the_laws() {
    let [first, count] = [("BALLROOM_SEED", SEED), ("BALLROOM_SCENES", SCENES)].map(|(name, usual)| {
        std::env::var(name).map_or(usual, |text| {
            text.parse().unwrap_or_else(|_| panic!("{name} is {text:?}: use a whole number"))
        })
    });
    say(&format!("BALLROOM_SEED={first} BALLROOM_SCENES={count}"));
    let (next, tally) = (AtomicU64::new(0), Mutex::new(Tally::default()));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    if place >= count || tally.lock().unwrap().failures.len() >= ENOUGH {
                        break;
                    }
                    let seed = first.wrapping_add(place);
                    if count == 1 {
                        // Asked for alone, it is kept in any case: it may be one that never ends.
                        say(&write_out(seed, &case(seed), "asked for"));
                    }
                    let outcome = tried(seed);
                    tally.lock().unwrap().enter(outcome);
                }
            });
        }
    });
    let tally = tally.into_inner().unwrap();
    let Tally { refused, held, bystanders, guests, piled, mirrored, hits, deepest, looks, .. } = tally;
    say(&format!("{held} scenes held, {refused} refused; {hits} hits; {bystanders} bystanders met nobody"));
    say(&format!("{guests} balls came and went and met nobody; {mirrored} scenes ran in a mirror"));
    say(&format!("{piled} scenes piled up, and no energy was claimed of them from then on"));
    let [asked, fixed] = deepest;
    say(&format!("deepest overlap at a tick: {asked:e} radii with a tolerance, {fixed:e} with a fixed step"));
    let Looks { hits: looked_at, late, farthest, losses } = looks;
    say(&format!(
        "halted at {looked_at} hits, none farther than {farthest:e} radii from touching; {late} came late"
    ));
    say(&format!("{losses} beats in which hits took energy were held to restitution"));
    assert!(tally.failures.is_empty(), "seed {first}:\n{}", tally.failures.join("\n"));
    // A single scene may be asked for to look at it.
    if count >= 100 {
        assert!(refused * 4 < held, "most scenes must be accepted");
        assert!(
            bystanders * 3 > held && guests * 3 > held && piled * 5 < held && hits > 50 * held,
            "the scenes must put the claims to the test"
        );
        assert!(
            mirrored * 20 > held * 19 && late * 20 < looked_at && losses > 2 * held,
            "claims were left out"
        );
    }
    if count >= SCENES {
        assert!(held * SCENES >= count * HELD, "{held} scenes of {count} are too few");
    }
}

/// Says it to whoever runs the test, also if it passes: the harness keeps what is merely printed to itself.
fn say(line: &str) {
    // Nobody may be listening.
    drop(writeln!(std::io::stderr(), "{line}"));
}

impl Tally {
    fn enter(&mut self, outcome: Result<Outcome, String>) {
        match outcome {
            Ok(Outcome::Refused) => self.refused += 1,
            Ok(Outcome::Held(one)) => {
                self.held += one.held;
                self.bystanders += one.bystanders;
                self.guests += one.guests;
                self.piled += one.piled;
                self.mirrored += one.mirrored;
                self.hits += one.hits;
                self.looks.add(&one.looks);
                for (all, one) in self.deepest.iter_mut().zip(one.deepest) {
                    *all = all.max(one);
                }
            }
            Err(failure) => self.failures.push(failure),
        }
    }
}

/// Tries the scene of a seed; a failure is written out and described.
fn tried(seed: u64) -> Result<Outcome, String> {
    let case = case(seed);
    let outcome = catch_unwind(AssertUnwindSafe(|| hold(seed, &case)));
    let failure = match outcome {
        Ok(Ok(outcome)) => return Ok(outcome),
        Ok(Err(failure)) => failure,
        Err(panic) => {
            let message = panic.downcast_ref::<String>().cloned();
            format!("it panics: {}", message.unwrap_or_default())
        }
    };
    Err(format!("scene {seed}: {failure}\n    {}", write_out(seed, &case, &failure)))
}

/// Writes a case out and says where, and why it is not there with its commands.
fn write_out(seed: u64, case: &Case, failure: &str) -> String {
    let scene = written::write_scene(seed, case, failure);
    match written::write_run(seed, case) {
        Ok((run, _)) => format!("{}\n    {}", scene.display(), run.display()),
        Err(why) => format!("{}, and with its commands only in part: {why}", scene.display()),
    }
}

fn hold(seed: u64, case: &Case) -> Result<Outcome, String> {
    let text = toml::to_string(&case.scene).map_err(|e| e.to_string())?;
    let Ok(loaded) = SceneText::new("random.toml", text).load() else {
        return Ok(Outcome::Refused);
    };
    if **loaded.scene() != case.scene {
        return Err("written out and read again, it is another scene".into());
    }
    let Ok(start) = loaded.controller() else {
        return Ok(Outcome::Refused);
    };
    let laws = Laws::of(&loaded, &start);
    let run = physical::hold(&laws, &start, &case.script)?;
    let looks = halted::hold(&laws, &start, &case.script, &run)?;
    repeatable::hold_at_other_rates(&start, &case.script, &run)?;
    repeatable::hold_when_restored(seed, &start, &case.script, &run)?;
    repeatable::hold_when_permuted(seed, &loaded, &case.script, &run)?;
    let mirror = repeatable::hold_in_a_mirror(&loaded, &start, &case.script)?;
    let bystander = repeatable::hold_beside_a_bystander(seed, &loaded, &case.script, &run)?;
    let guest = repeatable::hold_when_one_comes_and_goes(seed, &loaded, &start, &case.script, &run)?;
    let mut deepest = [0.0; 2];
    deepest[usize::from(matches!(case.scene.accuracy, protocol::scene::Accuracy::Fixed { .. }))] =
        run.deepest;
    Ok(Outcome::Held(Tally {
        held: 1,
        bystanders: bystander.into(),
        guests: guest.into(),
        piled: run.piled.into(),
        mirrored: mirror.into(),
        hits: run.hits,
        deepest,
        looks,
        ..Tally::default()
    }))
}

/// A scene of the same kind with other balls, ready to run; none when it is refused.
fn reloaded(scene: &protocol::scene::Scene) -> Option<LoadedScene> {
    SceneText::new("other.toml", toml::to_string(scene).ok()?).load().ok()
}
