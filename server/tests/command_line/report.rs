//! `report`: what it refuses. What it writes is tested where it is made.

use super::ballroom;

#[test]
fn a_report_of_an_unknown_scene_is_refused_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("report");
    let output = ballroom(&["report", "--quick", "--out", out.to_str().unwrap(), "bycubic"]);
    assert_eq!(output.code, 5, "{}", output.stderr);
    assert!(output.stderr.contains("bycubic") && output.stderr.contains("bicubic"), "{}", output.stderr);
    assert!(output.stdout.is_empty() && !out.exists());
}

#[test]
fn a_folder_with_something_else_in_it_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("index.html"), "somebody's page").unwrap();
    let output = ballroom(&["report", "--quick", "--out", folder.path().to_str().unwrap(), "bicubic"]);
    assert_eq!(output.code, 1);
    assert!(output.stderr.contains("--out"), "{}", output.stderr);
    assert_eq!(std::fs::read_to_string(folder.path().join("index.html")).unwrap(), "somebody's page");
}
