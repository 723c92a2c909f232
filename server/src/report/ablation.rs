//! What each feature costs: the scenes that use it, and the scenes that do not.
//!
//! Times are measured in this run. Instruction counts are those kept with the engine, counted by its benches
//! `instructions` and `ablation`: a program cannot count its own, and an engine without a feature must be built first.

use super::clock::cost;
use super::numbers::{self, grouped, plain};
use super::section::{Section, Table, table};
use super::{Options, Progress, ReportError};
use crate::SceneText;
use crate::history::{Archive, DEFAULT_HISTORY_BYTES, Settings};
use crate::simulation::Simulation;
use ballroom_cases::small::{Small, everyday, lone};
use cpu_time::ThreadTime;
use maud::{Markup, html};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Instructions of small scenes.
const COUNTS: &str = include_str!("../../physics/benches/instructions/counts.csv");
/// Instructions of engines with and without a feature.
const WITHOUT: &str = include_str!("../../physics/benches/ablation/table.csv");

/// What a feature may cost a scene that does not use it, %.
const ALLOWED_PERCENT: f64 = 1.0;

/// A feature, a scene without it, and one that differs in it alone.
const PAIRS: [(&str, &str, &str); 9] = [
    ("rolling, spin and orientation", "a ball slides in a bowl", "a ball rolls in a bowl"),
    ("a curved floor", "a ball slides on a plane", "a ball slides in a bowl"),
    (
        "a net of heights, not a polynomial of degree 2",
        "a ball rolls in a bowl",
        "the bowl as a net of heights",
    ),
    ("a net of any points", "the bowl as a net of heights", "the bowl as a net of any points"),
    ("four walls more", "a ball rolls in a bowl", "the bowl with eight walls"),
    ("another ball, never met", "a ball rolls in a bowl", "the bowl with another ball far off"),
    ("a force held", "a ball rolls in a bowl", "the bowl with a force held"),
    ("all states read, 60 times a second", "the bowl with no states read", "a ball rolls in a bowl"),
    ("impacts of many bodies", "cradle with gaps", "cradle"),
];

/// The scene whose ticks are measured with and without the server's layers.
const LAYERED: &str = "thousand";
const RATE_HZ: u32 = 60;
/// Simulated seconds of a round.
const ROUND_S: u32 = 1;

/// What a small scene costs, per ball and simulated second.
#[derive(Clone, Copy)]
struct Use {
    /// CPU time, µs.
    micros: f64,
    /// Instructions.
    instructions: f64,
}

/// Measures the small scenes and the server's layers, and puts the kept counts beside them.
pub fn measure(options: &Options, progress: &mut Progress<'_>) -> Result<Section, ReportError> {
    let mut uses = BTreeMap::new();
    for small in lone().into_iter().chain(everyday()) {
        if PAIRS.iter().any(|(_, without, with)| [*without, *with].contains(&small.name)) {
            progress(&format!("what features cost: {}", small.name));
            uses.insert(small.name, measure_small(&small)?);
        }
    }
    progress("what features cost: the server's layers");
    let layers = layers(if options.quick { 4 } else { 20 })?;
    Ok(section(&uses, &layers))
}

fn measure_small(small: &Small) -> Result<Use, ReportError> {
    let start = small
        .start()
        .map_err(|fault| ReportError::Variant { scene: small.name.to_owned(), fault: fault.into() })?;
    let work = f64::from(small.seconds) * small.scene.balls.len() as f64;
    let spent = cost(|| start.clone(), |engine| small.run(engine));
    let counted = kept_count(&format!("scene: {}", small.name));
    let instructions = counted * f64::from(small.seconds) / work;
    Ok(Use { micros: 1e6 * spent.seconds / work, instructions })
}

/// Instructions of one as they are kept; not a number if they are not.
fn kept_count(what: &str) -> f64 {
    let mut rows = rows_of(COUNTS).into_iter();
    rows.find(|row| row[0] == what).and_then(|row| row[2].parse().ok()).unwrap_or(f64::NAN)
}

/// Rows of a kept table, without its heading.
fn rows_of(text: &str) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let rows = reader.records().map(|row| row.expect("a table kept with the engine"));
    rows.map(|row| row.iter().map(str::to_owned).collect()).collect()
}

/// What the server adds to a tick of [`LAYERED`]: names, and µs a tick. The layers take turns, and of all rounds of each the
/// least counts.
fn layers(rounds: u32) -> Result<[(&'static str, f64); 4], ReportError> {
    let loaded = Arc::new(SceneText::open(LAYERED)?.load()?);
    let new = || Simulation::new(loaded.clone(), RATE_HZ, 1);
    let mut engine = loaded.controller()?;
    let (mut bare, mut hashed, mut remembered) = (new()?, new()?, new()?);
    let (archive, mut diary) = Archive::new(&remembered, Settings::live(DEFAULT_HISTORY_BYTES));
    let keeper = std::thread::spawn(move || archive.run());
    let mut least = [f64::INFINITY; 4];
    for round in 0..rounds {
        let mut tick = u64::from(round * ROUND_S * RATE_HZ);
        let mut hash = 0;
        let micros = [
            micros_a_tick(|| {
                tick += 1;
                engine.advance_to(ballroom_physics::Time::of_tick(tick, RATE_HZ));
            }),
            micros_a_tick(|| bare.advance()),
            micros_a_tick(|| {
                hashed.advance();
                hash ^= hashed.state_hash();
            }),
            micros_a_tick(|| {
                remembered.advance();
                diary.ticked(&remembered);
            }),
        ];
        std::hint::black_box(hash);
        for (least, micros) in least.iter_mut().zip(micros) {
            *least = least.min(micros);
        }
    }
    drop(diary);
    keeper.join().expect("the history's thread ends with its diary");
    let names = ["the engine alone", "the server's simulation", "and a hash of its state", "and a history"];
    Ok([0, 1, 2, 3].map(|i| (names[i], least[i])))
}

/// Time of this thread that a round of `tick` takes, µs a tick.
fn micros_a_tick(mut tick: impl FnMut()) -> f64 {
    let start = ThreadTime::now();
    (0..ROUND_S * RATE_HZ).for_each(|_| tick());
    1e6 * start.elapsed().as_secs_f64() / f64::from(ROUND_S * RATE_HZ)
}

fn section(uses: &BTreeMap<&str, Use>, layers: &[(&str, f64)]) -> Section {
    let unused = rows_of(WITHOUT);
    let percent = |row: &Vec<String>| row[4].parse().unwrap_or(f64::NAN);
    let above = unused.iter().filter(|row| !is_met(percent(row))).count();
    let mut section = Section::new("ablation", "What each feature costs");
    section.summary = html! {
        "Of " (unused.len()) " pairs of a feature and a scene that does not use it, " (unused.len() - above)
        " cost at most " (ALLOWED_PERCENT) " % of the scene’s instructions" @if above > 0 { ", " (above) " more" } "."
    }
    .into_string();
    section.html = html! {
        h3 { "Where it is used" }
        p {
            "Two scenes that differ in one feature; of one ball and one simulated second each, with its states read at "
            (RATE_HZ) " Hz. CPU time is measured in this run; instructions are kept with the engine."
        }
        (show_used(uses))
        h3 { "Where it is not used" }
        p {
            "The feature is cut out of a copy of the engine’s sources, both are built alike, and the instructions of "
            "scenes that have no use for it are counted. Kept with the engine, with the edits that cut."
        }
        (show_worst(&unused, percent))
        details { summary { "All " (unused.len()) " pairs" } (table(&UNUSED_HEADER, &unused)) }
        h3 { "Around the engine" }
        p {
            "CPU time of a tick of " code { (LAYERED) } " at " (RATE_HZ) " Hz; the layers take turns. Each is the simulation "
            "with that layer and no other."
        }
        (show_layers(layers))
    }
    .into_string();
    // What is kept with the engine has its file there.
    section.tables = vec![used_table(uses)];
    section.json = json_of(uses, &unused, layers);
    section
}

const UNUSED_HEADER: [&str; 5] =
    ["feature", "scene that does not use it", "instructions", "without", "per cent"];

/// What is not a number is not met.
fn is_met(percent: f64) -> bool {
    percent <= ALLOWED_PERCENT
}

fn change(without: f64, with: f64) -> String {
    format!("{:+.0} %", 100.0 * (with / without - 1.0)).replace('-', "−")
}

fn show_used(uses: &BTreeMap<&str, Use>) -> Markup {
    let row = |&(feature, without, with): &(&str, &str, &str)| {
        let (a, b) = (uses[without], uses[with]);
        vec![
            feature.to_owned(),
            format!("{without} → {with}"),
            plain(a.micros),
            plain(b.micros),
            change(a.micros, b.micros),
            grouped(a.instructions),
            grouped(b.instructions),
            change(a.instructions, b.instructions),
        ]
    };
    let header =
        ["feature", "scenes", "µs without", "µs with", "change", "instructions without", "with", "change"];
    table(&header, &PAIRS.iter().map(row).collect::<Vec<_>>())
}

/// For each feature the scene that pays most for not using it.
fn show_worst(unused: &[Vec<String>], percent: impl Fn(&Vec<String>) -> f64) -> Markup {
    let mut worst: Vec<&Vec<String>> = Vec::new();
    for row in unused {
        match worst.iter_mut().find(|worst| worst[0] == row[0]) {
            Some(known) if percent(known) < percent(row) => *known = row,
            Some(_) => {}
            None => worst.push(row),
        }
    }
    let verdict = |row: &Vec<String>| if is_met(percent(row)) { "met" } else { "falls short" };
    let shown = worst.iter().map(|row| {
        vec![
            row[0].clone(),
            row[1].clone(),
            format!("{:+.2} %", percent(row)).replace('-', "−"),
            verdict(row).into(),
        ]
    });
    let asked = format!("at most {ALLOWED_PERCENT} %");
    table(
        &["feature", "of the scenes without it, the one that pays most", "instructions", &asked],
        &shown.collect::<Vec<_>>(),
    )
}

fn show_layers(layers: &[(&str, f64)]) -> Markup {
    let alone = layers[0].1;
    let row = |&(name, micros): &(&str, f64)| vec![name.to_owned(), plain(micros), change(alone, micros)];
    table(&["", "µs a tick", "beside the engine alone"], &layers.iter().map(row).collect::<Vec<_>>())
}

fn used_table(uses: &BTreeMap<&str, Use>) -> Table {
    let mut table =
        Table::new("small_scenes", &["scene", "cpu_us_per_ball_second", "instructions_per_ball_second"]);
    for (name, used) in uses {
        table.push([(*name).to_owned(), numbers::csv(used.micros), numbers::csv(used.instructions)]);
    }
    table
}

fn json_of(uses: &BTreeMap<&str, Use>, unused: &[Vec<String>], layers: &[(&str, f64)]) -> Value {
    let number = |text: &String| numbers::json(text.parse().unwrap_or(f64::NAN));
    let used = uses.iter().map(|(name, used)| {
        json!({
            "scene": name,
            "cpu_us_per_ball_second": numbers::json(used.micros),
            "instructions_per_ball_second": numbers::json(used.instructions),
        })
    });
    let unused = unused.iter().map(|row| {
        json!({
            "feature": row[0],
            "scene": row[1],
            "instructions": number(&row[2]),
            "without": number(&row[3]),
            "per_cent": number(&row[4]),
        })
    });
    json!({
        "small_scenes": used.collect::<Vec<_>>(),
        "unused": unused.collect::<Vec<_>>(),
        "cpu_us_per_tick": layers.iter().map(|(name, micros)| json!({ "layer": name, "us": micros })).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_of_a_pair_has_a_kept_count() {
        for name in PAIRS.iter().flat_map(|(_, without, with)| [without, with]) {
            assert!(kept_count(&format!("scene: {name}")) > 0.0, "{name}: renew the counts");
        }
    }

    #[test]
    fn what_a_kept_table_adds_up_to_is_what_it_says() {
        for row in rows_of(WITHOUT) {
            let [with, without, percent] = [2, 3, 4].map(|i| row[i].parse::<f64>().unwrap());
            assert!((100.0 * (with / without - 1.0) - percent).abs() < 0.01, "{row:?}");
        }
    }
}
