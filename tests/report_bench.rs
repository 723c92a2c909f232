//! The page of `ballroom report`, with other engines beside ours in the same run:
//! `cargo bench --workspace --bench report [-- --quick] [--out DIR] [--case CASE]… [SCENE…]`.
//!
//! With `--problems FILE` it only writes what `peers/others.py` reads, so that the script can run elsewhere.

mod peers;

use clap::Parser;
use peers::others::{Others, OthersError};
use peers::problem::Problem;
use peers::{run, section, standard};
use server::report::{Options, Page, sections};
use std::path::PathBuf;

/// Measure speed against error, ours and of other engines, and write a page with pictures, CSV and JSON
#[derive(Parser)]
struct Arguments {
    /// Scenes for the sections about us alone, as for `ballroom report`
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Fewer settings, shorter spans, fewer and smaller cases
    #[arg(long)]
    quick: bool,
    /// The folder to write
    #[arg(long, value_name = "DIR", default_value = "report")]
    out: PathBuf,
    /// Only the section of peers
    #[arg(long)]
    peers_only: bool,
    /// Only cases whose names begin so
    #[arg(long = "case", value_name = "CASE")]
    cases: Vec<String>,
    /// The Python that runs peers/others.py; without the packages it asks for, they are left out
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: String,
    /// What peers/others.py printed, instead of running it
    #[arg(long, value_name = "FILE")]
    others: Option<PathBuf>,
    /// Write the cases for peers/others.py, and nothing else
    #[arg(long, value_name = "FILE")]
    problems: Option<PathBuf>,
    /// Given by cargo
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Cargo runs a bench in its package's folder; paths are meant from that of the workspace, where it was called.
    let package = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    if std::env::current_dir()? == package {
        std::env::set_current_dir(package.join(".."))?;
    }
    let arguments = Arguments::parse();
    let problems = chosen(&arguments);
    if let Some(path) = &arguments.problems {
        return Ok(std::fs::write(path, serde_json::to_vec(&problems)?)?);
    }
    let command = std::env::args()
        .skip(1)
        .filter(|word| word != "--bench")
        .fold("cargo bench --workspace --bench report --".to_owned(), |line, word| line + " " + &word);
    let options = Options {
        quick: arguments.quick,
        out: arguments.out.clone(),
        scenes: arguments.scenes.clone(),
        command,
    };
    let mut page = Page::begin(&options)?;
    let mut progress = |doing: &str| eprintln!("{doing}");
    if !arguments.peers_only {
        page.add(sections(&options, &mut progress)?);
    }
    let others = others(&arguments, &problems)?;
    let measured: Vec<run::Measured> = problems
        .into_iter()
        .map(|problem| run::measure(problem, &others, arguments.quick, &mut progress))
        .collect();
    page.add([section::section(&measured, &others)?]);
    println!("{}", page.write()?.display());
    Ok(())
}

fn chosen(arguments: &Arguments) -> Vec<Problem> {
    let wanted = |problem: &Problem| {
        arguments.cases.is_empty() || arguments.cases.iter().any(|case| problem.id.starts_with(case))
    };
    standard::problems(arguments.quick).into_iter().filter(wanted).collect()
}

fn others(arguments: &Arguments, problems: &[Problem]) -> Result<Others, OthersError> {
    match &arguments.others {
        Some(path) => Others::from_file(path, problems),
        None => Others::from_script(&arguments.python, problems),
    }
}
