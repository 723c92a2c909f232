//! Other engines run the standard cases beside ours; see `peers` for the page they are on.

mod peers;
#[path = "peers/rows_tests.rs"]
mod rows;

use peers::contestant::ride;
use peers::measure::judge;
use peers::others::Others;
use peers::problem::{Problem, Truth};
use peers::run::{Measured, measure};
use peers::section::section;
use peers::{ours, standard};
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// A standard case by its name.
fn standard_case(id: &str) -> Problem {
    standard::problems(true).into_iter().find(|problem| problem.id == id).expect("a case of that name")
}

/// A second of an orbit, on a coarse floor.
fn short_orbit() -> Problem {
    let mut problem = standard_case("bowl-hollow");
    problem.seconds = 1.0;
    problem.rates_hz.truncate(1);
    if let Truth::Centers(centers) = &mut problem.truth {
        centers.truncate(8);
    }
    problem
}

fn measured(problem: Problem, others: &Others) -> Measured {
    measure(problem, others, true, &mut |_| {})
}

#[test]
fn our_answers_to_the_standard_cases_are_exact() {
    for problem in standard::problems(true) {
        let (samples, hits) = ride(&problem, &ours::entry(1e-12));
        let worth = judge(&problem, &samples);
        assert!(worth.error < 1e-11, "{}: {:e}", problem.id, worth.error);
        assert!(worth.overlap < 1e-9, "{}: {:e}", problem.id, worth.overlap);
        if let Truth::Velocities(exact, count) = &problem.truth {
            assert_eq!(hits, Some(*count), "{}", problem.id);
            assert!(0.0 <= exact[0] && exact[0] <= exact[1], "they meet again");
        }
    }
}

#[test]
fn every_peer_runs_a_short_orbit_and_its_numbers_are_in_the_section() {
    let case = measured(short_orbit(), &Others::default());
    let engines: BTreeSet<&str> = case.rows.iter().map(|row| row.engine.as_str()).collect();
    assert_eq!(engines, ["Ballroom", "Rapier f32", "Rapier f64"].into());
    for row in &case.rows {
        assert!(row.cost > 0.0 && row.cost.is_finite(), "{row:?}");
        // Wherever the mesh or the step may lead it, a second is too short to lose the bowl.
        assert!(row.error < if row.engine == ours::ENGINE { 1e-4 } else { 0.5 }, "{row:?}");
    }
    let section = section(std::slice::from_ref(&case), &Others::default()).expect("a section");
    assert_eq!(section.tables[0].rows.len(), case.rows.len());
    for (row, cells) in case.rows.iter().zip(&section.tables[0].rows) {
        assert_eq!(cells[4].parse(), Ok(row.error));
        assert!(section.html.contains(&row.engine));
    }
    assert_eq!(section.json["cases"][0]["rows"].as_array().map(Vec::len), Some(case.rows.len()));
    assert_eq!(section.pictures.len(), 1);
}

#[test]
fn peers_hit_about_as_often_as_we_do_in_a_gas() {
    let mut problem = standard_case("gas-flat-100");
    problem.rates_hz.truncate(1);
    let case = measured(problem, &Others::default());
    let own = case.rows[0].hits.expect("counted") as f64;
    for row in &case.rows {
        let share = row.hits.expect("counted") as f64 / own;
        assert!((0.5..2.0).contains(&share), "{row:?}: {share} of our {own}");
        assert!(row.error < 0.5, "{row:?}");
    }
}

/// What the script would print of an engine that leaves the balls where they are.
fn printed(problem: &Problem) -> Value {
    let of = |part: fn(&peers::problem::Ball) -> [f64; 3]| problem.balls.iter().map(part).collect::<Vec<_>>();
    let sample = json!({
        "centers": of(|ball| ball.center),
        "velocities": of(|ball| ball.velocity),
        "omegas": of(|ball| ball.omega),
    });
    let samples = vec![sample; problem.samples() as usize + 1];
    let run = json!({
        "case": problem.id,
        "engine": "stone 1.0",
        "setting": "60 Hz",
        "cpu_s_per_s": 1e-9,
        "samples": samples,
    });
    json!({ "runs": [run], "missing": ["mujoco"] })
}

fn parse(printed: &Value, problem: &Problem) -> Result<Others, String> {
    let text = serde_json::to_vec(printed).expect("JSON");
    Others::parse(&text, "a file", std::slice::from_ref(problem)).map_err(|error| error.to_string())
}

#[test]
fn what_the_script_prints_is_measured_like_the_rest_and_wins_where_it_is_cheaper() {
    let problem = short_orbit();
    let others = parse(&printed(&problem), &problem).expect("taken");
    let section = section(&[measured(problem, &others)], &others).expect("a section");
    assert!(
        section.html.contains("stone 1.0 (60 Hz) is cheaper than any setting of ours"),
        "{}",
        section.html
    );
    assert!(section.html.contains("not installed here: mujoco"));
    let row = section.tables[0].rows.iter().find(|row| row[1] == "stone 1.0").expect("a row");
    // It stays where it was, on an orbit from 0.66 to 1.5 m.
    let error: f64 = row[4].parse().expect("a number");
    assert!((0.5..3.0).contains(&error), "{error}");
}

#[test]
fn what_cannot_be_from_the_script_is_refused() {
    type Spoil = fn(&mut Value);
    let problem = short_orbit();
    let refusal = |spoil: Spoil| {
        let mut spoilt = printed(&problem);
        spoil(&mut spoilt);
        parse(&spoilt, &problem).expect_err("refused")
    };
    let spoils: [(Spoil, &str); 6] = [
        (|v| v["runs"][0]["cpu_s_per_s"] = json!(-1.0), "CPU time"),
        (|v| v["runs"][0]["samples"] = json!([]), "as many samples"),
        (|v| v["runs"][0]["samples"][3]["centers"] = json!([]), "as many balls"),
        (|v| v["runs"][0]["engine"] = json!("x".repeat(101)), "name is too long"),
        (|v| v["runs"][0]["power"] = json!(1), "unknown field"),
        (|v| v["runs"] = json!(vec![v["runs"][0].clone(); 1001]), "more runs"),
    ];
    for (spoil, why) in spoils {
        let refused = refusal(spoil);
        assert!(refused.contains(why), "{refused}");
    }
    assert!(Others::parse(b"{", "a file", &[]).is_err());
}

#[test]
fn runs_of_cases_that_are_not_measured_are_left_out() {
    let problem = short_orbit();
    let mut other = printed(&problem);
    other["runs"][0]["case"] = json!("another");
    assert_eq!(parse(&other, &problem).expect("taken").runs.len(), 0);
}

#[test]
fn what_the_script_printed_elsewhere_is_read_from_a_file() {
    let problem = short_orbit();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("runs.json");
    let read = || Others::from_file(&path, std::slice::from_ref(&problem));
    assert!(read().expect_err("no file").to_string().contains("runs.json cannot be read"));
    std::fs::write(&path, printed(&problem).to_string()).expect("written");
    assert_eq!(read().expect("taken").runs.len(), 1);
}

#[test]
fn without_an_interpreter_there_are_no_others_and_no_error() {
    let others = Others::from_script("no-such-interpreter", &[]).expect("no error");
    assert_eq!((others.runs.len(), others.missing), (0, vec!["no-such-interpreter".to_owned()]));
}

#[test]
fn the_script_itself_answers_or_says_what_is_missing() {
    let others = Others::from_script("python3", &[]).expect("no error");
    assert!(others.runs.is_empty());
    assert!(others.missing.iter().all(|name| ["mujoco", "pybullet", "python3"].contains(&name.as_str())));
}
