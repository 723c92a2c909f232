//! A copy of the engine that can be cut and built.

use crate::cuts::Cut;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Kernels of floors that no counted scene has: left out, for the compiler takes most of its time for them.
const KERNELS_LEFT_OUT: [&str; 9] =
    ["Height2", "Height3", "Height4", "Height5", "Height6", "Height12", "Net3", "Net5", LAST_KERNEL];
/// The last that is asked for.
const LAST_KERNEL: &str = "Net12";
/// Vectors that callgrind cannot run.
const VECTORS_LEFT_OUT: &str = r#", "x86-v4""#;

/// Files and what stood in them.
pub type Files = BTreeMap<PathBuf, String>;

/// The copy; one place for all of its forms, so that they are compiled alike.
pub struct Workbench {
    copy: PathBuf,
}

impl Workbench {
    /// A fresh copy of the engine, its cases and its benches, without what no count can reach.
    pub fn new() -> Result<Self, String> {
        let engine = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
        let root = engine.ancestors().nth(2).ok_or("the engine lies in no workspace")?;
        let copy = target(root).join("ablation");
        if copy.join("server").exists() {
            fs::remove_dir_all(copy.join("server")).map_err(said(&copy))?;
        }
        copy_folder(&engine, &copy.join("server/physics"))?;
        let manifest = fs::read_to_string(root.join("Cargo.toml")).map_err(said(root))?;
        let alone = manifest.lines().map(|line| match line.split_once(" = ") {
            Some(("members", _)) => r#"members = ["server/physics", "server/physics/cases"]"#,
            Some(("default-members", _)) => "",
            _ => line,
        });
        let alone = alone.collect::<Vec<_>>().join("\n").replace(VECTORS_LEFT_OUT, "");
        write(&copy.join("Cargo.toml"), &alone)?;
        fs::copy(root.join("Cargo.lock"), copy.join("Cargo.lock")).map_err(said(root))?;
        let bench = Self { copy };
        bench.leave_out_kernels()?;
        Ok(bench)
    }

    /// Takes the choice of unneeded kernels out of the copy.
    fn leave_out_kernels(&self) -> Result<(), String> {
        let path = self.copied("surface/chart.rs");
        let mut text = fs::read_to_string(&path).map_err(said(&path))?;
        for kernel in KERNELS_LEFT_OUT {
            let arm = format!("$crate::surface::chart::Kernel::{kernel}($chart) => $body,");
            if !text.contains(&arm) {
                return Err(format!(
                    "surface/chart.rs has no `{arm}` any more: renew the kernels in benches/ablation/workbench.rs"
                ));
            }
            text = text.replace(&arm, if kernel == LAST_KERNEL { "_ => unreachable!()," } else { "" });
        }
        write(&path, &text)
    }

    /// Takes a feature out of the copy; returns the files as they were.
    pub fn cut(&self, cut: &Cut) -> Result<Files, String> {
        let mut before = Files::new();
        for (file, from, to) in cut.edits {
            let path = self.copied(file);
            let text = fs::read_to_string(&path).map_err(said(&path))?;
            if !text.contains(from) {
                return Err(format!(
                    "{file} holds no `{from}` any more: renew the cut of \"{}\" in benches/ablation/cuts.rs",
                    cut.feature
                ));
            }
            write(&path, &text.replace(from, to))?;
            before.entry(path).or_insert(text);
        }
        Ok(before)
    }

    /// Puts back what was cut.
    pub fn restore(before: &Files) -> Result<(), String> {
        before.iter().try_for_each(|(path, text)| write(path, text))
    }

    fn copied(&self, file: &str) -> PathBuf {
        self.copy.join("server/physics/src").join(file)
    }

    /// Builds the bench that counts instructions; returns the program.
    pub fn build(&self) -> Result<PathBuf, String> {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let output = Command::new(cargo)
            .args([
                "bench",
                "--offline",
                "--package",
                "ballroom-physics",
                "--bench",
                "instructions",
                "--no-run",
            ])
            .args(["--message-format", "json"])
            .env("CARGO_TARGET_DIR", self.copy.join("target"))
            .current_dir(&self.copy)
            .output()
            .map_err(|e| format!("cargo: {e}"))?;
        let told = String::from_utf8_lossy(&output.stdout);
        let program =
            told.lines().rev().find_map(|line| line.split_once(r#""executable":""#)?.1.split('"').next());
        match program {
            Some(program) if output.status.success() => Ok(PathBuf::from(program)),
            _ => Err(format!(
                "the engine on the bench does not build:\n{}",
                String::from_utf8_lossy(&output.stderr)
            )),
        }
    }
}

/// Where cargo puts what it builds.
fn target(root: &Path) -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from)
}

fn copy_folder(from: &Path, to: &Path) -> Result<(), String> {
    fs::create_dir_all(to).map_err(said(to))?;
    for entry in fs::read_dir(from).map_err(said(from))? {
        let entry = entry.map_err(said(from))?;
        let (path, kind) = (entry.path(), entry.file_type().map_err(said(from))?);
        let place = to.join(entry.file_name());
        if kind.is_dir() {
            copy_folder(&path, &place)?;
        } else {
            fs::copy(&path, &place).map_err(said(&path))?;
        }
    }
    Ok(())
}

fn write(file: &Path, text: &str) -> Result<(), String> {
    fs::write(file, text).map_err(said(file))
}

fn said(place: &Path) -> impl Fn(std::io::Error) -> String {
    move |error| format!("{}: {error}", place.display())
}
