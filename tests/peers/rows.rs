//! What was measured, and what follows from it: best rows, ratios, and where a peer wins.

use serde::Serialize;

/// One contestant at one setting in one case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name of the engine.
    pub engine: String,
    /// Its settings.
    pub setting: String,
    /// CPU seconds per simulated second.
    pub cost: f64,
    /// In the case's norm; infinite where the run ended in no numbers.
    pub error: f64,
    /// Energy at the end over that of the start, less 1.
    pub energy_change: f64,
    /// Deepest overlap of two balls at any sample, in radii.
    pub overlap: f64,
    /// Hits in the run, where they are counted.
    pub hits: Option<u64>,
    /// The same for each simulated second.
    pub hits_per_second: Option<f64>,
}

/// Errors below this count as even: what is left is rounding.
pub const ROUNDING: f64 = 1e-13;
/// Overlaps below this part of a radius count as none.
pub const TOUCH: f64 = 1e-9;

/// Engines in the order of their first rows.
pub fn engines(rows: &[Row]) -> Vec<&str> {
    let mut engines: Vec<&str> = vec![];
    for row in rows {
        if !engines.contains(&row.engine.as_str()) {
            engines.push(&row.engine);
        }
    }
    engines
}

/// The rows of one engine.
pub fn of<'a>(rows: &'a [Row], engine: &str) -> Vec<&'a Row> {
    rows.iter().filter(|row| row.engine == engine).collect()
}

/// The row of least error, and of these the cheapest. None among no rows.
pub fn most_accurate<'a>(rows: &[&'a Row]) -> Option<&'a Row> {
    rows.iter().copied().min_by(|a, b| a.error.total_cmp(&b.error).then(a.cost.total_cmp(&b.cost)))
}

/// The row of least cost. None among no rows.
pub fn cheapest<'a>(rows: &[&'a Row]) -> Option<&'a Row> {
    rows.iter().copied().min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// How a peer at its best error compares with us.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ratios {
    /// The peer's CPU time over that of our cheapest row that is at least as accurate; none if no row of ours is.
    pub less_cpu: Option<f64>,
    /// The peer's error over that of our most accurate row that is no dearer; none if every row of ours is dearer.
    pub less_error: Option<f64>,
}

/// Both ratios against the peer's row.
pub fn ratios(ours: &[&Row], peer: &Row) -> Ratios {
    let accurate: Vec<&Row> =
        ours.iter().copied().filter(|row| row.error <= peer.error.max(ROUNDING)).collect();
    let affordable: Vec<&Row> = ours.iter().copied().filter(|row| row.cost <= peer.cost).collect();
    Ratios {
        less_cpu: cheapest(&accurate).map(|row| peer.cost / row.cost),
        less_error: most_accurate(&affordable).map(|row| quotient(peer.error, row.error)),
    }
}

fn quotient(peer: f64, ours: f64) -> f64 {
    if peer.max(ours) <= ROUNDING { 1.0 } else { peer / ours }
}

/// What a peer does better than every row of ours.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "in")]
pub enum Win {
    /// It costs less than any row of ours.
    Cost {
        /// The peer's row.
        row: Row,
        /// Our least cost, CPU seconds per simulated second.
        ours: f64,
    },
    /// It is more accurate than any row of ours.
    Error {
        /// The peer's row.
        row: Row,
        /// Our least error.
        ours: f64,
    },
    /// It is between rows of ours: none is at least as cheap and as accurate.
    Both {
        /// The peer's row.
        row: Row,
    },
    /// Balls overlap less than in any row of ours.
    Overlap {
        /// The peer's row.
        row: Row,
        /// Our least overlap, in radii.
        ours: f64,
    },
}

/// Where peers win in a case. A row whose run ended in no numbers wins nothing; of several rows of one engine that win in
/// the same way the best is named.
pub fn wins(rows: &[Row], us: &str) -> Vec<Win> {
    let ours = of(rows, us);
    let (Some(own_cheapest), Some(own_best)) = (cheapest(&ours), most_accurate(&ours)) else { return vec![] };
    let own_overlap = ours.iter().map(|row| row.overlap).fold(f64::INFINITY, f64::min);
    let mut wins = vec![];
    for engine in engines(rows).into_iter().filter(|engine| *engine != us) {
        let valid: Vec<&Row> = of(rows, engine).into_iter().filter(|row| row.error.is_finite()).collect();
        let Some(cheap) = cheapest(&valid) else { continue };
        if cheap.cost < own_cheapest.cost {
            wins.push(Win::Cost { row: cheap.clone(), ours: own_cheapest.cost });
        }
        if let Some(best) =
            most_accurate(&valid).filter(|best| best.error < own_best.error && own_best.error > ROUNDING)
        {
            wins.push(Win::Error { row: best.clone(), ours: own_best.error });
        }
        let beaten =
            |row: &Row| ours.iter().any(|own| own.cost <= row.cost && own.error <= row.error.max(ROUNDING));
        let between: Vec<&Row> =
            valid.iter().copied().filter(|row| !beaten(row) && inside(row, &ours)).collect();
        if let Some(row) = most_accurate(&between) {
            wins.push(Win::Both { row: row.clone() });
        }
        let shallow = valid.iter().min_by(|a, b| a.overlap.total_cmp(&b.overlap));
        if let Some(row) = shallow.filter(|row| row.overlap < own_overlap && own_overlap > TOUCH) {
            wins.push(Win::Overlap { row: (*row).clone(), ours: own_overlap });
        }
    }
    wins
}

/// Whether it is neither cheaper nor more accurate than all of ours, which is said elsewhere.
fn inside(row: &Row, ours: &[&Row]) -> bool {
    ours.iter().any(|own| own.cost <= row.cost) && ours.iter().any(|own| own.error <= row.error)
}
