//! Random scenes, and what must hold in every one of them.
//!
//! `BALLROOM_SEED` chooses the first seed and `BALLROOM_SCENES` how many; a scene that fails names its own seed, is
//! written out as a file that `ballroom simulate` runs, and is tried again by `BALLROOM_SEED=<seed> BALLROOM_SCENES=1`.
//! An hour of it: `BALLROOM_SCENES=100000 cargo test --release -p server --test random_scenes -- --nocapture`.

mod generate;
mod physical;
mod random;
mod repeatable;
mod script;

use generate::{Case, case};
use server::{LoadedScene, SceneText};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// Scenes of a run that nobody asked for more.
const SCENES: u64 = 2400;
/// The first seed of such a run.
const SEED: u64 = 20_161_122;
/// Failures after which a run ends.
const ENOUGH: usize = 20;

/// What became of a scene.
enum Outcome {
    Refused,
    Held { bystander: bool, guest: bool, piled: bool, hits: u64 },
}

#[derive(Default)]
struct Tally {
    refused: u64,
    held: u64,
    bystanders: u64,
    guests: u64,
    piled: u64,
    hits: u64,
    failures: Vec<String>,
}

#[test]
fn random_scenes_repeat_bit_for_bit_and_keep_the_laws() {
    let [first, count] = [("BALLROOM_SEED", SEED), ("BALLROOM_SCENES", SCENES)].map(|(name, usual)| {
        std::env::var(name).map_or(usual, |text| {
            text.parse().unwrap_or_else(|_| panic!("{name} is {text:?}: use a whole number"))
        })
    });
    println!("BALLROOM_SEED={first} BALLROOM_SCENES={count}");
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
                        println!("{}", write_out(seed, &case(seed), "asked for").display());
                    }
                    let outcome = tried(seed);
                    tally.lock().unwrap().enter(outcome);
                }
            });
        }
    });
    let tally = tally.into_inner().unwrap();
    let Tally { refused, held, bystanders, guests, piled, hits, .. } = tally;
    println!("{held} scenes held, {refused} refused; {hits} hits; {bystanders} bystanders met nobody");
    println!("{guests} balls came and went and met nobody");
    println!("{piled} scenes piled up, and no energy was claimed of them from then on");
    assert!(tally.failures.is_empty(), "seed {first}:\n{}", tally.failures.join("\n"));
    // A single scene may be asked for to look at it.
    if count >= 100 {
        assert!(refused * 4 < held, "most scenes must be accepted");
        assert!(
            bystanders * 3 > held && guests * 3 > held && piled * 5 < held && hits > 50 * held,
            "the scenes must put the claims to the test"
        );
    }
}

impl Tally {
    fn enter(&mut self, outcome: Result<Outcome, String>) {
        match outcome {
            Ok(Outcome::Refused) => self.refused += 1,
            Ok(Outcome::Held { bystander, guest, piled, hits }) => {
                self.held += 1;
                self.bystanders += u64::from(bystander);
                self.guests += u64::from(guest);
                self.piled += u64::from(piled);
                self.hits += hits;
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
    let file = write_out(seed, &case, &failure);
    Err(format!("scene {seed}: {failure}\n    {}", file.display()))
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
    let run = physical::hold(&loaded, &start, &case.script)?;
    repeatable::hold_at_other_rates(&start, &case.script, &run)?;
    repeatable::hold_when_restored(seed, &start, &case.script, &run)?;
    repeatable::hold_when_permuted(seed, &loaded, &case.script, &run)?;
    repeatable::hold_in_a_mirror(&loaded, &start, &case.script)?;
    let bystander = repeatable::hold_beside_a_bystander(seed, &loaded, &case.script, &run)?;
    let guest = repeatable::hold_when_one_comes_and_goes(seed, &loaded, &start, &case.script, &run)?;
    Ok(Outcome::Held { bystander, guest, piled: run.piled, hits: run.hits })
}

/// The scene as `simulate` takes it, with what happened and what players do as comments.
fn write_out(seed: u64, case: &Case, failure: &str) -> PathBuf {
    let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("random-{seed}.toml"));
    let mut text = String::new();
    let script = case.script.iter().map(ToString::to_string);
    for line in failure.lines().map(str::to_owned).chain(script) {
        text.extend(["# ", &line, "\n"]);
    }
    text.push_str(&toml::to_string(&case.scene).unwrap_or_default());
    std::fs::write(&file, text).expect("the test's own directory takes a file");
    file
}

/// A scene of the same kind with other balls, ready to run; none when it is refused.
fn reloaded(scene: &protocol::scene::Scene) -> Option<LoadedScene> {
    SceneText::new("other.toml", toml::to_string(scene).ok()?).load().ok()
}
