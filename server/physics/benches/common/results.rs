//! What a bench found, printed, and with `--save` kept for this machine.
//!
//! `cargo bench ... -- --save` writes `server/benches/results/<processor>/<bench>.txt`: the table as it was printed under the
//! machine, the compiler, the commit, the day and the command it belongs to. Such files are committed; figures of different
//! machines stand side by side, and what a commit changed shows in their history.

use std::fmt::{Display, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A bench's table.
pub struct Results {
    bench: &'static str,
    text: String,
}

impl Results {
    /// Of the bench of that name.
    pub const fn of(bench: &'static str) -> Self {
        Self { bench, text: String::new() }
    }

    /// Prints a line and remembers it.
    pub fn line(&mut self, line: impl Display) {
        println!("{line}");
        writeln!(self.text, "{line}").expect("a string takes all");
    }

    /// Keeps the lines if `--save` was asked for.
    pub fn finish(&self) -> std::io::Result<()> {
        if !std::env::args().any(|a| a == "--save") {
            return Ok(());
        }
        let folder = folder().join(slug(&processor()));
        std::fs::create_dir_all(&folder)?;
        let file = folder.join(self.bench).with_extension("txt");
        std::fs::write(&file, format!("{}\n{}", heading(self.bench), self.text))?;
        println!("kept in {}", file.display());
        Ok(())
    }
}

/// `server/benches/results`, from whichever crate the bench belongs to.
fn folder() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let server = here.ancestors().find(|place| place.ends_with("server")).unwrap_or(here);
    server.join("benches").join("results")
}

fn heading(bench: &str) -> String {
    let cores = std::thread::available_parallelism().map_or(0, std::num::NonZero::get);
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let said = |program: &str, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).output().ok();
        let said = output.map(|o| String::from_utf8_lossy(&o.stdout).trim().to_owned());
        said.filter(|text| !text.is_empty()).unwrap_or_else(|| "unknown".to_owned())
    };
    format!(
        "# {}, {cores} cores, {} {}\n# {}\n# commit {}, {}\n# cargo bench --workspace --bench {bench} -- {}\n",
        processor(),
        std::env::consts::OS,
        std::env::consts::ARCH,
        said("rustc", &["--version"]),
        said("git", &["describe", "--always", "--dirty"]),
        said("date", &["-u", "+%Y-%m-%d"]),
        arguments.join(" "),
    )
}

/// What the processor calls itself.
fn processor() -> String {
    let known = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    known.unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

/// Small letters and digits, and a dash for all between.
fn slug(name: &str) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.map(str::to_ascii_lowercase).collect::<Vec<_>>().join("-")
}
