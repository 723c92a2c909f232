//! Speed against error: a scene is run over integrators, steps and tolerances, and a folder is written with a page, the
//! numbers as CSV, and all of it as JSON.
//!
//! Here is the clock that the engine does without. Nothing in a report is known beforehand: every number and every
//! sentence with a number in it comes from the runs that were just made.
//!
//! | file | what |
//! |---|---|
//! | [`section`] | a part of the page: prose and pictures, tables, JSON |
//! | [`page`] | sections to a folder |
//! | [`plot`] | curves with logarithmic axes to SVG |
//! | [`numbers`] | numbers as people read them |
//! | [`chapter`] | all that is said of one scene |
//! | [`subject`] | a scene that is measured, and the settings it is run with |
//! | [`mod@reference`] | what is taken for true, how far it is, and for how long |
//! | [`work_precision`] | error against cost |
//! | [`horizon`] | until when an error has a meaning |
//! | [`orders`], [`fit`] | how fast errors fall; straight lines through points |
//! | [`energy`] | what becomes of it in a long run |
//! | [`scaling`] | cost and hits against the number of balls |
//! | [`ticks`] | how long they take, and which bits come out |
//! | [`phases`], [`replay`] | where the time goes; a run's work done again, kind by kind |
//! | [`hard_cases`] | what is demanded, and what is done |
//! | [`ablation`] | what each feature costs, used and not |
//! | [`clock`] | CPU time of a piece of work |
//! | [`machine`] | what it was measured on |

pub mod ablation;
pub mod chapter;
pub mod clock;
pub mod energy;
pub mod fit;
pub mod hard_cases;
pub mod horizon;
pub mod machine;
pub mod numbers;
pub mod orders;
pub mod page;
pub mod phases;
pub mod plot;
pub mod reference;
pub mod replay;
pub mod scaling;
pub mod section;
pub mod subject;
pub mod ticks;
pub mod work_precision;

pub use page::Page;
pub use section::{Section, Table};
pub use subject::Subject;

use crate::SceneError;
use ballroom_physics::SceneFault;
use std::path::PathBuf;

/// What a report is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Less of everything: fewer settings, shorter spans, fewer cases.
    pub quick: bool,
    /// The folder it is written to.
    pub out: PathBuf,
    /// Names of scenes, or files; `gas:1000` is a scene with that many balls. None means the usual ones.
    pub scenes: Vec<String>,
    /// The command line, for the page.
    pub command: String,
}

/// Is told in a few words what is being measured.
pub type Progress<'a> = dyn FnMut(&str) + 'a;

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A scene cannot be run.
    #[error("{0}")]
    Scene(Box<SceneError>),
    /// A scene that was taken is refused with another accuracy or other balls.
    #[error("{scene}: {fault}")]
    Variant {
        /// Which one.
        scene: String,
        /// Why.
        fault: Box<SceneFault>,
    },
    /// The folder holds something else.
    #[error("{} is there already and is no report: name another folder with --out", .0.display())]
    NotAReport(PathBuf),
    /// Two tables of one name do not have the same columns.
    #[error("the tables named {0} do not have the same columns")]
    Columns(String),
    /// A picture cannot be drawn.
    #[error("a picture cannot be drawn: {0}")]
    Plot(String),
    /// A file cannot be written.
    #[error("{} cannot be written: {why}", path.display())]
    Write {
        /// Which one.
        path: PathBuf,
        /// Why.
        why: std::io::Error,
    },
}

/// What is measured when no scene is named.
const USUAL: [&str; 4] = ["bicubic", "bowl", "break", "gas:1000"];

impl From<SceneError> for ReportError {
    fn from(fault: SceneError) -> Self {
        Self::Scene(Box::new(fault))
    }
}

/// Every section that needs no more than the engine: measures all of it, which takes minutes.
pub fn sections(options: &Options, progress: &mut Progress<'_>) -> Result<Vec<Section>, ReportError> {
    let mut sections = chapters(options, progress)?;
    sections.push(hard_cases::measure(options, progress));
    sections.push(ablation::measure(options, progress)?);
    Ok(sections)
}

/// A section a scene.
pub fn chapters(options: &Options, progress: &mut Progress<'_>) -> Result<Vec<Section>, ReportError> {
    let usual = USUAL.map(str::to_owned);
    let asked = if options.scenes.is_empty() { &usual[..] } else { &options.scenes[..] };
    // All of them first, so that a slip of the pen is told before anything is measured.
    let subjects = asked.iter().map(|name| Subject::open(name)).collect::<Result<Vec<_>, _>>()?;
    let mut chapters: Vec<Section> = Vec::new();
    for subject in &subjects {
        let mut chapter = chapter::measure(subject, options, progress)?;
        let same =
            chapters.iter().filter(|known| known.title == chapter.title || known.id == chapter.id).count();
        if same > 0 {
            chapter.id = format!("{}-{}", chapter.id, same + 1);
        }
        chapters.push(chapter);
    }
    Ok(chapters)
}

#[cfg(test)]
mod tests;
