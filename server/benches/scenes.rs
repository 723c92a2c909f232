//! Cost beside error for the scenes that come with the program and a large one, or for the scenes named as arguments:
//! `cargo bench -p server --bench scenes -- thousand gas:10000`, where the number is that of the balls.
//!
//! Each scene is advanced by ticks of 60 Hz, as the server does, after one second of warming up. CPU is the
//! process's own time, so that other load on the machine counts less; energy is the relative change over the
//! span, and overlap the deepest at any impact, in radii of the smallest ball. `--save` keeps the table for this machine.

#[path = "../physics/benches/common/results.rs"]
mod results;

use ballroom_physics::{Controller, Report, Time};
use cpu_time::ProcessTime;
use results::Results;
use server::SceneText;
use server::scene_file::built_in_names;
use std::error::Error;

const RATE_HZ: u32 = 60;
const WARM_UP_S: u64 = 1;
const SPAN_S: u64 = 20;

fn main() -> Result<(), Box<dyn Error>> {
    let named: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let usual = built_in_names().chain(["gas:10000"]);
    let scenes = if named.is_empty() { usual.map(str::to_owned).collect() } else { named };
    let mut results = Results::of("scenes");
    results.line(format_args!(
        "{:<24}{:>7}{:>12}{:>10}{:>12}{:>12}{:>10}{:>13}{:>12}",
        "scene",
        "balls",
        "% of a core",
        "us/tick",
        "ball-ball/s",
        "ball-wall/s",
        "steps/s",
        "energy error",
        "overlap/r"
    ));
    for scene in scenes {
        results.line(format_args!("{scene:<24}{}", measure(&scene)?));
    }
    results.finish()?;
    Ok(())
}

fn measure(scene: &str) -> Result<String, server::SceneError> {
    let (name, count) = match scene.split_once(':').map(|(name, count)| (name, count.parse())) {
        Some((name, Ok(count))) => (name, Some(count)),
        _ => (scene, None),
    };
    let loaded = SceneText::open(name)?.with_balls(count).load()?;
    let smallest = loaded.physics().balls.iter().map(|b| b.radius).fold(f64::INFINITY, f64::min);
    let mut controller = loaded.controller()?;
    let mut tick = 0;
    run(&mut controller, &mut tick, WARM_UP_S);
    let (before, energy) = (controller.report(), controller.energy());
    let start = ProcessTime::now();
    run(&mut controller, &mut tick, SPAN_S);
    let cpu = start.elapsed().as_secs_f64();
    let after = controller.report();
    let rate = |f: fn(&Report) -> u64| (f(&after) - f(&before)) as f64 / SPAN_S as f64;
    Ok(format!(
        "{:>7}{:>12.3}{:>10.1}{:>12.1}{:>12.1}{:>10.0}{:>13.1e}{:>12.1e}",
        controller.balls().len(),
        100.0 * cpu / SPAN_S as f64,
        1e6 * cpu / (SPAN_S * u64::from(RATE_HZ)) as f64,
        rate(|r| r.collisions.ball_ball),
        rate(|r| r.collisions.ball_wall),
        rate(|r| r.steps),
        (controller.energy() / energy - 1.0).abs(),
        after.deepest_penetration / smallest,
    ))
}

fn run(controller: &mut Controller, tick: &mut u64, seconds: u64) {
    for _ in 0..seconds * u64::from(RATE_HZ) {
        *tick += 1;
        controller.advance_to(Time::of_tick(*tick, RATE_HZ));
    }
}
