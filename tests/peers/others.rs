//! Engines that have Python packages, run by `others.py`.

use super::problem::{Problem, Sample};
use serde::Deserialize;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};

/// What the script made of the cases.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Others {
    /// Runs, of any case.
    pub runs: Vec<Run>,
    /// Packages that are not installed.
    pub missing: Vec<String>,
}

/// One run.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Id of the problem.
    pub case: String,
    /// The engine and its version.
    pub engine: String,
    /// Its settings.
    pub setting: String,
    /// CPU seconds per simulated second.
    pub cpu_s_per_s: f64,
    /// The balls at every sample, the start included.
    pub samples: Vec<Sample>,
}

/// Why there are no others.
#[derive(Debug, thiserror::Error)]
pub enum OthersError {
    /// Not to be read.
    #[error("{what} cannot be read: {why}")]
    Read {
        /// A file, or the script.
        what: String,
        /// Why.
        why: std::io::Error,
    },
    /// More than [`MOST_BYTES`].
    #[error(
        "{0} says more than {MOST_BYTES} bytes, which no run of others.py does: name its output with --others"
    )]
    TooLong(String),
    /// No JSON of the script.
    #[error("{what} is not what others.py prints: {why}")]
    Json {
        /// A file, or the script.
        what: String,
        /// Why.
        why: serde_json::Error,
    },
    /// A run that does not fit its case.
    #[error("run {run} of {what}, {engine:?} in {case:?}: {why}")]
    Run {
        /// A file, or the script.
        what: String,
        /// Its place in the list.
        run: usize,
        /// The engine.
        engine: String,
        /// The case.
        case: String,
        /// What is wrong with it.
        why: &'static str,
    },
}

/// Longer outputs are refused.
const MOST_BYTES: u64 = 256 << 20;
/// More runs are refused.
const MOST_RUNS: usize = 1_000;
/// Longer names are refused.
const LONGEST_NAME: usize = 100;

impl Others {
    /// The runs of a case.
    pub fn of<'a>(&'a self, case: &'a str) -> impl Iterator<Item = &'a Run> {
        self.runs.iter().filter(move |run| run.case == case)
    }

    /// From a file that holds what the script printed.
    pub fn from_file(path: &Path, problems: &[Problem]) -> Result<Self, OthersError> {
        let what = path.display().to_string();
        let file = std::fs::File::open(path).map_err(|why| OthersError::Read { what: what.clone(), why })?;
        Self::parse(&bounded(file, &what)?, &what, problems)
    }

    /// From the script itself. Without the interpreter or the packages there is nothing to run, which is no error: the
    /// section says what is missing. What the script says of its progress goes to stderr.
    pub fn from_script(python: &str, problems: &[Problem]) -> Result<Self, OthersError> {
        let what = "others.py".to_owned();
        let failed = |why| OthersError::Read { what: what.clone(), why };
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("peers/others.py");
        let spawned = Command::new(python).arg(script).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
        let Ok(mut child) = spawned else {
            return Ok(Self { runs: vec![], missing: vec![python.to_owned()] });
        };
        // The script reads everything before it prints anything.
        let told = serde_json::to_vec(problems).expect("numbers and words");
        child.stdin.take().expect("a pipe").write_all(&told).map_err(failed)?;
        let said = bounded(child.stdout.take().expect("a pipe"), &what)?;
        let status = child.wait().map_err(failed)?;
        if !status.success() {
            return Err(failed(std::io::Error::other(format!("{python} ended with {status}"))));
        }
        Self::parse(&said, &what, problems)
    }

    /// Reads what the script printed, and refuses what cannot be from these problems.
    pub fn parse(text: &[u8], what: &str, problems: &[Problem]) -> Result<Self, OthersError> {
        let mut others: Self =
            serde_json::from_slice(text).map_err(|why| OthersError::Json { what: what.to_owned(), why })?;
        let wanted = |run: &Run| problems.iter().any(|problem| problem.id == run.case);
        // A file may hold more cases than are measured now.
        others.runs.retain(wanted);
        for (n, run) in others.runs.iter().enumerate() {
            let problem = problems.iter().find(|problem| problem.id == run.case);
            let why = if n >= MOST_RUNS {
                Some("more runs than settings")
            } else {
                problem.and_then(|p| fault(run, p))
            };
            if let Some(why) = why {
                let (engine, case) = (run.engine.clone(), run.case.clone());
                return Err(OthersError::Run { what: what.to_owned(), run: n, engine, case, why });
            }
        }
        Ok(others)
    }
}

/// What is wrong with a run.
fn fault(run: &Run, problem: &Problem) -> Option<&'static str> {
    let balls = problem.balls.len();
    let turning = if problem.rolls { balls } else { 0 };
    let fits = |s: &Sample| [s.centers.len(), s.velocities.len(), s.omegas.len()] == [balls, balls, turning];
    if !(run.cpu_s_per_s > 0.0 && run.cpu_s_per_s.is_finite()) {
        Some("its CPU time is not a positive number")
    } else if run.samples.len() as u64 != problem.samples() + 1 {
        Some("it does not have as many samples as the case")
    } else if !run.samples.iter().all(fits) {
        Some("a sample does not have as many balls as the case")
    } else if run.engine.len().max(run.setting.len()) > LONGEST_NAME {
        Some("a name is too long")
    } else {
        None
    }
}

/// All that is said, if it is not too much.
fn bounded(from: impl Read, what: &str) -> Result<Vec<u8>, OthersError> {
    let mut text = vec![];
    let read = from.take(MOST_BYTES + 1).read_to_end(&mut text);
    read.map_err(|why| OthersError::Read { what: what.to_owned(), why })?;
    if text.len() as u64 > MOST_BYTES {
        return Err(OthersError::TooLong(what.to_owned()));
    }
    Ok(text)
}
