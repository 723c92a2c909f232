//! The Python client's own tests, against the program that was just built.

use std::path::Path;
use std::process::Command;

const INSTALL: &str = "pip install -e 'protocol/client/python[dev]'";

#[test]
fn the_python_client_passes_its_tests() {
    let python = || {
        let mut python = Command::new("python3");
        // From the root, so that the package is the installed one.
        python.current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."));
        python
    };
    let probe = python().args(["-c", "import ballroom, pytest"]).output();
    if !probe.is_ok_and(|output| output.status.success()) {
        assert!(std::env::var_os("BALLROOM_REQUIRE_PYTHON").is_none_or(|value| value != "1"), "{INSTALL}");
        println!("SKIPPED: {INSTALL}");
        return;
    }
    let output = python()
        .args(["-m", "pytest", "protocol/client/python/tests", "-p", "no:cacheprovider"])
        .env("BALLROOM_BIN", env!("CARGO_BIN_EXE_ballroom"))
        .env_remove("RUST_LOG")
        .env_remove("ZENOH_CONFIG")
        .output()
        .unwrap();
    let said = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&said));
}
