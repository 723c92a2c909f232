//! Every case meets its demands, family by family.

use ballroom_cases::{all, select};

/// Runs the cases of a family and shows the rows that fall short.
fn assert_met(family: &str) {
    let mut short = vec![];
    for case in select(&[family.to_owned()]).unwrap() {
        match case.run() {
            Err(fault) => short.push(format!("{}: the scene is refused: {fault}", case.id)),
            Ok(rows) => short.extend(rows.iter().filter(|row| !row.is_met()).map(|row| {
                let demand = &row.demand;
                format!(
                    "{} ({}): {}, {} over {}: measured {:e}, demanded {:e} {}",
                    case.id,
                    case.title,
                    demand.quantity,
                    demand.norm,
                    demand.span,
                    row.measured,
                    demand.limit,
                    demand.unit
                )
            })),
        }
    }
    assert!(short.is_empty(), "these fall short:\n{}", short.join("\n"));
}

macro_rules! families {
    ($($claim:ident: $family:literal,)*) => {
        const FAMILIES: &[&str] = &[$($family),*];
        $(#[test] fn $claim() { assert_met($family); })*
    };
}

families! {
    balls_follow_references_of_another_formulation: "R/",
    hits_between_a_wall_and_a_heavy_ball_spell_pi: "H1/",
    as_many_balls_leave_a_cradle_as_came: "H2/",
}

#[test]
fn every_case_belongs_to_a_family_above() {
    for case in all() {
        assert!(FAMILIES.iter().any(|family| case.id.starts_with(family)), "{} is not run", case.id);
    }
}
