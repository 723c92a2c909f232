//! What a gas costs, on a bowl and on a plane, for 10 to 100 000 balls, and a crowd of radii 1000 : 1 with so many grains of
//! dust: `cargo bench -p ballroom-physics --bench gas -- [bowl|plane|dusty] [balls ...] [--seconds S] [--look] [--save]`.
//!
//! Each run is advanced by ticks of 60 Hz for S simulated seconds (20, or fewer for many balls) after half a second of
//! warming up, three times. Nothing but the last state is looked at; with `--look` every ball is read at every tick, orientation
//! and all. CPU is the process's own time, the least of the three. Overlap is the deepest at any impact, in the smallest radii; energy the relative change.
//! The exponent is the slope of the logarithms of cost and number by least squares. Beside the gas on a plane stands what the
//! same discs cost in the least program that moves them (`bare`), right after it. `--save` keeps the table for this machine.

#[path = "common/bare.rs"]
mod bare;
#[path = "common/results.rs"]
mod results;

use ballroom_cases::gas;
use ballroom_physics::{Controller, Observer, Report, Scene, Time};
use bare::Bare;
use cpu_time::ProcessTime;
use results::Results;

const RATE_HZ: u64 = 60;
const WARM_UP_TICKS: u64 = RATE_HZ / 2;
/// Times that a run is timed: other users of the machine only ever add.
const ROUNDS: u32 = 3;
const COUNTS: [usize; 5] = [10, 100, 1_000, 10_000, 100_000];
/// Grains of dust.
const DUST: [usize; 3] = [0, 1_000, 3_000];

struct Options {
    floors: Vec<String>,
    counts: Vec<usize>,
    seconds: Option<f64>,
    look: bool,
}

impl Options {
    /// Simulated seconds for so many balls.
    fn seconds_of(&self, balls: f64) -> f64 {
        self.seconds.unwrap_or_else(|| (2e4 / balls).clamp(1.0, 20.0))
    }
}

fn options() -> Options {
    let mut options = Options { floors: vec![], counts: vec![], seconds: None, look: false };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--seconds" => options.seconds = words.next().and_then(|s| s.parse().ok()),
            "--look" => options.look = true,
            "bowl" | "plane" | "dusty" => options.floors.push(word),
            word => options.counts.extend(word.parse::<usize>()),
        }
    }
    if options.floors.is_empty() {
        options.floors = ["bowl", "plane", "dusty"].map(String::from).to_vec();
    }
    options
}

fn main() -> std::io::Result<()> {
    let options = options();
    let mut results = Results::of("gas");
    for floor in &options.floors {
        results.line(format_args!(
            "{floor:<6}{:>8}{:>14}{:>12}{:>10}{:>12}{:>10}{:>14}{:>12}{:>18}",
            "balls",
            "CPU s per s",
            "hits/s",
            "us/hit",
            "hits/CPU s",
            "steps/hit",
            "energy error",
            "overlap/r",
            "state hash"
        ));
        let usual: &[usize] = if floor == "dusty" { &DUST } else { &COUNTS };
        let counts = if options.counts.is_empty() { usual } else { &options.counts };
        let costs: Vec<(f64, f64)> = counts
            .iter()
            .map(|count| {
                let scene = match floor.as_str() {
                    "plane" => gas::on_a_plane(*count),
                    "dusty" => gas::dusty(*count),
                    _ => gas::on_a_bowl(*count),
                };
                (scene.balls.len() as f64, measure(&scene, &options, &mut results))
            })
            .collect();
        if costs.len() > 1 && floor != "dusty" {
            results.line(format_args!("{floor}: cost grows as N^{:.3}", exponent(&costs)));
        }
        if floor == "plane" {
            beside_the_bare(&costs, &options, &mut results);
        }
    }
    results.finish()
}

/// CPU seconds a simulated second.
fn measure(scene: &Scene, options: &Options, results: &mut Results) -> f64 {
    let count = scene.balls.len();
    let smallest = scene.balls.iter().map(|ball| ball.radius).fold(f64::INFINITY, f64::min);
    let seconds = options.seconds_of(count as f64);
    let ticks = (seconds * RATE_HZ as f64).ceil() as u64;
    let mut engine = Controller::new(scene).unwrap_or_else(|fault| panic!("the gas is refused: {fault}"));
    run(&mut engine, 1..=WARM_UP_TICKS, options.look);
    let (before, energy) = (engine.report(), engine.energy());
    let (warm, mut cpu) = (engine.clone(), f64::INFINITY);
    for _ in 0..ROUNDS {
        engine.clone_from(&warm);
        let start = ProcessTime::now();
        run(&mut engine, WARM_UP_TICKS + 1..=WARM_UP_TICKS + ticks, options.look);
        cpu = cpu.min(start.elapsed().as_secs_f64());
    }
    let after = engine.report();
    let hits = |report: &Report| (report.collisions.ball_ball + report.collisions.ball_wall) as f64;
    let (hit, span) = (hits(&after) - hits(&before), ticks as f64 / RATE_HZ as f64);
    results.line(format_args!(
        "{:>14}{:>14.5}{:>12.0}{:>10.3}{:>12.0}{:>10.2}{:>14.1e}{:>12.1e}  {:016x}",
        count,
        cpu / span,
        hit / span,
        1e6 * cpu / hit,
        hit / cpu,
        (after.steps - before.steps) as f64 / hit,
        (engine.energy() / energy - 1.0).abs(),
        after.deepest_penetration / smallest,
        engine.state_hash(),
    ));
    cpu / span
}

/// The same discs in the bare program, and how many times as much ours cost, as CPU seconds a simulated second.
fn beside_the_bare(ours: &[(f64, f64)], options: &Options, results: &mut Results) {
    results.line(format_args!(
        "{:<6}{:>8}{:>14}{:>12}{:>10}{:>12}{:>10}{:>14}",
        "bare", "balls", "CPU s per s", "hits/s", "us/hit", "hits/CPU s", "plane is", "energy error"
    ));
    let cost = |(balls, ours): &(f64, f64)| {
        let mut bare = Bare::of(&gas::on_a_plane(*balls as usize));
        let seconds = options.seconds_of(*balls);
        bare.advance_to(WARM_UP_TICKS as f64 / RATE_HZ as f64);
        let (before, energy) = (bare.hits, bare.energy());
        let (warm, mut cpu) = (bare.clone(), f64::INFINITY);
        for _ in 0..ROUNDS {
            bare.clone_from(&warm);
            let start = ProcessTime::now();
            bare.advance_to(WARM_UP_TICKS as f64 / RATE_HZ as f64 + seconds);
            cpu = cpu.min(start.elapsed().as_secs_f64());
        }
        let hits = (bare.hits - before) as f64;
        results.line(format_args!(
            "{:>14}{:>14.5}{:>12.0}{:>10.3}{:>12.0}{:>9.2}x{:>14.1e}",
            balls,
            cpu / seconds,
            hits / seconds,
            1e6 * cpu / hits,
            hits / cpu,
            ours * seconds / cpu,
            (bare.energy() / energy - 1.0).abs(),
        ));
        (*balls, cpu / seconds)
    };
    let costs: Vec<(f64, f64)> = ours.iter().map(cost).collect();
    if costs.len() > 1 {
        results.line(format_args!("bare: cost grows as N^{:.3}", exponent(&costs)));
    }
}

fn run(engine: &mut Controller, ticks: std::ops::RangeInclusive<u64>, look: bool) {
    let mut observer = Observer::default();
    for tick in ticks {
        engine.advance_to(Time::of_tick(tick, RATE_HZ as u32));
        if look {
            engine.observe(&mut observer, |_, ball| {
                std::hint::black_box(ball);
            });
        }
    }
}

/// Slope of ln cost against ln number by least squares.
fn exponent(costs: &[(f64, f64)]) -> f64 {
    let n = costs.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| costs.iter().map(f).sum::<f64>() / n;
    let [x, y] = [mean(|c| c.0.ln()), mean(|c| c.1.ln())];
    let over: f64 = costs.iter().map(|c| (c.0.ln() - x) * (c.1.ln() - y)).sum();
    let under: f64 = costs.iter().map(|c| (c.0.ln() - x) * (c.0.ln() - x)).sum();
    over / under
}
