//! `check`: what is wrong is named by file, line and field, with what would be right.

use super::{ballroom, said};

/// Good as it stands; each case below breaks one thing.
const GOOD: &str = r#"version = 1
name = "table"
description = "Two balls on a level floor."
[floor.polynomial]
x_m = [-5.0, 5.0]
y_m = [-5.0, 5.0]
terms = [{ px = 2, c = 0.01 }]
[[ball]]
name = "one"
radius_m = 0.5
mass_kg = 1.0
center_m = [0.0, 0.0]
player = true
[[ball]]
name = "two"
radius_m = 0.5
mass_kg = 2.0
center_m = [3.0, 0.0]
"#;

/// A scene on a net whose two borders run against each other: the floor is twisted and has no normal in places.
const FOLDED: &str = r#"version = 1
name = "fold"
[floor.net]
control_points_m = [
    [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]],
    [[4.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
]
[walls.box]
x_m = [0.0, 4.0]
y_m = [0.0, 4.0]
[[ball]]
name = "one"
radius_m = 0.5
mass_kg = 1.0
uv = [0.5, 0.5]
"#;

/// A road that passes under itself with 0.93 m of headroom, and a ball as high as that and more.
const LOOPING_ROAD: &str = r#"version = 1
name = "road"
[floor.net]
control_points_m = [
    [[-2.46, -1.08, 0.0], [-3.54, 1.08, 0.0]],
    [[9.18, 6.72, 0.4], [8.82, 5.28, 0.4]],
    [[-9.18, 6.72, 0.8], [-8.82, 5.28, 0.8]],
    [[2.46, -1.08, 1.2], [3.54, 1.08, 1.2]],
]
[walls.box]
x_m = [-9.0, 9.0]
y_m = [-1.0, 6.0]
[[ball]]
name = "one"
radius_m = 0.5
mass_kg = 1.0
uv = [0.5, 0.5]
"#;

/// What is replaced by what, and how the complaint begins and what it recommends.
const BROKEN: [(&str, &str, &str, &str); 19] = [
    ("version = 1", "version = 2", ":1:1: version: is 2", "reads version 1"),
    ("version = 1\n", "", ":1:1", "missing field `version`"),
    ("name = \"table\"", "name = 7", ":2:8: name: invalid type: integer `7`", "expected a string"),
    ("name = \"table\"", "name = \"Table\"", ":2:1: name: is \"Table\"", "use 1 to 32 of a-z"),
    ("x_m = [-5.0", "x_m = [6.0", ":5:1: floor.polynomial.x_m", "must be the larger"),
    ("px = 2", "px = 13", ":7:12: floor.polynomial.terms[0].px: is 13", "from 0 to 12"),
    // Ten times the curvature that balls of this radius can follow.
    ("c = 0.01", "c = 10.0", ":16:1: ball[1].radius_m: the floor's curvature", "use a smaller ball"),
    ("radius_m = 0.5\nmass_kg = 1.0", "radius = 0.5\nmass_kg = 1.0", ":10:1: ball[0].radius", "`radius_m`"),
    ("mass_kg = 1.0", "mass_kg = \"1 kg\"", ":11:11: ball[0].mass_kg", "expected f64"),
    ("mass_kg = 1.0", "mass_kg = nan", ":11:1: ball[0].mass_kg: is NaN", "use a number from"),
    ("mass_kg = 2.0", "mass_kg = inf", ":17:1: ball[1].mass_kg: is inf", "use a number from"),
    ("mass_kg = 2.0", "mass_kg = -2.0", ":17:1: ball[1].mass_kg: is -2", "use a number from"),
    ("center_m = [3.0, 0.0]", "center_m = [3.0, 1e300]", ":18:18: ball[1].center_m[1]: is 1", "use a number"),
    ("center_m = [3.0, 0.0]", "center_m = [3.0]", ":18:12: ball[1].center_m", "array of length 2"),
    (
        "center_m = [3.0, 0.0]\n",
        "",
        ":14:1: ball[1]: has 0 places",
        "exactly one of center_m, contact_m and uv",
    ),
    ("name = \"two\"", "name = \"one\"", ":15:1: ball[1].name: is \"one\"", "a name of its own"),
    ("[3.0, 0.0]", "[0.75, 0.0]", ":14:1: ball[1]: \"two\" overlaps \"one\"", "move them apart"),
    ("[3.0, 0.0]", "[4.75, 0.0]", ":14:1: ball[1]: \"two\" reaches", "move it inside"),
    ("[3.0, 0.0]", "[40.0, 0.0]", ":14:1: ball[1]: \"two\" ", ""),
];

/// The complaint about a scene, from the end of the file's name on.
fn complaint(text: &str) -> String {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("scene.toml");
    std::fs::write(&file, text).unwrap();
    let name = file.to_str().unwrap();
    // `simulate` and `serve` refuse what `check` refuses, in the same words.
    let output = ballroom(&["check", name]);
    assert_eq!(output.code, 5, "{text}\n{}{}", output.stdout, output.stderr);
    assert!(!output.stdout.ends_with("ok\n"), "{}", output.stdout);
    let simulated = ballroom(&["simulate", name, "--until", "1"]);
    assert_eq!((simulated.code, &simulated.stderr), (5, &output.stderr));
    let about = format!("ballroom: {name}");
    output.stderr.strip_prefix(&about).unwrap_or_else(|| panic!("{}", output.stderr)).to_owned()
}

#[test]
fn check_names_file_line_and_field() {
    let directory = tempfile::tempdir().unwrap();
    let good = directory.path().join("good.toml");
    std::fs::write(&good, GOOD).unwrap();
    assert!(said(&["check", good.to_str().unwrap()]).ends_with("\nok\n"));
    let mut wrong = Vec::new();
    for (from, to, place, remedy) in BROKEN {
        assert!(GOOD.contains(from), "{from}");
        let complaint = complaint(&GOOD.replacen(from, to, 1));
        if !complaint.starts_with(place) || !complaint.contains(remedy) {
            wrong.push(format!("{to:?}: {complaint}  is not {place} … {remedy}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_degenerate_net_is_refused_at_its_floor() {
    let complaint = complaint(FOLDED);
    assert!(
        complaint.starts_with(":3:2: floor: the floor has no normal: S_u x S_v vanishes, near u = "),
        "{complaint}"
    );
    assert!(complaint.contains("(x = "), "{complaint}");
    assert!(complaint.contains("move its control points"), "{complaint}");
}

#[test]
fn a_ball_that_would_touch_the_road_above_is_refused_with_both_places() {
    let complaint = complaint(LOOPING_ROAD);
    assert!(complaint.starts_with(":15:1: ball[0].radius_m: is 0.5: "), "{complaint}");
    let places = [
        "lies at u = 1.000000, v = 0.139648 (x = 0.04",
        "touches it again at u = 1.000000, v = 0.862305 (x = -0.0",
    ];
    for part in ["0.434613 to 0.435041 m", places[0], places[1]] {
        assert!(complaint.contains(part), "{complaint}");
    }
}

/// The numbers of a line of `check original`, up to the words `until`.
fn numbers(name: &str, until: &str) -> Vec<f64> {
    let text = said(&["check", "original"]);
    let line =
        text.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("no {name} in {text}"));
    let (numbers, _) = line.split_once(until).unwrap_or_else(|| panic!("no {until} in {line}"));
    numbers.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn check_prints_what_is_certified_about_the_floor() {
    // The pit of the original floor is as curved as a ball of 1.61 m, and its flank 52.7 degrees steep.
    for (name, until, low, high) in [
        ("steepest", "degrees", 52.6, 52.8),
        ("curvature", "1/m", 0.6, 0.65),
        ("reach", "m:", 1.61, 1.62),
        ("radius", ", at most", 0.62, 1.0),
    ] {
        let numbers = numbers(name, until);
        assert!(numbers.len() >= 2, "{name}: {numbers:?}");
        assert!(numbers.is_sorted_by(|a, b| a <= b || *a == 1.0), "{name}: {numbers:?}");
        assert!(numbers.iter().all(|x| (low..=high).contains(x)), "{name}: {numbers:?}");
    }
}
