//! What ten rough clients cost a healthy one: `cargo bench --workspace --bench isolation [-- SECONDS]`.
//!
//! For 100 and 10 000 balls at 60 Hz: ticks that ended late, states the healthy client heard of those published, and their
//! age when they were read (the server's wall clock at the tick to this process's, which is the same clock), without and
//! with the crowd, turn about.

use ballroom_client::Client;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tests::{Crowd, Server};

/// What a healthy client saw.
struct Seen {
    ticks: u64,
    late: u64,
    heard: usize,
    /// Ascending.
    ages_ms: Vec<f64>,
}

impl Seen {
    fn age_ms(&self, share: f64) -> f64 {
        self.ages_ms.get((share * self.ages_ms.len() as f64) as usize).copied().unwrap_or(f64::NAN)
    }
}

fn look(client: &Client, time: Duration) -> Seen {
    let mut states = client.subscribe_state().expect("a subscription");
    let before = client.stats().expect("an answer");
    let (end, mut ages_ms) = (Instant::now() + time, Vec::new());
    while let Some(state) =
        states.recv_timeout(end.saturating_duration_since(Instant::now())).expect("a session")
    {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).expect("after 1970").as_nanos() as u64;
        ages_ms.push(now.saturating_sub(state.wall_ns) as f64 * 1e-6);
    }
    let after = client.stats().expect("an answer");
    ages_ms.sort_by(f64::total_cmp);
    Seen {
        ticks: after.tick - before.tick,
        late: after.overruns - before.overruns,
        heard: ages_ms.len(),
        ages_ms,
    }
}

fn main() {
    let seconds = std::env::args().find_map(|argument| argument.parse().ok()).unwrap_or(10);
    let time = Duration::from_secs(seconds);
    println!(
        "{:>6} {:>8} {:>6} {:>5} {:>6} {:>11} {:>11}",
        "balls", "crowd", "ticks", "late", "heard", "age p50/ms", "age p99/ms"
    );
    for balls in ["100", "10000"] {
        let server = Server::start(&["gas", "--balls", balls]);
        let client = server.client();
        let mut p99 = [Vec::new(), Vec::new()];
        for round in 0..6 {
            let is_rough = round % 2 == 1;
            let crowd = is_rough.then(|| Crowd::at(server.endpoint()));
            let seen = std::thread::scope(|scope| {
                if let Some(mut crowd) = crowd {
                    scope.spawn(move || crowd.rage_for(time));
                }
                look(&client, time)
            });
            println!(
                "{balls:>6} {:>8} {:>6} {:>5} {:>6} {:>11.2} {:>11.2}",
                if is_rough { "ten" } else { "none" },
                seen.ticks,
                seen.late,
                seen.heard,
                seen.age_ms(0.5),
                seen.age_ms(0.99)
            );
            p99[usize::from(is_rough)].push(seen.age_ms(0.99));
        }
        let [quiet, rough] = p99.map(|mut ages| {
            ages.sort_by(f64::total_cmp);
            ages[ages.len() / 2]
        });
        println!("{balls:>6} balls: median age p99 {:.2} times that without them", rough / quiet);
    }
}
