//! A case: a run with an exact answer, and what is demanded of it.

use crate::demand::Demand;
use ballroom_physics::SceneFault;
use std::fmt;

/// What a case does when it is run: a number for each demand.
type Run = Box<dyn Fn() -> Result<Vec<f64>, SceneFault> + Send + Sync>;

/// A run with an exact answer.
pub struct Case {
    /// Unique: family, a slash and the variant, for instance `H2/3-in`.
    pub id: String,
    /// What happens, in a few words.
    pub title: String,
    /// What is demanded, one a row.
    pub demands: Vec<Demand>,
    run: Run,
}

impl Case {
    /// A case whose run gives one number for each demand.
    pub fn new<const N: usize>(
        id: impl Into<String>,
        title: impl Into<String>,
        demands: [Demand; N],
        run: impl Fn() -> Result<[f64; N], SceneFault> + Send + Sync + 'static,
    ) -> Self {
        Self::with(id, title, demands.into(), move || run().map(Vec::from))
    }

    /// The same where the number of demands depends on the case.
    pub fn with(
        id: impl Into<String>,
        title: impl Into<String>,
        demands: Vec<Demand>,
        run: impl Fn() -> Result<Vec<f64>, SceneFault> + Send + Sync + 'static,
    ) -> Self {
        Self { id: id.into(), title: title.into(), demands, run: Box::new(run) }
    }

    /// Runs it. The same case always measures the same bits. The error is that of a scene which should have been
    /// taken and was refused.
    pub fn run(&self) -> Result<Vec<Row>, SceneFault> {
        let measured = (self.run)()?;
        assert_eq!(measured.len(), self.demands.len(), "{}: a number for each demand", self.id);
        Ok(self
            .demands
            .iter()
            .zip(measured)
            .map(|(demand, measured)| Row { demand: demand.clone(), measured })
            .collect())
    }

    /// The rows of a case that could not be run: nothing measured, and so nothing met.
    pub fn unmeasured(&self) -> Vec<Row> {
        self.demands.iter().map(|demand| Row { demand: demand.clone(), measured: f64::NAN }).collect()
    }
}

impl fmt::Debug for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Case").field("id", &self.id).field("demands", &self.demands).finish_non_exhaustive()
    }
}

/// A demand and what was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What was demanded.
    pub demand: Demand,
    /// What was measured, in the demand's unit.
    pub measured: f64,
}

impl Row {
    /// Whether the demand is met. What is not a number meets none.
    pub fn is_met(&self) -> bool {
        self.measured <= self.demand.limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demand::Span;

    #[test]
    fn what_is_not_a_number_meets_no_demand() {
        let demand = Demand::over_ticks("centre", "m", Span::Seconds(1.0), 1.0);
        let case = Case::new("T/1", "numbers", [demand.clone(), demand.clone(), demand], || {
            Ok([1.0, f64::NAN, 1.0 + f64::EPSILON])
        });
        let met: Vec<bool> = case.run().unwrap().iter().map(Row::is_met).collect();
        assert_eq!(met, [true, false, false]);
        assert!(case.unmeasured().iter().all(|row| !row.is_met()));
    }
}
