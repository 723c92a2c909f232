//! Viewers of a real bridge: what a real one holds and draws, and what stops nobody.

use nix::sys::signal::Signal;
use protocol::command::Command;
use std::net::TcpStream;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use tests::{Camera, PATIENCE, Process, Ride, Screen, Server, turn, until};

/// Where a bridge says that viewers find it.
fn url_of(bridge: &Process) -> String {
    bridge.logged(PATIENCE, |line| Some(line.split_once("rerun --connect ")?.1.trim().to_owned()))
}

fn wall_ns() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as u64
}

#[test]
fn a_real_viewer_holds_the_newest_tick_and_draws_the_balls_where_they_are() {
    let _turn = turn();
    // A clock that only steps: the same ticks and the same picture on every machine.
    let server = Server::start(&["original", "--paused"]);
    let client = server.client();
    let bridge = Process::start("ballroom-viewer", &["-e", server.endpoint()]);
    let url = url_of(&bridge);
    let Some(mut screen) = Screen::watching(&url) else { return };
    for _ in 0..3 {
        let tick = client.command(&Command::Step { ticks: 20 }).unwrap().tick;
        let held = until("the viewer to hold the newest tick", Duration::from_mins(2), || {
            screen.newest().get("tick").copied().filter(|held| *held == i64::try_from(tick).unwrap())
        });
        let age_ms = (wall_ns() - client.snapshot().unwrap().snapshot.wall_ns) as f64 * 1e-6;
        println!("the viewer holds tick {held}, which was over {age_ms:.0} ms ago at most");
    }

    let world = client.snapshot().unwrap();
    let camera = Camera::of(&url, "Overview");
    let picture = screen.picture(&camera.view);
    for ball in 0..world.roster.names.len() {
        let (center_m, color) = (world.snapshot.center_m[ball], world.roster.color_rgb[ball]);
        let radius = camera.pixels(world.roster.radius_m[ball], center_m, &picture);
        let [x, y] = camera.project(center_m, &picture);
        let here = picture.share_of(color, [x, y], 0.8 * radius);
        let aside = picture.share_of(color, [x + 3.0 * radius, y], 0.8 * radius);
        let name = &world.roster.names[ball];
        println!("{name}: {radius:.0} pixels large at ({x:.0}, {y:.0}), {here:.2} of it in its colour");
        assert!(radius > 5.0, "{name} is drawn {radius} pixels large");
        assert!(here > 0.2 && aside < 0.1, "{name}: {here} of its colour where it is, {aside} beside it");
    }
}

#[test]
fn a_viewer_that_stands_still_does_not_stop_the_file() {
    let _turn = turn();
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("ride.rrd");
    let server = Server::start(&["thousand"]);
    let client = server.client();
    // Like a stopped process: the system accepts, nobody reads.
    let stopped = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = stopped.local_addr().unwrap().to_string();
    let arguments = ["-e", server.endpoint(), "--connect", &address, "--save", file.to_str().unwrap()];
    let bridge = Process::start("ballroom-viewer", &arguments);
    let _connection = stopped.accept().unwrap();
    let tick = || client.snapshot().unwrap().snapshot.tick;
    let size = || std::fs::metadata(&file).map_or(0, |file| file.len());
    until("a recording that grows", PATIENCE, || (size() > 1 << 20).then_some(()));
    let since = tick();
    until("ten seconds of it", PATIENCE, || (tick() > since + 600).then_some(()));
    bridge.signal(Signal::SIGTERM);
    let output = bridge.end(PATIENCE);
    assert_eq!(output.code, Some(0), "{}", output.stderr);

    let ride = Ride::read(&file);
    let rows = ride.rows("/world/balls/0");
    assert!(rows.last().unwrap().tick > since + 500, "the file ends at {}", rows.last().unwrap().tick);
}

#[test]
fn a_full_disk_does_not_stop_the_live_view() {
    let _turn = turn();
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("ride.rrd");
    let server = Server::start(&["thousand"]);
    let client = server.client();
    let arguments = ["-e", server.endpoint(), "--save", file.to_str().unwrap()];
    // The file may have half a megabyte, and writing beyond is an error and no signal.
    let bridge = Process::start_limited("ballroom-viewer", &arguments, 1024);
    let url = url_of(&bridge);
    bridge.logged(PATIENCE, |line| line.contains("Failed to write log stream").then_some(()));
    let since = client.snapshot().unwrap().snapshot.tick;
    let newest = tests::newest_tick_at(&url, PATIENCE, since + 60);
    assert!(newest >= since + 60);
    bridge.signal(Signal::SIGTERM);
    let output = bridge.end(PATIENCE);
    // What was asked for is not there.
    assert_eq!(output.code, Some(1), "{}", output.stderr);
    assert!(output.stderr.contains("the recording is incomplete"), "{}", output.stderr);
}

#[test]
fn a_bridge_is_watched_from_other_machines_only_when_asked() {
    let _turn = turn();
    let server = Server::start(&["plane"]);
    for (arguments, open) in [(&[][..], false), (&["--listen", "127.0.0.2"], true)] {
        let bridge = Process::start("ballroom-viewer", &[&["-e", server.endpoint()][..], arguments].concat());
        let url = url_of(&bridge);
        let port: u16 = url.trim_end_matches("/proxy").rsplit_once(':').unwrap().1.parse().unwrap();
        // 127.0.0.2 stands for an address that is not the usual loopback.
        assert_eq!(TcpStream::connect(("127.0.0.2", port)).is_ok(), open, "{url}");
    }
}
