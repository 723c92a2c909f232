//! The running error estimate, as clients get it, beside the error itself.

use tests::{PATIENCE, Server, State, run, turn, until};

/// Where the scene's one ball is after so many seconds, run at a tolerance without a network.
fn center_m(tolerance: &str, time_s: f64) -> [f64; 3] {
    let until = time_s.to_string();
    let output =
        run("ballroom", &["simulate", "bicubic", "--tolerance", tolerance, "--until", &until, "--json"]);
    assert_eq!(output.code, Some(0), "{}", output.stderr);
    let last: State = serde_json::from_str(output.stdout.lines().last().unwrap()).unwrap();
    last.center_m("player")
}

#[test]
fn a_server_says_how_far_its_balls_are_from_where_they_should_be() {
    let _turn = turn();
    let server = Server::start(&["bicubic", "--tolerance", "1e-6", "--estimate-error"]);
    let client = server.client();
    let found = until("a shadow that has followed for a while", PATIENCE, || {
        client.stats().unwrap().error_estimate.filter(|found| found.followed_s > 2.0)
    });
    assert_eq!((found.balls, found.asked_m, found.lost), (1, Some(1e-6), 0));
    // It began with the run.
    assert_eq!(found.followed_s, found.time_s);
    let (own, exact) = (center_m("1e-6", found.time_s), center_m("1e-13", found.time_s));
    let error_m = own.iter().zip(exact).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    assert!((found.error_m - error_m).abs() < 0.1 * error_m, "{found:?}, in truth {error_m:e} m");
    assert!(server.tool(&["metrics"]).stdout.contains("ballroom_error_metres{arena=\"main\"} "));
}

#[test]
fn who_asks_for_no_estimate_gets_none() {
    let _turn = turn();
    let server = Server::start(&["bicubic"]);
    let client = server.client();
    until("some ticks", PATIENCE, || (client.stats().unwrap().tick > 90).then_some(()));
    assert_eq!(client.stats().unwrap().error_estimate, None);
}
