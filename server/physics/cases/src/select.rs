//! All cases, and some of them by the beginning of their ids.

use crate::case::Case;
use crate::{closed_forms, hard, references};

/// Every case, family by family.
pub fn all() -> impl Iterator<Item = Case> {
    hard::cases().into_iter().chain(closed_forms::cases()).chain(references::cases())
}

/// No case begins so.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no case begins with {prefix:?}: the nearest is {nearest:?}, and --list shows all")]
pub struct UnknownCase {
    /// What was asked for.
    pub prefix: String,
    /// The id that is most like it.
    pub nearest: String,
}

/// Closed forms that are shown among the hard cases, and how the ids of their cases begin there.
const ALSO: [(&str, &str); 3] = [("B16", "H1"), ("B19", "H3/fifth"), ("B20", "H2")];

/// The cases whose ids begin with one of `prefixes`, or every case if there are none. A number is taken whole: `H1` is
/// not the beginning of `H10/wedge`. `B16` means `H1`, where pi is counted, `B19` the one ball onto two of `H3/fifth`,
/// `B20` the cradle `H2`.
pub fn select(prefixes: &[String]) -> Result<Vec<Case>, UnknownCase> {
    let other = |prefix: &String| {
        let bare = prefix.strip_suffix('/').unwrap_or(prefix);
        ALSO.iter().find(|(name, _)| *name == bare).map_or_else(|| prefix.clone(), |(_, id)| (*id).to_owned())
    };
    let prefixes: Vec<String> = prefixes.iter().map(other).collect();
    let prefixes = &prefixes;
    let mut cases: Vec<Case> = all().collect();
    for prefix in prefixes {
        if !cases.iter().any(|case| begins(&case.id, prefix)) {
            let nearest = cases.iter().min_by_key(|case| distance(&case.id, prefix));
            let nearest = nearest.map(|case| case.id.clone()).unwrap_or_default();
            return Err(UnknownCase { prefix: prefix.clone(), nearest });
        }
    }
    if !prefixes.is_empty() {
        cases.retain(|case| prefixes.iter().any(|prefix| begins(&case.id, prefix)));
    }
    Ok(cases)
}

fn begins(id: &str, prefix: &str) -> bool {
    let digit = |text: &str, at: Option<usize>| {
        at.and_then(|at| text.as_bytes().get(at)).is_some_and(u8::is_ascii_digit)
    };
    let splits_a_number = digit(prefix, prefix.len().checked_sub(1)) && digit(id, Some(prefix.len()));
    id.starts_with(prefix) && !splits_a_number
}

/// Letters to change, add or leave out that turn the beginning of `id` into `prefix`, whatever their case: a row of
/// Levenshtein's table at a time.
fn distance(id: &str, prefix: &str) -> usize {
    let wanted: Vec<u8> = prefix.bytes().map(|b| b.to_ascii_lowercase()).collect();
    let mut row: Vec<usize> = (0..=wanted.len()).collect();
    let mut best = row[wanted.len()];
    for (above, letter) in id.bytes().map(|b| b.to_ascii_lowercase()).enumerate() {
        let mut diagonal = row[0];
        row[0] = above + 1;
        for (place, other) in wanted.iter().enumerate() {
            let changed = diagonal + usize::from(letter != *other);
            diagonal = row[place + 1];
            row[place + 1] = changed.min(diagonal + 1).min(row[place] + 1);
        }
        best = best.min(row[wanted.len()]);
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn ids_are_unique_and_every_case_demands_something() {
        let mut seen = BTreeSet::new();
        for case in all() {
            assert!(!case.demands.is_empty(), "{} demands nothing", case.id);
            assert!(case.demands.iter().all(|demand| demand.limit >= 0.0), "{:?}", case.demands);
            assert!(seen.insert(case.id.clone()), "two cases are called {}", case.id);
        }
    }

    #[test]
    fn a_number_at_the_end_of_a_prefix_is_taken_whole() {
        assert!(begins("H1/1e4", "H1") && begins("H1/1e4", "H") && begins("H1/1e4", "H1/1e4"));
        assert!(!begins("H10/wedge", "H1") && !begins("H1/1e12", "H1/1e1"));
    }

    #[test]
    fn closed_forms_among_the_hard_cases_are_found_by_their_own_names() {
        let found = |name: &str| -> Vec<String> {
            select(&[name.to_owned()]).unwrap().into_iter().map(|case| case.id).collect()
        };
        assert_eq!(found("B16"), found("H1"));
        assert_eq!(found("B19/"), found("H3/fifth"));
        assert_eq!(found("B20"), found("H2"));
        assert_eq!(found("B19").len(), 2);
        assert!(found("B1").iter().all(|id| id.starts_with("B1/")));
    }

    #[test]
    fn an_unknown_prefix_names_the_nearest_id() {
        let refused = |prefix: &str| select(&[prefix.to_owned()]).unwrap_err().nearest;
        assert!(refused("h1/1e4").starts_with("H1/1e4"), "{}", refused("h1/1e4"));
        assert!(refused("H2/4in").starts_with("H2/"), "{}", refused("H2/4in"));
    }
}
