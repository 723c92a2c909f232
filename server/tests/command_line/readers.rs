//! How states reach those who read them, as the dashboard and scripts see it.

use super::PATIENCE;
use super::serving::Serving;
use ballroom_client::{ClientOptions, Patience};
use protocol::keys::Role;
use serde_json::Value;
use std::time::{Duration, Instant};

/// Follows `arena` as a viewer until `is_seen` has seen it.
fn follow_until(server: &Serving, arena: &str, mut is_seen: impl FnMut() -> bool) {
    let client = ballroom_client::Client::open(ClientOptions {
        role: Role::Viewer,
        id: Some("v1".parse().unwrap()),
        patience: Patience::GiveUpAfter(PATIENCE),
        timeout: PATIENCE,
        ..server.options_of(arena)
    })
    .unwrap();
    let mut follower = client.follow().unwrap();
    let began = Instant::now();
    while !is_seen() {
        assert!(began.elapsed() < PATIENCE, "nothing was told of the viewer");
        // A second holds many of these.
        for _ in 0..20 {
            follower.next_within(Duration::from_millis(20)).unwrap();
        }
    }
}

#[test]
fn a_follower_tells_age_jitter_and_losses_and_its_stream_is_counted() {
    let server = Serving::start(&["left=plane", "right=bowl", "--paused"]);
    let asker = server.client_of("right");
    assert!(server.tool(&["resume", "--arena", "right"]).code == 0);
    follow_until(&server, "right", || {
        let stream = asker.stats().unwrap().streams.state;
        let clients = asker.clients().unwrap().clients;
        let Some(row) = clients.first() else { return false };
        assert_eq!((row.role, row.id.as_str(), clients.len()), (Role::Viewer, "v1", 1));
        let (Some([median, largest]), Some(jitter)) = (row.report.age_ms, row.report.jitter_ms) else {
            return false;
        };
        assert!(row.report.lost.is_some() && row.report.received > 1);
        assert!(row.report.states_per_s > 0.0 && row.report.bytes_per_s > 100.0 * row.report.states_per_s);
        // One clock: a state is no older than the second and its report, and not from the future.
        assert!((0.0..=1e3 * PATIENCE.as_secs_f64()).contains(&median) && median <= largest && jitter >= 0.0);
        stream.is_read && stream.messages_per_s > 0.0 && stream.bytes_per_s > 100.0
    });
    // Nobody reads the other.
    assert!(server.client_of("left").clients().unwrap().clients.is_empty());
    let stats = server.client_of("left").stats().unwrap();
    assert!(!stats.streams.state.is_read && stats.streams.state.messages_per_s == 0.0);
}

#[test]
fn top_prints_a_table_once_and_metrics_their_text() {
    let server = Serving::start(&["left=plane", "right=bowl", "--paused"]);
    assert_eq!(server.tool(&["step", "7", "--arena", "left"]).code, 0);
    let table = server.tool(&["top", "--once"]);
    assert!(table.code == 0 && table.stderr.is_empty(), "{}", table.stderr);
    let line = table.stdout.lines().find(|line| line.starts_with("  left ")).unwrap();
    assert!(line.contains("paused") && line.contains(" 7 ") && line.contains("plane"), "{line}");
    for part in ["ARENA", "STREAMS OF right", "nobody reads it", "CLIENTS OF left", "nobody"] {
        assert!(table.stdout.contains(part), "{part}: {}", table.stdout);
    }
    let lines = server.tool(&["top", "--once", "--json"]).stdout;
    let rows: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(rows.len(), 2);
    assert_eq!((&rows[0]["arena"], &rows[0]["tick"]), (&"left".into(), &7.into()));
    assert!(rows[1]["stats"]["streams"]["state"]["bytes_per_s"].is_number(), "{lines}");
    let metrics = server.tool(&["metrics"]);
    assert!(metrics.stdout.contains("ballroom_tick{arena=\"left\"} 7\n"), "{}", metrics.stdout);
    let no_terminal = server.tool(&["top"]);
    assert!(no_terminal.code == 1 && no_terminal.stderr.contains("--once"), "{}", no_terminal.stderr);
}
