//! What ten rough clients cost a healthy one:
//! `cargo bench --workspace --bench isolation [-- [--seconds S] [--rounds N] [--balls N]… [--with WORD]… [KIND…]]`.
//!
//! For 100 and 10 000 balls at 60 Hz: ticks that ended late, states the healthy client heard of those published, and their
//! age when they were read (the server's wall clock at the tick to this process's, which is the same clock), turn about
//!
//! | crowd | where the rough clients are |
//! |---|---|
//! | `none` | nowhere |
//! | `away` | on this machine, at another server of the same scene |
//! | `here` | at the server that is looked at |
//!
//! Rough clients and that other server get only processor time that others leave, and the healthy client comes before all, where
//! that is permitted: it shows what the server does, not what the healthy client's own machine has to do beside. What a crowd costs
//! all the same, in caches, memory, wake-ups and the kernel's side of loopback, `away` shows: on machines of its own it would not.
//! What `here` costs beyond `away` is what the server lets through, and what it must do for the crowd in its own threads.
//! The other server cannot serve a crowd as fast as one that has a core: of that part `away` shows less than there is. A crowd
//! also keeps cores awake, so that ticks may be late less often beside it than without.

use ballroom_client::Client;
use clap::Parser;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tests::{Crowd, Kind, PATIENCE, Process, Server, come_first};

/// How much longer a crowd stays than it is looked at.
const LONGER: Duration = Duration::from_secs(1);
/// What a crowd says when all of it is there.
const HERE: &str = "here";

/// Measure what ten rough clients cost a healthy one
#[derive(Parser)]
struct Arguments {
    /// Kinds of rough clients, all without any: stopped, slow, presses, nonsense, questions, bytes, vanishing
    #[arg(value_parser = |name: &str| Kind::named(name).ok_or("no kind of rough client"))]
    kinds: Vec<Kind>,
    /// Length of a window
    #[arg(long, default_value_t = 10)]
    seconds: u64,
    /// Windows of each sort
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    rounds: u16,
    /// Balls of the gas
    #[arg(long = "balls", default_values_t = [100, 10_000])]
    balls: Vec<u32>,
    /// One more word for `ballroom serve`, for instance --with=--threads=1; may be repeated
    #[arg(long = "with", value_name = "WORD")]
    with: Vec<String>,
    /// Be the crowd at this server for one window: the bench calls itself so
    #[arg(long, hide = true)]
    crowd_at: Option<String>,
    /// Given by cargo
    #[arg(long, hide = true)]
    bench: bool,
}

impl Arguments {
    fn words<'a>(&'a self, balls: &'a str) -> Vec<&'a str> {
        ["gas", "--balls", balls].into_iter().chain(self.with.iter().map(String::as_str)).collect()
    }

    fn window(&self) -> Duration {
        Duration::from_secs(self.seconds)
    }

    /// The crowd at a server for one window, begun by a process aside: to begin processes costs time too.
    fn crowd(&self, endpoint: &str) -> Process {
        let seconds = self.seconds.to_string();
        let kinds = self.kinds.iter().map(|kind| kind.name());
        let words = ["--crowd-at", endpoint, "--seconds", &seconds].into_iter().chain(kinds);
        let crowd = Process::start_again_aside(&words.collect::<Vec<_>>());
        crowd.said(PATIENCE, |line| (line == HERE).then_some(()));
        crowd
    }
}

/// Where the rough clients are.
#[derive(Clone, Copy)]
enum Place {
    Nowhere,
    Away,
    Here,
}

const PLACES: [(Place, &str); 3] = [(Place::Nowhere, "none"), (Place::Away, "away"), (Place::Here, "here")];

/// Does the work of the healthy client, before all else on this machine if that is permitted: as a machine of its own would. The
/// threads that its session begins come first too.
fn ahead<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    std::thread::scope(|scope| {
        let healthy = scope.spawn(|| {
            if !come_first() {
                eprintln!("not permitted to come first: ages hold waiting for a core that others have");
            }
            work()
        });
        healthy.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

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

/// A window with the rough clients somewhere.
fn look_beside(place: Place, server: &Server, client: &Client, balls: &str, arguments: &Arguments) -> Seen {
    let other = matches!(place, Place::Away).then(|| {
        let serve = ["serve", "-l", "tcp/127.0.0.1:0"];
        Server::of(Process::start_aside("ballroom", &[&serve[..], &arguments.words(balls)].concat()))
    });
    let at = match place {
        Place::Nowhere => None,
        Place::Away => other.as_ref(),
        Place::Here => Some(server),
    };
    let crowd = at.map(|server| arguments.crowd(server.endpoint()));
    let seen = ahead(|| look(client, arguments.window()));
    if let Some(crowd) = crowd {
        crowd.end(PATIENCE);
    }
    seen
}

/// Ten rough clients, until whoever looks has seen enough.
fn be_the_crowd(arguments: &Arguments, endpoint: &str) {
    let kinds = if arguments.kinds.is_empty() { &Kind::ALL[..] } else { &arguments.kinds };
    let mut crowd = Crowd::of(kinds, endpoint);
    println!("{HERE}");
    crowd.rage_for(arguments.window() + LONGER);
}

/// Windows of one sort, one after another.
#[derive(Default)]
struct Windows {
    late: Vec<f64>,
    missed: Vec<f64>,
    p50_ms: Vec<f64>,
    p99_ms: Vec<f64>,
}

impl Windows {
    fn add(&mut self, seen: &Seen) {
        let ticks = seen.ticks as f64;
        self.late.push(1e3 * seen.late as f64 / ticks);
        self.missed.push(1e3 * (ticks - seen.heard as f64).max(0.0) / ticks);
        self.p50_ms.push(seen.age_ms(0.5));
        self.p99_ms.push(seen.age_ms(0.99));
    }
}

/// The median of the windows, and the smallest and the largest.
fn spread(values: &[f64]) -> (f64, String) {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    let [least, median, most] = [0, values.len() / 2, values.len() - 1].map(|at| values[at]);
    (median, format!("{median:.2} ({least:.2} to {most:.2})"))
}

fn measure(balls: u32, arguments: &Arguments) {
    let balls = balls.to_string();
    let server = Server::start(&arguments.words(&balls));
    let client = ahead(|| server.client());
    let mut windows = PLACES.map(|_| Windows::default());
    for _ in 0..arguments.rounds {
        for (windows, (place, _)) in windows.iter_mut().zip(PLACES) {
            windows.add(&look_beside(place, &server, &client, &balls, arguments));
        }
    }
    let mut medians = [0.0; PLACES.len()];
    for ((windows, (_, name)), median) in windows.iter().zip(PLACES).zip(&mut medians) {
        let [late, missed, p50, p99] =
            [&windows.late, &windows.missed, &windows.p50_ms, &windows.p99_ms].map(|values| spread(values));
        *median = p99.0;
        println!("{balls:>6} {name:>6} {:>20} {:>20} {:>20} {:>22}", late.1, missed.1, p50.1, p99.1);
    }
    let [none, away, here] = medians;
    println!(
        "{balls:>6} balls: age p99 here {:.2} times that away, {:.2} times none",
        here / away,
        here / none
    );
}

fn main() {
    let arguments = Arguments::parse();
    if let Some(endpoint) = &arguments.crowd_at {
        return be_the_crowd(&arguments, endpoint);
    }
    println!("median (smallest to largest) of {} windows of {} s", arguments.rounds, arguments.seconds);
    println!(
        "{:>6} {:>6} {:>20} {:>20} {:>20} {:>22}",
        "balls", "crowd", "late / 1000 ticks", "missed / 1000", "age p50/ms", "age p99/ms"
    );
    for &balls in &arguments.balls {
        measure(balls, &arguments);
    }
}
