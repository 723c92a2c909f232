//! What can be set in Rapier, and which settings a case is given.

use super::problem::{Ground, Problem};

/// Settings of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knobs {
    /// Steps a second.
    pub rate_hz: u32,
    /// Cells of the floor along a side.
    pub cells: usize,
    /// The floor as a height field instead of a mesh whose inner edges are mended.
    pub height_field: bool,
    /// Solver iterations, each with this many internal ones.
    pub iterations: [usize; 2],
    /// Natural frequency of contacts, as a part of the step rate; none leaves what Rapier sets.
    pub stiffness: Option<f64>,
    /// Contacts are foreseen this far, m.
    pub prediction: f64,
    /// Substeps of continuous collision detection; 0 switches it off.
    pub ccd: usize,
    /// Whether old contacts are used again while a pair hardly moves.
    pub recycling: bool,
}

impl Knobs {
    /// Rapier's own settings at a rate.
    pub const fn plain(rate_hz: u32) -> Self {
        Self {
            rate_hz,
            cells: 0,
            height_field: false,
            iterations: [4, 1],
            stiffness: None,
            prediction: 0.02,
            ccd: 0,
            recycling: true,
        }
    }

    /// The settings that a case is given: those that were best of many in some case, and the cheapest.
    pub fn tried(problem: &Problem) -> Vec<Self> {
        let cells = if problem.cells.is_empty() { &[0][..] } else { &problem.cells };
        let mut tried = vec![];
        for &cells in cells {
            for (n, &rate_hz) in problem.rates_hz.iter().enumerate() {
                let plain = Self { cells, ..Self::plain(rate_hz) };
                // Contacts that are used again cost least, and in a bowl most of the energy.
                let anew = Self { recycling: false, ..plain };
                tried.extend([plain, anew]);
                if problem.balls.len() > 1_000 || (n > 1 && problem.ground == Ground::Plane) {
                    continue;
                }
                tried.push(Self { iterations: [16, 1], ..anew });
                tried.push(match problem.ground {
                    Ground::Bowl(_) => Self { stiffness: Some(0.125), prediction: 0.002, ..anew },
                    Ground::Plane => Self { ccd: 1, ..anew },
                });
                if n == 0 {
                    tried.push(Self { iterations: [1, 1], ..anew });
                    let other = Self { height_field: true, ..anew };
                    tried.extend((problem.ground != Ground::Plane).then_some(other));
                }
            }
        }
        tried
    }

    /// In few words; what is Rapier's own goes without saying.
    pub fn words(&self) -> String {
        let mut words = vec![format!("{} Hz", self.rate_hz)];
        let plain = Self::plain(self.rate_hz);
        if self.cells > 0 {
            words.push(format!(
                "{} cells{}",
                self.cells,
                if self.height_field { " (height field)" } else { "" }
            ));
        }
        if self.iterations != plain.iterations {
            words.push(format!("{} x {} iterations", self.iterations[0], self.iterations[1]));
        }
        if let Some(part) = self.stiffness {
            words.push(format!("contacts of {:.0} Hz", part * f64::from(self.rate_hz)));
        }
        if self.prediction != plain.prediction {
            words.push(format!("foresight {} mm", 1e3 * self.prediction));
        }
        if self.ccd > 0 {
            words.push(format!("CCD {}", self.ccd));
        }
        if !self.recycling {
            words.push("contacts anew".into());
        }
        words.join(", ")
    }
}
