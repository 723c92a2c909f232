//! The compiler that counts belong to.

use std::process::Command;

/// What counts depend on beside the code.
///
/// Callgrind knows no vectors wider than those of AVX2: a machine that has them counts like one with wider ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Toolchain {
    /// The compiler, as it names itself.
    pub rustc: String,
    /// What it builds for.
    pub target: String,
    /// How wide the vectors are that the engine chooses when it runs.
    pub vectors: String,
}

impl Toolchain {
    /// That of this build.
    pub fn here() -> Result<Self, String> {
        let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        let output = Command::new(rustc).arg("-vV").output().map_err(|e| format!("rustc -vV: {e}"))?;
        let text = String::from_utf8_lossy(&output.stdout);
        let target = text.lines().find_map(|line| line.strip_prefix("host: "));
        let rustc = text.lines().next();
        let (Some(rustc), Some(target)) = (rustc, target) else {
            return Err(format!("rustc -vV says nothing of its version: {text}"));
        };
        let vectors = if has_wide_vectors() { "vectors of 256 bits" } else { "vectors of 128 bits" };
        Ok(Self { rustc: rustc.to_owned(), target: target.to_owned(), vectors: vectors.to_owned() })
    }

    /// Lines for the top of a table.
    pub fn heading(&self) -> String {
        format!("# {}\n# {}\n# {}\n", self.rustc, self.target, self.vectors)
    }
}

#[cfg(target_arch = "x86_64")]
fn has_wide_vectors() -> bool {
    std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
}

#[cfg(not(target_arch = "x86_64"))]
const fn has_wide_vectors() -> bool {
    false
}
