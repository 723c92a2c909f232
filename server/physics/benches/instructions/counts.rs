//! Counts as they are kept beside this file, and what has become of them.

use crate::callgrind::Count;
use crate::toolchain::Toolchain;
use std::fmt::Write as _;
use std::path::PathBuf;

/// A count that grows or shrinks by more is told, %.
///
/// The same compiler counts the same to the last instruction; other code in the crate moves a kernel's by less
/// than one per cent, through what is inlined where.
const ALLOWED_PERCENT: f64 = 3.0;

/// Counts and what they were taken with.
#[derive(Clone, Debug, PartialEq)]
pub struct Counts {
    /// With what.
    pub toolchain: Toolchain,
    /// In the order in which they are taken.
    pub rows: Vec<Count>,
}

/// Where counts are kept.
pub fn file() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "benches", "instructions", "counts.csv"].iter().collect()
}

impl Counts {
    /// Those that are kept.
    pub fn kept() -> Result<Self, String> {
        let file = file();
        let text = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
        Self::read(&text).map_err(|e| format!("{}: {e}", file.display()))
    }

    /// Keeps these.
    pub fn keep(&self) -> Result<(), String> {
        let file = file();
        std::fs::write(&file, self.write()).map_err(|e| format!("{}: {e}", file.display()))
    }

    fn write(&self) -> String {
        let mut text = format!("{}what,times,instructions of one\n", self.toolchain.heading());
        for Count { name, times, each } in &self.rows {
            writeln!(text, "{name},{times},{each:.1}").expect("a string takes all");
        }
        text
    }

    fn read(text: &str) -> Result<Self, String> {
        let mut heads = text.lines().filter_map(|line| line.strip_prefix("# "));
        let mut head =
            || heads.next().map(str::to_owned).ok_or("the compiler, its target or the vectors are missing");
        let toolchain = Toolchain { rustc: head()?, target: head()?, vectors: head()? };
        let row = |line: &str| {
            let (name, numbers) = line.split_once(',')?;
            let (times, each) = numbers.split_once(',')?;
            Some(Count { name: name.to_owned(), times: times.parse().ok()?, each: each.parse().ok()? })
        };
        let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
        let rows = lines.map(|line| row(line).ok_or_else(|| format!("not a count: {line}")));
        Ok(Self { toolchain, rows: rows.collect::<Result<_, _>>()? })
    }

    /// What has changed since `kept`, by more than is allowed.
    pub fn since(&self, kept: &Self) -> Changes {
        let mut changes = Changes::default();
        for now in &self.rows {
            let Some(before) = kept.rows.iter().find(|row| row.name == now.name) else {
                changes.other.push(format!("{}: {:.0} instructions, not counted before", now.name, now.each));
                continue;
            };
            let percent = 100.0 * (now.each / before.each - 1.0);
            let line = format!(
                "{}: {:.0} -> {:.0} instructions, {percent:+.1} % (allowed {ALLOWED_PERCENT} %)",
                now.name, before.each, now.each
            );
            if percent > ALLOWED_PERCENT {
                changes.worse.push(line);
            } else if percent < -ALLOWED_PERCENT {
                changes.other.push(line);
            }
        }
        let gone = kept.rows.iter().filter(|row| self.rows.iter().all(|now| now.name != row.name));
        changes.other.extend(gone.map(|row| format!("{}: counted no more", row.name)));
        changes
    }
}

/// What counts have become, a line each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// What takes more instructions.
    pub worse: Vec<String>,
    /// What takes fewer, is new or is gone.
    pub other: Vec<String>,
}
