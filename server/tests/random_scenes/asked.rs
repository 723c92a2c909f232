//! An error asked for is kept in random scenes, through their walls, hits and hills.

use crate::generate::case;
use crate::random::Random;
use crate::truth::error;
use protocol::scene::Accuracy;
use server::SceneText;

/// Scenes that are asked.
const SCENES: u64 = 120;
/// What they are asked for, m.
const ERRORS_M: [f64; 6] = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];
/// Balls left in each: the hits of many multiply any error to nonsense within 10 s.
const BALLS: usize = 2;

#[test]
fn an_error_asked_for_is_kept_at_every_tick_of_random_scenes() {
    let (mut kept, mut used, mut hits, mut refused) = (0, 0, 0, 0);
    for seed in 0..SCENES {
        let mut scene = case(seed).scene;
        scene.balls.truncate(BALLS);
        let error_m = ERRORS_M[Random::new(seed).below(ERRORS_M.len())];
        scene.accuracy = Accuracy::Error { error_m };
        let text = toml::to_string(&scene).expect("a scene as text");
        match SceneText::new("random.toml", text).load() {
            Ok(loaded) => {
                let (error, met) = error(loaded.physics(), loaded.physics().accuracy);
                let share = error / error_m;
                assert!(share <= 1.0, "seed {seed}: {share} of {error_m:e} m; {:?}", loaded.rehearsed());
                kept += 1;
                used += usize::from(share >= 0.01);
                hits += met;
            }
            Err(why) => refused += usize::from(why.field == "accuracy.error_m"),
        }
    }
    crate::say(&format!(
        "{kept} random scenes kept the error asked for through {hits} hits; {refused} cannot be asked"
    ));
    assert!(kept > 60 && used > 20 && hits > 10 * kept as u64, "{kept} kept, {used} used, {hits} hits");
}
