//! `hardcases`: rows of demands, chosen by the beginnings of their ids.

use super::{ballroom, said};
use serde_json::Value;

#[test]
fn hardcases_prints_every_demand_with_its_measurement_and_verdict() {
    let text = said(&["hardcases", "H3", "X12"]);
    assert!(text.contains("H3/fifth-roll ") && text.contains("X12/tick-60 "), "{text}");
    let rows: Vec<&str> = text.lines().filter(|line| line.contains(" demanded ")).collect();
    assert!(rows.len() > 10 && rows.iter().all(|row| row.ends_with("  ok")), "{text}");
    let last = text.lines().last().unwrap();
    assert!(last.ends_with(&format!("{} demands, 0 not met", rows.len())), "{last}");
}

#[test]
fn hardcases_as_json_holds_the_same_bits_each_time() {
    let run = || -> Vec<Value> {
        let mut lines: Vec<Value> = said(&["hardcases", "H2", "H9/wedge-60", "--json"])
            .lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect();
        for line in &mut lines {
            assert!(line["case_wall_millis"].as_f64().unwrap() > 0.0);
            line["case_wall_millis"] = Value::Null;
        }
        lines
    };
    let lines = run();
    assert!(lines.len() > 10, "{lines:?}");
    for line in &lines {
        assert!(line["measured"].as_f64().unwrap() <= line["demanded"].as_f64().unwrap(), "{line}");
        assert_eq!(line["met"], true, "{line}");
        for text in ["case", "title", "quantity", "unit", "norm", "span"] {
            assert!(!line[text].as_str().unwrap().is_empty(), "{line}");
        }
    }
    assert_eq!(run(), lines);
}

#[test]
fn hardcases_lists_its_cases_and_names_the_nearest_to_an_unknown_one() {
    let list = said(&["hardcases", "--list"]);
    for family in ["H1/", "H5/", "H10/", "H22/", "H34/", "X9/"] {
        assert!(list.lines().any(|line| line.starts_with(family)), "{family} is missing:\n{list}");
    }
    assert!(said(&["hardcases", "H1", "--list"]).lines().all(|line| line.starts_with("H1/")));
    let refused = ballroom(&["hardcases", "H1/1e5"]);
    assert_eq!(refused.code, 2, "{}", refused.stderr);
    assert!(refused.stderr.contains("\"H1/1e5\"") && refused.stderr.contains("H1/1e"), "{}", refused.stderr);
    assert!(refused.stderr.contains("--list"), "{}", refused.stderr);
}
