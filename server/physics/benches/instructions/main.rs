//! Instructions of kernels and of small scenes, compared with counts kept in `counts.csv`: what a noisy machine cannot blur.
//!
//! ```text
//! cargo bench -p ballroom-physics --bench instructions               what each takes, beside what is kept
//! cargo bench -p ballroom-physics --bench instructions -- --check    the same, and fails on a regression
//! cargo bench -p ballroom-physics --bench instructions -- --update   keeps the present counts
//! ```
//!
//! Callgrind runs every instruction in a machine of its own. Counts repeat to the last digit and are those of any x86-64
//! machine with vectors as wide; with others, or by another compiler, they are others and are not judged.
//! `BALLROOM_REQUIRE_VALGRIND=1` makes a missing valgrind a failure.

mod callgrind;
mod counted;
mod counts;
mod kernels;
mod scenes;
mod toolchain;

use counts::Counts;
use std::process::ExitCode;
use toolchain::Toolchain;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if counted::is_counted() {
        // Beginnings of names may be given: the ablation bench asks for some scenes only.
        let wanted =
            |name: &str| arguments.is_empty() || arguments.iter().any(|start| name.starts_with(start));
        if arguments.is_empty() {
            kernels::run();
        }
        scenes::run(wanted);
        return ExitCode::SUCCESS;
    }
    let asked = |flag: &str| arguments.iter().any(|a| a == flag);
    match compare(asked("--check"), asked("--update")) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn compare(check: bool, update: bool) -> Result<ExitCode, String> {
    let program = std::env::current_exe().map_err(|e| e.to_string())?;
    let Some(rows) = callgrind::counts(&program, &[])? else {
        eprintln!("skipped: {}", callgrind::MISSING);
        let required = std::env::var("BALLROOM_REQUIRE_VALGRIND").is_ok_and(|v| v == "1");
        return Ok(if required { ExitCode::FAILURE } else { ExitCode::SUCCESS });
    };
    let now = Counts { toolchain: Toolchain::here()?, rows };
    if update {
        now.keep()?;
    }
    let kept = Counts::kept()?;
    show(&now, &kept);
    let changes = now.since(&kept);
    changes.other.iter().for_each(|line| println!("note: {line}"));
    changes.worse.iter().for_each(|line| println!("slower: {line}"));
    if changes == counts::Changes::default() {
        println!("{} counts, all as kept", now.rows.len());
        return Ok(ExitCode::SUCCESS);
    }
    let keep = "cargo bench -p ballroom-physics --bench instructions -- --update";
    if now.toolchain != kept.toolchain {
        println!(
            "kept with:\n{}counted with:\n{}Not judged.",
            kept.toolchain.heading(),
            now.toolchain.heading()
        );
        println!("Keep the counts of this compiler from a commit known to be good: {keep}");
        return Ok(ExitCode::SUCCESS);
    }
    println!("Mend what is slower, or say in the commit why it must be and keep the new counts: {keep}");
    Ok(if check && !changes.worse.is_empty() { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn show(now: &Counts, kept: &Counts) {
    println!("{:<52}{:>14}{:>14}{:>9}", "", "instructions", "kept", "");
    for row in &now.rows {
        let before = kept.rows.iter().find(|before| before.name == row.name).map_or(f64::NAN, |b| b.each);
        let percent = 100.0 * (row.each / before - 1.0);
        println!("{:<52}{:>14.1}{before:>14.1}{percent:>+8.2} %", row.name, row.each);
    }
}
