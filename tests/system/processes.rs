//! Processes among others: ports, signals, what is linked.

use ballroom_client::Presence;
use nix::sys::signal::Signal;
use protocol::keys::Role;
use std::net::TcpListener;
use std::process::Command;
use tests::{PATIENCE, Process, Server, connect, turn, until};

fn port_of(endpoint: &str) -> u16 {
    endpoint
        .strip_prefix("tcp/127.0.0.1:")
        .and_then(|port| port.parse().ok())
        .expect("an endpoint on loopback")
}

/// Whether a port can be listened on, hence nobody was left behind who holds it.
fn is_free(port: u16) -> bool {
    TcpListener::bind(("127.0.0.1", port)).is_ok()
}

/// The endpoint in the demo's log.
pub fn endpoint_of_demo(demo: &Process) -> String {
    demo.logged(PATIENCE, |line| {
        let at = line.find(" on tcp/127.0.0.1:")?;
        Some(line[at + 4..].split_whitespace().next()?.to_owned())
    })
}

#[test]
fn a_taken_port_is_stepped_around_and_said() {
    let _turn = turn();
    // Where it cannot be taken, somebody else has it, which serves as well.
    let _taken = TcpListener::bind("127.0.0.1:7447");
    let server = Server::of(Process::start("ballroom", &["serve", "plane"]));
    let port = port_of(server.endpoint());
    assert_ne!(port, 7447);
    let said = format!("port 7447 is taken, listening on {port}: clients need -e tcp/127.0.0.1:{port}");
    server.process().logged(PATIENCE, |line| line.contains(&said).then_some(()));
    assert_eq!(server.client().scene().unwrap().name, "plane");
}

#[test]
fn a_named_port_that_is_taken_is_an_error_that_names_it() {
    let _turn = turn();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let endpoint = format!("tcp/{}", taken.local_addr().unwrap());
    let output = tests::run("ballroom", &["serve", "-l", &endpoint]);
    assert_eq!(output.code, Some(1), "{}", output.stderr);
    assert!(output.stdout.is_empty() && output.stderr.contains(&endpoint), "{}", output.stderr);
}

#[test]
fn zenoh_files_and_settings_configure_servers_and_tools() {
    let _turn = turn();
    let directory = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| {
        let file = directory.path().join(name);
        std::fs::write(&file, text).unwrap();
        file.to_str().unwrap().to_owned()
    };
    let listen = write(
        "server.json5",
        r#"{ mode: "router", listen: { endpoints: ["tcp/127.0.0.1:0"] },
             scouting: { delay: 0, multicast: { enabled: false } } }"#
            .into(),
    );
    let server = Server::of(Process::start("ballroom", &["serve", "plane", "-c", &listen]));
    let connect = write(
        "client.json5",
        format!(r#"{{ mode: "client", connect: {{ endpoints: ["{}"] }} }}"#, server.endpoint()),
    );
    let output = tests::run("ballroom", &["pause", "-c", &connect, "--cfg", "transport/link/tx/lease:5000"]);
    assert_eq!(output.code, Some(0), "{}", output.stderr);
    for wrong in [["-c", "no/such.json5"], ["--cfg", "no/such/key:1"]] {
        for subcommand in ["serve", "pause"] {
            let output = tests::run("ballroom", &[&[subcommand], &wrong[..]].concat());
            assert_eq!(output.code, Some(1), "{}", output.stderr);
            assert!(output.stderr.contains(wrong[1].split(':').next().unwrap()), "{}", output.stderr);
        }
    }
}

#[test]
fn who_is_there_is_known_and_who_was_killed_is_missed() {
    let _turn = turn();
    let directory = tempfile::tempdir().unwrap();
    let server = Server::start(&["plane"]);
    let client = server.client();
    let viewers = client.watch(Role::Viewer).unwrap();
    let file = directory.path().join("ride.rrd");
    let arguments = ["-e", server.endpoint(), "--no-viewer", "--save", file.to_str().unwrap()];
    let viewer = Process::start("ballroom-viewer", &arguments);
    let Some(Presence::Here(id)) = viewers.recv_timeout(PATIENCE).unwrap() else { panic!("no viewer came") };
    viewer.kill();
    assert_eq!(viewers.recv_timeout(PATIENCE).unwrap(), Some(Presence::Gone(id)));
    let servers = client.watch(Role::Server).unwrap();
    assert!(matches!(servers.recv_timeout(PATIENCE).unwrap(), Some(Presence::Here(_))));
}

#[test]
fn ctrl_c_and_sigterm_end_cleanly() {
    let _turn = turn();
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("ride.rrd");
    let file = file.to_str().unwrap();
    for signal in [Signal::SIGINT, Signal::SIGTERM] {
        let server = Server::start(&["original"]);
        let port = port_of(server.endpoint());
        let watch = Process::start("ballroom", &["watch", "-e", server.endpoint()]);
        watch.said(PATIENCE, |_| Some(()));
        let arguments = ["-e", server.endpoint(), "--no-viewer", "--save", file];
        let viewer = Process::start("ballroom-viewer", &arguments);
        until("the viewer to be there", PATIENCE, || {
            std::fs::metadata(file).is_ok_and(|file| file.len() > 0).then_some(())
        });
        for process in [watch, viewer] {
            process.signal(signal);
            let output = process.end(PATIENCE);
            assert_eq!(output.code, Some(0), "{signal}: {}", output.stderr);
        }
        let output = server.end(signal);
        assert_eq!(output.code, Some(0), "{signal}: {}", output.stderr);
        assert!(is_free(port), "somebody still holds port {port}");

        let demo = Process::start("ballroom-demo", &["--no-viewer"]);
        let endpoint = endpoint_of_demo(&demo);
        demo.logged(PATIENCE, |line| line.contains("no terminal").then_some(()));
        demo.signal(signal);
        let output = demo.end(PATIENCE);
        assert_eq!(output.code, Some(0), "{signal}: {}", output.stderr);
        assert!(is_free(port_of(&endpoint)), "somebody still holds {endpoint}");
    }
}

#[test]
fn a_viewer_that_still_waits_for_a_server_ends_cleanly_too() {
    let _turn = turn();
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("ride.rrd");
    // Nothing listens on port 1.
    let arguments = ["-e", "tcp/127.0.0.1:1", "--no-viewer", "--save", file.to_str().unwrap()];
    let viewer = Process::start("ballroom-viewer", &arguments);
    viewer.logged(PATIENCE, |line| line.contains("waiting for it").then_some(()));
    viewer.signal(Signal::SIGTERM);
    let output = viewer.end(PATIENCE);
    assert_eq!(output.code, Some(0), "{}", output.stderr);
}

#[test]
fn a_simulation_cut_short_says_so_in_its_exit_code() {
    let _turn = turn();
    let simulation = Process::start("ballroom", &["simulate", "thousand", "--until", "1000000", "--json"]);
    simulation.said(PATIENCE, |line| line.starts_with("{\"tick\":0,").then_some(()));
    simulation.signal(Signal::SIGINT);
    let output = simulation.end(PATIENCE);
    assert_eq!(output.code, Some(130), "{}", output.stderr);
    assert_eq!(output.stdout.lines().count(), 1);
}

#[test]
fn the_demo_serves_whoever_comes() {
    let _turn = turn();
    let demo = Process::start("ballroom-demo", &["cradle", "--no-viewer", "--for", "5"]);
    let client = connect(&endpoint_of_demo(&demo));
    assert_eq!(client.scene().unwrap().name, "cradle");
    drop(client);
    assert_eq!(demo.end(PATIENCE).code, Some(0), "it ends when its time is over");
}

#[test]
fn the_server_never_builds_rerun() {
    let tree = Command::new(env!("CARGO"))
        .args(["tree", "-p", "server", "-e", "normal", "--prefix", "none", "--offline", "--locked"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(tree.status.success(), "{}", String::from_utf8_lossy(&tree.stderr));
    let tree = String::from_utf8(tree.stdout).unwrap();
    assert!(tree.lines().any(|line| line.starts_with("zenoh v")), "{tree}");
    let heavy = |line: &&str| line.starts_with("rerun ") || line.starts_with("re_");
    assert_eq!(tree.lines().find(heavy), None);
}
