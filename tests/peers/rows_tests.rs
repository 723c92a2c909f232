//! What counts as a peer's win, on rows made up.

use crate::peers::rows::{Ratios, Row, Win, cheapest, most_accurate, ratios, wins};

fn row(engine: &str, cost: f64, error: f64) -> Row {
    Row {
        engine: engine.into(),
        setting: format!("{cost} {error}"),
        cost,
        error,
        energy_change: 0.0,
        overlap: 0.0,
        hits: None,
        hits_per_second: None,
    }
}

#[test]
fn a_peer_wins_only_what_no_row_of_ours_does_as_well() {
    let ours = [row("us", 1.0, 1e-6), row("us", 4.0, 1e-9)];
    let with = |peers: &[Row]| wins(&[&ours[..], peers].concat(), "us");
    assert_eq!(with(&[row("slow", 9.0, 1e-3), row("slow", 4.0, 1e-9)]), []);
    let [cheap, exact, between] = [row("a", 0.5, 1.0), row("b", 9.0, 1e-10), row("c", 2.0, 1e-8)];
    assert_eq!(
        with(&[cheap.clone(), exact.clone(), between.clone()]),
        [
            Win::Cost { row: cheap.clone(), ours: 1.0 },
            Win::Error { row: exact, ours: 1e-9 },
            Win::Both { row: between },
        ]
    );
    // A run that ended in no numbers is cheap for nothing.
    assert_eq!(with(&[row("a", 0.1, f64::INFINITY), cheap.clone()]), [Win::Cost { row: cheap, ours: 1.0 }]);
}

#[test]
fn a_shallower_overlap_is_a_win() {
    let deep = |mut row: Row, overlap| {
        row.overlap = overlap;
        row
    };
    let of_ours = |overlap| {
        let others = [deep(row("a", 2.0, 1.0), 0.0), deep(row("b", 2.0, 1.0), 0.1)];
        wins(&[&[deep(row("us", 1.0, 0.0), overlap)], &others[..]].concat(), "us")
    };
    assert_eq!(of_ours(0.01), [Win::Overlap { row: row("a", 2.0, 1.0), ours: 0.01 }]);
    assert_eq!(of_ours(1e-12), []);
}

#[test]
fn ratios_compare_at_the_same_error_and_at_the_same_cost() {
    let ours = [row("us", 1.0, 1e-3), row("us", 2.0, 1e-6), row("us", 40.0, 1e-9)];
    let ours: Vec<&Row> = ours.iter().collect();
    let against = |cost, error| ratios(&ours, &row("peer", cost, error));
    assert_eq!(against(10.0, 1e-2), Ratios { less_cpu: Some(10.0), less_error: Some(1e-2 / 1e-6) });
    assert_eq!(against(0.5, 1e-4), Ratios { less_cpu: Some(0.25), less_error: None });
    assert_eq!(against(80.0, 1e-12), Ratios { less_cpu: None, less_error: Some(1e-12 / 1e-9) });
}

#[test]
fn errors_of_rounding_are_even() {
    let own = row("us", 1.0, 2e-15);
    assert_eq!(wins(&[own.clone(), row("a", 2.0, 1e-15)], "us"), []);
    assert_eq!(ratios(&[&own], &row("a", 2.0, 1e-15)), Ratios { less_cpu: Some(2.0), less_error: Some(1.0) });
    let own = row("us", 1.0, 0.0);
    assert_eq!(ratios(&[&own], &row("peer", 1.0, 0.0)).less_error, Some(1.0));
    assert_eq!(ratios(&[&own], &row("peer", 1.0, 1.0)).less_error, Some(f64::INFINITY));
}

#[test]
fn the_best_row_of_equals_is_the_cheapest() {
    let rows = [row("a", 3.0, 1.0), row("a", 2.0, 1.0), row("a", 1.0, f64::NAN)];
    let rows: Vec<&Row> = rows.iter().collect();
    assert_eq!(most_accurate(&rows).unwrap().cost, 2.0);
    assert_eq!(cheapest(&rows).unwrap().cost, 1.0);
}
