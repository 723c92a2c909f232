//! What a feature costs the scenes that do not use it: instructions beside those of an engine without it.
//!
//! `cargo bench -p ballroom-physics --bench ablation`, or with `-- --save` to keep the table in `table.csv` beside this file. For
//! each feature the engine's sources are copied, the feature is cut out of the copy, both are built alike, and callgrind counts
//! the small scenes that have no use for it. The copies have the kernels of those scenes' floors only, so that counts differ a
//! little from those of `instructions`; yet it takes some minutes: every engine is compiled anew. `-- --check` only says
//! whether every feature can still be cut out.
//!
//! A count also moves where the compiler puts registers and calls otherwise. How much that is the table says itself: no scene on
//! a plane runs an instruction of "other integrators and fixed steps", and without them a hit there takes up to 2 % less.

#[path = "../instructions/callgrind.rs"]
mod callgrind;
mod cuts;
#[path = "../instructions/toolchain.rs"]
mod toolchain;
mod workbench;

use callgrind::Count;
use cuts::CUTS;
use std::fmt::Write as _;
use std::path::PathBuf;
use toolchain::Toolchain;
use workbench::Workbench;

/// A scene that does not use a feature.
struct Row {
    feature: &'static str,
    scene: String,
    /// Instructions of the engine as it is, and of one without the feature.
    each: [f64; 2],
}

impl Row {
    /// What the feature adds, %.
    fn percent(&self) -> f64 {
        100.0 * (self.each[0] / self.each[1] - 1.0)
    }
}

fn main() {
    if let Err(error) = run() {
        eprintln!("error: {error}");
        std::process::exit(1);
    }
}

fn run() -> Result<(), String> {
    let bench = Workbench::new()?;
    if std::env::args().any(|a| a == "--check") {
        for cut in CUTS {
            Workbench::restore(&bench.cut(cut)?)?;
        }
        println!("{} features, each can be cut out", CUTS.len());
        return Ok(());
    }
    let scenes: Vec<&str> = CUTS.iter().flat_map(|cut| cut.unused_by).copied().collect();
    let whole = counted(&bench, &scenes)?;
    let mut rows = vec![];
    let saves = std::env::args().any(|a| a == "--save");
    println!("{:<48}{:<40}{:>14}{:>14}", "feature", "scene that does not use it", "instructions", "without");
    for cut in CUTS {
        let before = bench.cut(cut)?;
        let without = counted(&bench, cut.unused_by)?;
        Workbench::restore(&before)?;
        for without in without {
            let with =
                whole.iter().find(|with| with.name == without.name).ok_or("a scene that was not counted")?;
            let row = Row { feature: cut.feature, scene: without.name, each: [with.each, without.each] };
            let [with, without] = row.each;
            println!(
                "{:<48}{:<40}{with:>14.1}{without:>14.1}{:>+8.2} %",
                row.feature,
                row.scene,
                row.percent()
            );
            rows.push(row);
        }
        if saves {
            save(&rows)?;
        }
    }
    Ok(())
}

/// Instructions of the small scenes of these names in the engine that lies on the bench.
fn counted(bench: &Workbench, scenes: &[&str]) -> Result<Vec<Count>, String> {
    let program = bench.build()?;
    let scenes: Vec<String> = scenes.iter().map(|&scene| scene.to_owned()).collect();
    callgrind::counts(&program, &scenes)?.ok_or_else(|| callgrind::MISSING.to_owned())
}

fn save(rows: &[Row]) -> Result<(), String> {
    let mut text = Toolchain::here()?.heading();
    text.push_str("feature,scene that does not use it,instructions,without,per cent\n");
    for row in rows {
        let [with, without] = row.each;
        let percent = row.percent();
        writeln!(text, "{},{},{with:.1},{without:.1},{percent:.2}", row.feature, row.scene)
            .expect("a string takes all");
    }
    let file: PathBuf = [env!("CARGO_MANIFEST_DIR"), "benches", "ablation", "table.csv"].iter().collect();
    std::fs::write(&file, text).map_err(|e| format!("{}: {e}", file.display()))
}
