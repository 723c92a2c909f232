//! `hardcases`: what is demanded of the engine, and what it does.

use ballroom_cases::{Case, Row, select};
use serde::Serialize;
use std::io::Write;
use std::time::Instant;

/// Run the hard cases and print what is demanded, what was measured and the verdict
#[derive(clap::Args)]
#[command(after_help = "\
Each case is a scene with an exact answer. A demand is met when the number measured is at most the one demanded. Ids
are chosen by how they begin; numbers in them are taken whole, so that H1 does not mean H10. B16, B19 and B20 stand among
the hard cases, as H1, H3/fifth and H2. The time is wall time of the whole case, on one thread. The exit code is 1 if a demand is not met.

Examples:
  ballroom hardcases
  ballroom hardcases H1 X3/square
  ballroom hardcases --list
  ballroom hardcases H5 --json")]
pub struct Hardcases {
    /// How the ids of the cases begin; all cases if there is none
    #[arg(value_name = "ID-PREFIX")]
    prefixes: Vec<String>,
    /// Print ids and titles, and run nothing
    #[arg(long)]
    list: bool,
    /// A line of JSON a demand
    #[arg(long, conflicts_with = "list")]
    json: bool,
}

/// Demands were not met.
#[derive(Debug, thiserror::Error)]
#[error("{short} of {rows} demands are not met")]
struct FallsShort {
    short: usize,
    rows: usize,
}

/// A demand as a line of JSON.
#[derive(Serialize)]
struct Line<'a> {
    case: &'a str,
    title: &'a str,
    quantity: &'a str,
    unit: &'a str,
    norm: &'a str,
    span: String,
    demanded: f64,
    /// None where it is no finite number.
    measured: Option<f64>,
    met: bool,
    case_wall_millis: f64,
}

impl Hardcases {
    pub fn run(self) -> anyhow::Result<()> {
        let cases = select(&self.prefixes)?;
        let mut out = std::io::stdout().lock();
        if self.list {
            for case in &cases {
                writeln!(out, "{:28} {}", case.id, case.title)?;
            }
            return Ok(());
        }
        self.measure(&cases, &mut out)
    }

    /// Runs the cases and prints each as soon as it is measured.
    fn measure(&self, cases: &[Case], out: &mut impl Write) -> anyhow::Result<()> {
        let (mut rows, mut short) = (0, 0);
        for case in cases {
            let start = Instant::now();
            let (measured, fault) = match case.run() {
                Ok(measured) => (measured, None),
                Err(fault) => (case.unmeasured(), Some(fault.to_string())),
            };
            let millis = start.elapsed().as_secs_f64() * 1e3;
            rows += measured.len();
            short += measured.iter().filter(|row| !row.is_met()).count();
            if let Some(fault) = fault {
                eprintln!("ballroom: case {}: the scene is refused: {fault}", case.id);
            }
            if self.json {
                json(out, case, &measured, millis)?;
            } else {
                table(out, case, &measured, millis)?;
            }
        }
        if !self.json {
            writeln!(out, "{} cases, {rows} demands, {short} not met", cases.len())?;
        }
        if short > 0 { Err(FallsShort { short, rows }.into()) } else { Ok(()) }
    }
}

/// A case's rows as lines that people read: the title once, then a line a demand.
fn table(out: &mut impl Write, case: &Case, rows: &[Row], millis: f64) -> std::io::Result<()> {
    writeln!(out, "{:24} {} ({millis:.1} ms)", case.id, case.title)?;
    for row in rows {
        let demand = &row.demand;
        let verdict = if row.is_met() { "ok" } else { "FALLS SHORT" };
        let what = format!("{}, {}, {}", demand.quantity, demand.norm, demand.span);
        let (demanded, measured, unit) = (demand.limit, row.measured, demand.unit);
        writeln!(out, "    {what:68} demanded {demanded:7.0e} {unit:6} measured {measured:9.2e}  {verdict}")?;
    }
    out.flush()
}

fn json(out: &mut impl Write, case: &Case, rows: &[Row], millis: f64) -> anyhow::Result<()> {
    for row in rows {
        let demand = &row.demand;
        let line = Line {
            case: &case.id,
            title: &case.title,
            quantity: demand.quantity,
            unit: demand.unit,
            norm: demand.norm,
            span: demand.span.to_string(),
            demanded: demand.limit,
            measured: row.measured.is_finite().then_some(row.measured),
            met: row.is_met(),
            case_wall_millis: millis,
        };
        serde_json::to_writer(&mut *out, &line)?;
        writeln!(out)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballroom_cases::{Demand, Span};
    use ballroom_physics::SceneFault;

    fn demand() -> Demand {
        Demand { quantity: "energy", unit: "1", norm: "largest", span: Span::Seconds(1.0), limit: 1e-10 }
    }

    fn refused() -> SceneFault {
        SceneFault::Number { field: "gravity".to_owned(), value: f64::NAN, want: "finite" }
    }

    /// The verdict on a case that measures this, and what is printed.
    fn verdict(json: bool, measured: Result<f64, SceneFault>) -> (anyhow::Result<()>, String) {
        let case = Case::new("T/made-up", "a made-up case", [demand()], move || Ok([measured.clone()?]));
        let mut out = Vec::new();
        let verdict = Hardcases { prefixes: vec![], list: false, json }.measure(&[case], &mut out);
        (verdict, String::from_utf8(out).unwrap())
    }

    #[test]
    fn a_demand_that_is_not_met_is_an_error_and_said_in_its_row() {
        let (met, said) = verdict(false, Ok(1e-10));
        assert!(met.is_ok() && said.contains("1 cases, 1 demands, 0 not met"), "{said}");
        for measured in [Ok(1.001e-10), Ok(f64::NAN), Err(refused())] {
            let (short, said) = verdict(false, measured.clone());
            assert_eq!(short.unwrap_err().to_string(), "1 of 1 demands are not met");
            assert!(said.contains("FALLS SHORT") && said.contains("1 not met"), "{said}");
            let (short, said) = verdict(true, measured);
            assert!(short.is_err() && said.contains(r#""met":false"#), "{said}");
        }
    }
}
