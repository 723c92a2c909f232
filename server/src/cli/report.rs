//! `report`: speed against error, as a page.

use indicatif::{ProgressBar, ProgressStyle};
use server::report::{Options, Page, sections};
use std::io::Write;
use std::path::PathBuf;

/// Measure speed against error and write a page with pictures, CSV and JSON
#[derive(clap::Args)]
#[command(after_help = "\
Each scene is run over integrators, steps and tolerances. Errors are the largest distance of any ball's centre from a
reference over all ticks of 60 Hz; the reference is checked against another one. A scene that forgets its past is followed
until its error has no meaning any more. A folder that holds anything but a report is left alone.

Examples:
  ballroom report --quick
  ballroom report my_scene.toml --out my_report
  ballroom report gas:1000 bicubic")]
pub struct Report {
    /// Names of built-in scenes, or files ending in .toml; NAME:N is a scene with one cloud and N balls in all
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Fewer settings, shorter spans, fewer cases: under a minute for the usual scenes
    #[arg(long)]
    quick: bool,
    /// The folder to write
    #[arg(long, value_name = "DIR", default_value = "report")]
    out: PathBuf,
}

impl Report {
    pub fn run(self) -> anyhow::Result<()> {
        let command = std::env::args().skip(1).fold("ballroom".to_owned(), |line, word| line + " " + &word);
        let options = Options { quick: self.quick, out: self.out, scenes: self.scenes, command };
        let mut page = Page::begin(&options)?;
        let bar = progress_bar();
        // Drawn when there is news only: a bar that ticks by itself would take CPU time that is measured.
        page.add(sections(&options, &mut |doing| bar.set_message(doing.to_owned()))?);
        bar.finish_and_clear();
        let path = page.write()?;
        writeln!(std::io::stdout().lock(), "{}", path.display())?;
        Ok(())
    }
}

/// Shown on stderr, and only when that is a terminal.
fn progress_bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{elapsed:>4} {msg}");
    ProgressBar::new_spinner().with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()))
}
