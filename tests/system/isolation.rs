//! Ten clients at once that stop, flood, talk nonsense or vanish.

use crate::states::done;
use nix::sys::signal::Signal;
use protocol::command::Command;
use std::time::{Duration, Instant};
use tests::{Crowd, Kind, PATIENCE, Server, run, simulate, turn, until};

/// Most refusals of one link in a second.
const REFUSED_PER_S: f64 = 100.0;
/// Most presses of one player that are let through in a second.
const PRESSES_PER_S: f64 = 120.0;

/// Ticks a second.
const RATE_HZ: u64 = 60;

/// Lets a crowd loose on a server and compares the run with one that nobody was at.
fn hold(balls: &str, rage: Duration) {
    let server = Server::start(&["gas", "--balls", balls]);
    let client = server.client();
    let mut crowd = Crowd::at(server.endpoint());
    crowd.rage_for(rage);
    // A healthy client is heard and answered amid it.
    let paused = done(&client, &Command::Pause {}).tick;
    let second = paused / RATE_HZ + 1;
    done(&client, &Command::Step { ticks: second * RATE_HZ - paused });
    let state = client.snapshot().unwrap().snapshot;
    assert_eq!(state.tick, second * RATE_HZ);
    let stats = client.stats().unwrap();
    assert!(stats.commands_refused > 0, "the crowd was heard: {stats:?}");
    drop(crowd);

    let seconds = second.to_string();
    let twin = run(
        "ballroom",
        &["simulate", "gas", "--balls", balls, "--until", &seconds, "--every", &seconds, "--json"],
    );
    let hash = format!("\"state_hash\":\"{:016x}\"", state.state_hash);
    assert!(twin.stdout.lines().last().is_some_and(|line| line.contains(&hash)), "{hash} at {seconds} s");
    assert_eq!(server.end(Signal::SIGTERM).code, Some(0));
}

#[test]
fn ten_rough_clients_leave_a_hundred_balls_where_they_would_have_been() {
    let _turn = turn();
    hold("100", Duration::from_secs(4));
}

#[test]
fn ten_rough_clients_leave_ten_thousand_balls_where_they_would_have_been() {
    let _turn = turn();
    hold("10000", Duration::from_secs(3));
}

#[test]
fn who_floods_is_read_no_faster_than_a_rest_after_each_refusal_allows() {
    let _turn = turn();
    let server = Server::start(&["original"]);
    let client = server.client();
    let floods = [Kind::Presses, Kind::Nonsense];
    let mut crowd = Crowd::of(&floods, server.endpoint());
    let (before, began) = (client.stats().unwrap().commands_refused, Instant::now());
    crowd.rage_for(Duration::from_secs(3));
    let refused = client.stats().unwrap().commands_refused - before;
    // Both press as one player, whose presses for a ball that is not there are refused at the tick. The first figures may be a
    // second old, and a bucket holds one more.
    let most = (REFUSED_PER_S * floods.len() as f64 + PRESSES_PER_S) * (began.elapsed().as_secs_f64() + 2.0);
    assert!(refused > 0 && refused as f64 <= most, "{refused} refused, at most {most}");
    // Another's link is not held up by it.
    done(&client, &Command::Pause {});
}

#[test]
fn a_healthy_client_goes_on_hearing_true_states_beside_ten_rough_ones() {
    let _turn = turn();
    let server = Server::start(&["thousand"]);
    let client = server.client();
    let mut states = client.subscribe_state().unwrap();
    let mut crowd = Crowd::at(server.endpoint());
    let mut heard: Vec<(u64, u64)> = Vec::new();
    until("a hundred states, the crowd raging", PATIENCE, || {
        crowd.rage_for(Duration::from_millis(500));
        // The ring holds the newest only, and between two looks there are thirty.
        let more = Instant::now() + Duration::from_millis(500);
        while let Some(state) = states.recv_timeout(more.saturating_duration_since(Instant::now())).unwrap() {
            heard.push((state.tick, state.state_hash));
        }
        (heard.len() >= 100).then_some(())
    });
    drop(crowd);
    let last = heard[heard.len() - 1].0;
    let twin = simulate("thousand", (last / RATE_HZ + 1) as u32);
    for (tick, hash) in heard {
        assert_eq!(format!("{hash:016x}"), twin[tick as usize].state_hash, "tick {tick}");
    }
}
