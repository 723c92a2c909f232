//! `simulate`: the run itself, in full, without a network.

use super::{ballroom, built_in_scenes, said};
use serde_json::Value;

/// Numbers as the text has them.
fn numbers(line: &str) -> Vec<&str> {
    let parts = line.split(|c| ",:[]{}".contains(c));
    parts.filter(|part| part.starts_with(|c: char| c == '-' || c.is_ascii_digit())).collect()
}

/// A line with every number replaced by `#` and every hash by `$`.
fn shape(line: &str) -> String {
    let mut shape = String::new();
    let mut quoted = false;
    for part in line.split_inclusive(|c| ",:[]{}\"".contains(c)) {
        let (token, end) = part.split_at(part.len() - 1);
        shape.push_str(match token {
            _ if quoted && token.len() == 16 && token.bytes().all(|b| b.is_ascii_hexdigit()) => "$",
            _ if !quoted && !token.is_empty() => "#",
            _ => token,
        });
        shape.push_str(end);
        quoted ^= end == "\"";
    }
    shape
}

fn states(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn simulate_prints_full_precision_lines_and_repeats_bit_for_bit() {
    let run = || said(&["simulate", "original", "--until", "3", "--every", "0.5", "--json"]);
    let text = run();
    assert_eq!(text.lines().count(), 7, "at 0, 0.5, … 3 s");
    let ball = |name: &str| {
        format!(
            "{{\"name\":\"{name}\",\"uv\":[#,#],\"center_m\":[#,#,#],\"velocity_m_per_s\":[#,#,#],\
             \"omega_rad_per_s\":[#,#,#],\"orientation_xyzw\":[#,#,#,#]}}"
        )
    };
    let expected = format!(
        "{{\"tick\":#,\"time_s\":#,\"energy_j\":#,\"collisions\":{{\"ball_ball\":#,\"ball_wall\":#}},\
         \"state_hash\":\"$\",\"balls\":[{},{},{}]}}",
        ball("blue"),
        ball("player"),
        ball("red")
    );
    for line in text.lines() {
        assert_eq!(shape(line), expected);
        for number in numbers(line) {
            // Shortest among the texts that give back the same bits, as everybody's reader understands it.
            let same = if number.contains(['.', 'e']) {
                serde_json::to_string(&number.parse::<f64>().unwrap()).unwrap()
            } else {
                number.parse::<u64>().unwrap().to_string()
            };
            assert_eq!(same, number);
        }
    }
    let digits = |number: &&str| number.bytes().filter(u8::is_ascii_digit).count();
    let last = text.lines().last().unwrap();
    let long = numbers(last).iter().filter(|number| digits(number) >= 15).count();
    assert!(long > 30, "numbers are cut short: {last}");
    assert_eq!(run(), text);
}

#[test]
fn the_rate_numbers_the_ticks_and_changes_nothing_else() {
    let run = |rate: &str| {
        said(&["simulate", "original", "--until", "4", "--every", "0.5", "--rate", rate, "--json"])
    };
    let without_tick = |text: &str| -> Vec<(u64, String)> {
        let split = |line: &str| {
            let (tick, rest) = line.split_once(',').unwrap();
            (tick.trim_start_matches("{\"tick\":").parse().unwrap(), rest.to_owned())
        };
        text.lines().map(split).collect()
    };
    let at_60 = without_tick(&run("60"));
    assert_eq!(at_60.len(), 9);
    for (rate, per_state) in [("30", 15), ("240", 120)] {
        for (i, (tick, rest)) in without_tick(&run(rate)).into_iter().enumerate() {
            assert_eq!(tick, i as u64 * per_state);
            assert_eq!(rest, at_60[i].1, "at {rate} Hz");
        }
    }
}

#[test]
fn states_in_between_change_no_bit_of_the_end() {
    let end = |every: &[&str]| {
        let text = said(&[&["simulate", "original", "--until", "2.5", "--json"], every].concat());
        text.lines().last().unwrap().to_owned()
    };
    let plain = end(&[]);
    assert_eq!(end(&["--every", "0.1"]), plain);
    assert_eq!(end(&["--every", "0.0371"]), plain);
}

#[test]
fn csv_holds_the_same_numbers_one_line_a_ball() {
    let run = |format: &str| said(&["simulate", "plane", "--until", "1", "--every", "0.25", format]);
    let csv = run("--csv");
    let mut table = csv::Reader::from_reader(csv.as_bytes());
    let columns = table.headers().unwrap().clone();
    let mut rows = table.records().map(Result::unwrap);
    for state in states(&run("--json")) {
        for ball in state["balls"].as_array().unwrap() {
            let row = rows.next().unwrap();
            let cell = |name: &str| &row[columns.iter().position(|column| column == name).unwrap()];
            let number = |name: &str| cell(name).parse::<f64>().unwrap();
            assert_eq!(cell("name"), ball["name"].as_str().unwrap());
            assert_eq!(cell("state_hash"), state["state_hash"].as_str().unwrap());
            assert_eq!(cell("tick"), state["tick"].to_string());
            assert_eq!(cell("ball_ball"), state["collisions"]["ball_ball"].to_string());
            let near = |a: f64, b: &Value| (a - b.as_f64().unwrap()).abs() <= 1e-15 * a.abs();
            assert!(near(number("center_x_m"), &ball["center_m"][0]), "{row:?}");
            assert!(near(number("velocity_y_m_per_s"), &ball["velocity_m_per_s"][1]), "{row:?}");
            assert!(near(number("orientation_w"), &ball["orientation_xyzw"][3]), "{row:?}");
        }
    }
    assert!(rows.next().is_none());
}

#[test]
fn every_built_in_scene_passes_its_check_and_keeps_its_energy() {
    for scene in built_in_scenes() {
        assert!(said(&["check", &scene]).ends_with("\nok\n"), "{scene}");
        let states = states(&said(&["simulate", &scene, "--until", "1", "--json"]));
        let energy = |state: &Value| state["energy_j"].as_f64().unwrap();
        let [before, after] = [energy(&states[0]), energy(&states[1])];
        let drift = (after - before).abs() / before.abs();
        assert!(drift < 1e-10, "{scene}: {before} J became {after} J");
    }
}

#[test]
fn a_run_that_is_saved_and_loaded_prints_the_lines_of_one_that_never_stopped() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["original", "cradle", "corner"] {
        let file = folder.path().join(scene);
        let file = file.to_str().unwrap();
        let run = |more: &[&str]| said(&[&["simulate", scene, "--every", "0.3", "--json"], more].concat());
        let straight = run(&["--until", "4"]);
        let first = run(&["--until", "1.7", "--save", file]);
        let second = run(&["--until", "4", "--load", file]);
        // 0, 0.3, … 1.5, then 1.8, … 3.9, 4; the halves meet at 1.7.
        let straight: Vec<&str> = straight.lines().collect();
        let (first, second): (Vec<&str>, Vec<&str>) = (first.lines().collect(), second.lines().collect());
        assert_eq!(first[..6], straight[..6], "{scene}");
        assert_eq!(second[0], first[6], "{scene}");
        assert_eq!(second[1..], straight[6..], "{scene}");
    }
}

#[test]
fn what_is_no_checkpoint_of_the_scene_is_refused_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (kept, other) = (path("kept.json"), path("other.json"));
    said(&["simulate", "cradle", "--until", "1", "--save", &kept]);
    let refusal = |arguments: &[&str]| {
        let output = ballroom(&[&["simulate"], arguments].concat());
        assert_eq!(output.code, 1, "{}", output.stderr);
        output.stderr
    };
    let why = refusal(&["plane", "--until", "2", "--load", &kept]);
    assert!(why.contains("belongs to another scene"), "{why}");
    let why = refusal(&["cradle", "--until", "0.5", "--load", &kept]);
    assert!(why.contains("stands at 1 s"), "{why}");
    let why = refusal(&["cradle", "--until", "2", "--save", &kept]);
    assert!(why.contains("is there already"), "{why}");
    let text = std::fs::read_to_string(&kept).unwrap();
    for (wrong, reason) in [
        (text[..text.len() / 2].to_owned(), "EOF"),
        (text.replace("\"version\":2", "\"version\":9"), "version 9"),
        (text.replace("\"words\":\"", "\"words\":\"AAAA"), "format"),
        (text.replace("\"words\":\"", "\"words\":\"!"), "damaged"),
    ] {
        std::fs::write(&other, wrong).unwrap();
        let why = refusal(&["cradle", "--until", "2", "--load", &other]);
        assert!(why.contains(reason), "{why}");
    }
}
