//! A whole report of two scenes, read back.

use super::subject::{Subject, centers, seconds, tick};
use super::{Options, Page, ReportError, chapters, hard_cases, sections};
use ballroom_physics::{Accuracy, Controller, Scene, Scheme};
use serde_json::Value;
use std::fs::read_to_string;
use std::path::Path;
use std::sync::OnceLock;

/// Tags that have no end.
const VOID: [&str; 2] = ["meta", "br"];

fn options(out: &Path, scenes: &[&str]) -> Options {
    let scenes = scenes.iter().map(|&scene| scene.to_owned()).collect();
    Options { quick: true, out: out.to_owned(), scenes, command: "ballroom report --quick <&>".into() }
}

/// A quick report of a scene that comes with the program and of a file, made once for all tests.
fn report() -> &'static tempfile::TempDir {
    static REPORT: OnceLock<tempfile::TempDir> = OnceLock::new();
    REPORT.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let mine = folder.path().join("mine.toml");
        std::fs::write(&mine, include_str!("../../scenes/saddle.toml")).unwrap();
        let options = options(&folder.path().join("out"), &["bicubic", mine.to_str().unwrap()]);
        let mut page = Page::begin(&options).unwrap();
        page.add(chapters(&options, &mut |_| {}).unwrap());
        let cases = ballroom_cases::select(&["B0/sliding".to_owned()]).unwrap();
        let results: Vec<_> = cases
            .into_iter()
            .map(|case| {
                let rows = case.run().unwrap();
                (case, rows)
            })
            .collect();
        page.add([hard_cases::section(&options, &results)]);
        assert_eq!(page.write().unwrap(), options.out.join("index.html"));
        folder
    })
}

fn file(name: &str) -> String {
    read_to_string(report().path().join("out").join(name)).unwrap()
}

fn json() -> Value {
    serde_json::from_str(&file("report.json")).unwrap()
}

/// A table as its header and its rows.
fn csv(name: &str) -> Vec<std::collections::HashMap<String, String>> {
    csv::Reader::from_reader(file(name).as_bytes()).deserialize().map(Result::unwrap).collect()
}

/// Every tag that begins ends, in the order of nesting; what tags there are.
fn tags(html: &str) -> Vec<String> {
    let mut open: Vec<&str> = Vec::new();
    let mut all = Vec::new();
    for (place, _) in html.match_indices('<') {
        let tag = &html[place + 1..place + html[place..].find('>').expect("a tag ends")];
        let name =
            tag.trim_start_matches('/').split_whitespace().next().unwrap_or_default().trim_end_matches('/');
        assert!(name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '!'), "<{tag}>");
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "<{tag}> ends what was not begun last");
        } else {
            all.push(name.to_owned());
            if !tag.ends_with('/') && !tag.starts_with('!') && !VOID.contains(&name) {
                open.push(name);
            }
        }
    }
    assert!(open.is_empty(), "never ended: {open:?}");
    all
}

#[test]
fn the_page_is_well_formed_and_needs_nothing_from_outside() {
    let page = file("index.html");
    let tags = tags(&page);
    for wanted in ["svg", "table", "figcaption", "style"] {
        assert!(tags.iter().any(|tag| tag == wanted), "no <{wanted}>");
    }
    assert!(!tags.iter().any(|tag| ["script", "link", "img", "iframe"].contains(&tag.as_str())));
    let linked = page.match_indices("href=\"").map(|(at, _)| &page[at + 6..]);
    assert!(linked.clone().all(|to| to.starts_with('#') || to.starts_with("report.json")));
    assert!(page.contains("--quick &lt;&amp;&gt;"), "what comes from outside is escaped");
}

#[test]
fn page_csv_and_json_tell_the_same_numbers() {
    let (json, rows, page) = (json(), csv("work_precision.csv"), file("index.html"));
    for id in ["bicubic", "mine"] {
        let work = &json["sections"][id]["work_precision"];
        let runs = work["runs"].as_array().unwrap();
        let of_scene: Vec<_> =
            rows.iter().filter(|row| row["scene"].contains(id) && row["own"] == "false").collect();
        assert_eq!(of_scene.len(), runs.len());
        for (row, run) in of_scene.iter().zip(runs) {
            for (column, key) in [
                ("error_m", "error_m"),
                ("cpu_us_per_ball_second", "cpu_us_per_ball_second"),
                ("number_m_or_s", "number_m_or_s"),
            ] {
                assert_eq!(row[column].parse::<f64>().ok(), run[key].as_f64(), "{id} {column}");
            }
        }
        let own = work["own"]["cpu_us_per_ball_second"].as_f64().unwrap();
        assert!(page.contains(&format!("{} µs a ball-second", super::numbers::plain(own))), "{id}: {own}");
    }
}

#[test]
fn an_error_and_an_order_in_the_report_are_those_of_a_run_made_by_hand() {
    let json = json();
    let chapter = &json["sections"]["bicubic"];
    let span = chapter["horizon"]["span_ticks"].as_u64().unwrap() as usize;
    assert_eq!(span, 600, "an error of one ball alone has a meaning for all 10 s");
    let scene = Subject::open("bicubic").unwrap().scene().clone();
    let with = |accuracy| Controller::new(&Scene { accuracy, ..scene.clone() }).unwrap();
    let error = |step| {
        let (mut truth, mut run) =
            (with(Accuracy::Tolerance(1e-13)), with(Accuracy::Fixed(Scheme::Rk4, step)));
        let distance = |n| {
            truth.advance_to(tick(n));
            run.advance_to(tick(n));
            (centers(&truth).next().unwrap() - centers(&run).next().unwrap()).norm()
        };
        (0..=span).map(distance).fold(0.0, f64::max)
    };
    let runs = chapter["work_precision"]["runs"].as_array().unwrap();
    let [coarse, fine] = [1.0 / 32.0, 1.0 / 128.0].map(|step| {
        let run = runs.iter().find(|run| run["setting"] == "rk4" && run["number_m_or_s"] == step).unwrap();
        assert_eq!(run["error_m"].as_f64(), Some(error(step)), "rk4, step {step} s");
        error(step)
    });
    let orders = chapter["orders"].as_array().unwrap();
    let order =
        orders.iter().find(|order| order["scheme"] == "rk4" && order["steps_s"][0] == 1.0 / 32.0).unwrap();
    assert_eq!(order["order"].as_f64(), Some((coarse / fine).ln() / 4.0_f64.ln()));
    assert!((order["order"].as_f64().unwrap() - 4.0).abs() < 0.5, "{order}");
}

#[test]
fn the_table_of_hard_cases_has_a_row_a_demand() {
    let (json, rows) = (json(), csv("hard_cases.csv"));
    assert!(!rows.is_empty());
    assert_eq!(json["sections"]["hard-cases"]["demands"].as_u64(), Some(rows.len() as u64));
    for row in rows {
        let [demanded, measured] = ["demanded", "measured"].map(|column| row[column].parse::<f64>().unwrap());
        assert_eq!(row["met"] == "true", measured <= demanded, "{row:?}");
    }
}

#[test]
fn hashes_in_the_report_are_those_of_the_run() {
    let json = json();
    let hashes = json["sections"]["bicubic"]["ticks"]["state_hashes"].as_array().unwrap();
    let mut run = Subject::open("bicubic").unwrap().start(Accuracy::Tolerance(1e-11)).unwrap();
    run.advance_to(tick(300));
    let shown = hashes.iter().find(|hash| hash["tick"] == 300).unwrap();
    assert_eq!(shown["hash"], format!("{:016x}", run.state_hash()), "after {} s", seconds(300));
}

#[test]
fn a_folder_that_is_no_report_is_left_alone_and_a_report_is_renewed() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("thesis.txt"), "years of work").unwrap();
    let refused = Page::begin(&options(folder.path(), &[])).unwrap_err();
    assert!(matches!(refused, ReportError::NotAReport(_)), "{refused}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    let out = folder.path().join("new");
    let page = Page::begin(&options(&out, &[])).unwrap();
    page.write().unwrap();
    Page::begin(&options(&out, &[])).unwrap().write().unwrap();
}

#[test]
fn a_scene_that_nobody_knows_is_refused_before_anything_is_measured() {
    let out = tempfile::tempdir().unwrap();
    let mut told = 0;
    let refused = sections(&options(out.path(), &["bicubic", "bycubic"]), &mut |_| told += 1).unwrap_err();
    assert!(
        matches!(&refused, ReportError::Scene(fault) if fault.to_string().contains("bycubic")),
        "{refused}"
    );
    assert_eq!(told, 0);
}
