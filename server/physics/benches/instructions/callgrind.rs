//! A program run under callgrind, which counts the instructions inside its `gauge` and nowhere else.

use std::env;
use std::path::Path;
use std::process::Command;

/// Set for the program that is counted.
pub const INSIDE: &str = "BALLROOM_COUNTED";

/// What is said when there is no valgrind to run.
pub const MISSING: &str = "valgrind is not installed: install the package `valgrind` to count instructions";

/// Instructions of a piece of work done some number of times.
#[derive(Clone, Debug, PartialEq)]
pub struct Count {
    /// What was counted.
    pub name: String,
    /// How many times it was done.
    pub times: u64,
    /// Instructions of one, on the average.
    pub each: f64,
}

/// What `program` counts once [`INSIDE`] is set; None without valgrind.
pub fn counts(program: &Path, arguments: &[String]) -> Result<Option<Vec<Count>>, String> {
    let folder = env::temp_dir().join(format!("ballroom-counts-{}", std::process::id()));
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let counts = counts_in(&folder, program, arguments);
    std::fs::remove_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    counts
}

fn counts_in(folder: &Path, program: &Path, arguments: &[String]) -> Result<Option<Vec<Count>>, String> {
    let sums = folder.join("sums");
    let run = Command::new("valgrind")
        .args(["--tool=callgrind", "--quiet"])
        // Two patterns: callgrind takes only the first option given for one and the same.
        .args(["--toggle-collect=*::gauge*", "--dump-after=*gauge*"])
        .arg(format!("--callgrind-out-file={}", sums.display()))
        .arg(program)
        .args(arguments)
        .env(INSIDE, "1")
        // The C library copies memory as every x86-64 machine can, so that all machines count alike.
        .env("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX2,-AVX2_Usable,-AVX512F,-AVX512VL,-ERMS,-FSRM,-SSSE3")
        .output();
    let run = match run {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(format!("valgrind: {e}")),
        Ok(run) => run,
    };
    if !run.status.success() {
        return Err(format!("valgrind: {}\n{}", run.status, String::from_utf8_lossy(&run.stderr)));
    }
    let done = String::from_utf8_lossy(&run.stdout);
    let done: Vec<&str> = done.lines().collect();
    let count = |(place, line): (usize, &&str)| {
        let (name, times) = line.rsplit_once(',').ok_or_else(|| format!("not a count: {line}"))?;
        let times: u64 = times.parse().map_err(|e| format!("{line}: {e}"))?;
        let sum = total(&folder.join(format!("sums.{}", place + 1)))?;
        Ok(Count { name: name.to_owned(), times, each: sum as f64 / times as f64 })
    };
    done.iter().enumerate().map(count).collect::<Result<Vec<_>, String>>().map(Some)
}

/// The sum that callgrind wrote.
fn total(file: &Path) -> Result<u64, String> {
    let text = std::fs::read_to_string(file).map_err(|e| format!("{}: {e}", file.display()))?;
    let sum = text.lines().find_map(|line| line.strip_prefix("totals: "));
    let sum = sum.and_then(|sum| sum.trim().parse().ok()).filter(|sum| *sum > 0);
    sum.ok_or_else(|| format!("{}: callgrind counted nothing: is `gauge` still a function?", file.display()))
}
