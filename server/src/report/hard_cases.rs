//! The table of hard cases: what is demanded of the engine, and what it does.

use super::numbers::{self, rough};
use super::section::{Section, Table, table};
use super::{Options, Progress};
use ballroom_cases::{Case, Row, all};
use maud::html;
use serde_json::json;

/// Of each family this many in a quick report.
const QUICK: usize = 1;

/// Runs the cases: all, or the first of each family.
pub fn measure(options: &Options, progress: &mut Progress<'_>) -> Section {
    let mut cases: Vec<Case> = all().collect();
    if options.quick {
        let mut last = (String::new(), 0);
        cases.retain(|case| {
            let family = family(case).to_owned();
            last = if family == last.0 { (family, last.1 + 1) } else { (family, 1) };
            last.1 <= QUICK
        });
    }
    let mut results: Vec<(Case, Vec<Row>)> = Vec::new();
    for case in cases {
        progress(&format!("hard cases: {}", case.id));
        // A scene that is refused has measured nothing, and so met nothing.
        let rows = case.run().unwrap_or_else(|_| case.unmeasured());
        results.push((case, rows));
    }
    section(options, &results)
}

fn family(case: &Case) -> &str {
    case.id.split_once('/').map_or(case.id.as_str(), |(family, _)| family)
}

pub(super) fn section(options: &Options, results: &[(Case, Vec<Row>)]) -> Section {
    let mut table_of_all = Table::new(
        "hard_cases",
        &["case", "title", "quantity", "unit", "norm", "span", "demanded", "measured", "met"],
    );
    let mut shown = Vec::new();
    for (case, rows) in results {
        for (i, row) in rows.iter().enumerate() {
            let demand = &row.demand;
            let first = |text: &str| if i == 0 { text.to_owned() } else { String::new() };
            shown.push(vec![
                first(&case.id),
                first(&case.title),
                format!("{}, {}, {}", demand.quantity, demand.norm, demand.span),
                format!("{} {}", rough(demand.limit), demand.unit).trim_end_matches(" 1").to_owned(),
                rough(row.measured),
                if row.is_met() { "met".into() } else { "falls short".into() },
            ]);
            table_of_all.push([
                case.id.clone(),
                case.title.clone(),
                demand.quantity.into(),
                demand.unit.into(),
                demand.norm.into(),
                demand.span.to_string(),
                numbers::csv(demand.limit),
                numbers::csv(row.measured),
                row.is_met().to_string(),
            ]);
        }
    }
    let (demands, met) = (shown.len(), table_of_all.rows.iter().filter(|row| row[8] == "true").count());
    let mut section = Section::new("hard-cases", "Hard cases");
    let of_all = if options.quick { " (the first of each family; without --quick, all)" } else { "" };
    section.summary =
        html! { (met) " of " (demands) " demands of " (results.len()) " hard cases are met." }.into_string();
    section.html = html! {
        p {
            "Scenes that break typical engines, each with its exact answer" (of_all) ": " (met) " of " (demands)
            " demands are met. A number must be at most the one demanded; " code { "ballroom hardcases" } " runs them alone."
        }
        details open[met < demands || demands < 60] {
            summary { "All " (demands) " demands" }
            (table(&["case", "what happens", "what is measured", "demanded", "measured", "verdict"], &shown))
        }
    }
    .into_string();
    section.json = json!({ "cases": results.len(), "demands": demands, "met": met });
    section.tables = vec![table_of_all];
    section
}
