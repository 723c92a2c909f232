//! What a history costs, and how long going back takes, for `thousand` or the scenes named as arguments:
//! `cargo bench -p server --bench rewind -- original gas:10000`, where the number is that of the balls.
//!
//! A scene is run for ten minutes and a minute more with its history kept as the server keeps it, 256 MiB at most. Then
//! it is gone back by 600 s less every twentieth of a second: one time is what making ready takes, point, commands and
//! running forward, which happens beside the clock. Times are wall times; the others are the process's own.
//! `--save` keeps the table for this machine.

#[path = "../physics/benches/common/results.rs"]
mod results;

use cpu_time::ThreadTime;
use protocol::command::Command;
use protocol::timeline::Rewind;
use results::Results;
use server::SceneText;
use server::history::{Archive, DEFAULT_HISTORY_BYTES, Diary, Settings};
use server::simulation::{Moment, Simulation};
use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

const RATE_HZ: u32 = 60;
/// Simulated seconds that are run.
const RUN_S: u64 = 660;
/// How far back, s.
const BACK_S: u64 = 600;
/// Targets, a twentieth of a second apart.
const TARGETS: u32 = 20;
/// Simulated seconds of a round, and rounds, that compare ticks with a history and without.
const ROUND_S: u64 = 4;
const ROUNDS: u32 = 10;

fn main() -> Result<(), Box<dyn Error>> {
    let named: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let scenes = if named.is_empty() { vec!["thousand".to_owned()] } else { named };
    let mut results = Results::of("rewind");
    results.line(format_args!(
        "{:<12}{:>7}{:>9}{:>8}{:>15}{:>13}{:>13}{:>22}{:>16}",
        "scene",
        "balls",
        "points",
        "MiB",
        "B/ball/point",
        "us a point",
        "us a tick",
        "ticks with/without",
        "10 min back ms"
    ));
    for scene in scenes {
        results.line(format_args!("{scene:<12}{}", measure(&scene)?));
    }
    results.finish()?;
    Ok(())
}

fn measure(scene: &str) -> Result<String, Box<dyn Error>> {
    let (name, count) = match scene.split_once(':') {
        Some((name, count)) => (name, Some(count.parse()?)),
        None => (scene, None),
    };
    let loaded = Arc::new(SceneText::open(name)?.with_balls(count).load()?);
    let mut simulation = Simulation::new(loaded.clone(), RATE_HZ, 1)?;
    let (archive, mut diary) = Archive::new(&simulation, Settings::live(DEFAULT_HISTORY_BYTES));
    let files = std::thread::spawn({
        let archive = archive.clone();
        move || archive.run()
    });
    let start = ThreadTime::now();
    run(&mut simulation, Some(&mut diary), RUN_S);
    let tick = start.elapsed().as_secs_f64() / (RUN_S * u64::from(RATE_HZ)) as f64;
    let history = archive.timeline().history;
    let mut back: Vec<f64> = (0..TARGETS).map(|i| go_back(&archive, i)).collect();
    back.sort_by(f64::total_cmp);
    let point = cost_of_point(&simulation);
    let ratio = cost_of_history(&mut Simulation::new(loaded, RATE_HZ, 1)?);
    let balls = simulation.roster().names.len();
    drop(diary);
    files.join().map_err(|_| "the history's thread panicked")?;
    Ok(format!(
        "{balls:>7}{:>9}{:>8.1}{:>15.0}{:>13.1}{:>13.1}{ratio:>22.4}{:>16}",
        history.points,
        history.bytes as f64 / f64::from(1 << 20),
        history.bytes as f64 / (history.points * balls as u64) as f64,
        1e6 * point,
        1e6 * tick,
        format!("{:.1} to {:.1}", 1e3 * back[0], 1e3 * back[back.len() - 1]),
    ))
}

fn run(simulation: &mut Simulation, mut diary: Option<&mut Diary>, seconds: u64) {
    for _ in 0..seconds * u64::from(RATE_HZ) {
        simulation.advance();
        if let Some(diary) = &mut diary {
            diary.ticked(simulation);
        }
    }
}

/// Wall seconds until the state of ten minutes ago, less so many twentieths of a second, is ready.
fn go_back(archive: &Archive, twentieths: u32) -> f64 {
    let start = Instant::now();
    let seconds = BACK_S as f64 - f64::from(twentieths) / f64::from(TARGETS);
    let planned = archive.plan(Command::Rewind(Rewind::by_seconds(seconds)), 0).expect("an open archive");
    let (_, plan) = planned.expect("ten minutes of history");
    plan.carry_out().expect("a state of the past");
    start.elapsed().as_secs_f64()
}

/// Seconds of the tick thread that writing a point takes.
fn cost_of_point(simulation: &Simulation) -> f64 {
    const TIMES: u32 = 50;
    let mut page = Moment::with_room(&simulation.ground());
    simulation.write_moment(&mut page);
    let start = ThreadTime::now();
    (0..TIMES).for_each(|_| simulation.write_moment(&mut page));
    start.elapsed().as_secs_f64() / f64::from(TIMES)
}

/// Tick thread's time with a history over that without, in rounds of one and the other.
fn cost_of_history(simulation: &mut Simulation) -> f64 {
    let (archive, mut diary) = Archive::new(simulation, Settings::live(DEFAULT_HISTORY_BYTES));
    let mut spent = [0.0; 2];
    for round in 0..2 * ROUNDS {
        let keeps = round % 2 == 1;
        let start = ThreadTime::now();
        run(simulation, keeps.then_some(&mut diary), ROUND_S);
        spent[usize::from(keeps)] += start.elapsed().as_secs_f64();
        drop(archive.timeline());
    }
    spent[1] / spent[0]
}
