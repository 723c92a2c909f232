//! What a gas costs in one piece and in shards on as many threads, in CPU and in wall time:
//! `cargo bench -p ballroom-physics --bench shards -- [bowl|plane] [balls ...] [--shards N] [--seconds S] [--save]`.
//!
//! Ticks of 60 Hz for S simulated seconds (1) after half a second of warming up. Kept and undone count phases, cuts how
//! often balls were dealt out anew; copies are what shards have beside their own, over all balls. Hashes must agree.
//! `--save` keeps the table for this machine.

#[path = "common/results.rs"]
mod results;

use ballroom_cases::gas;
use ballroom_physics::{Controller, Shard, Time};
use cpu_time::ProcessTime;
use results::Results;
use std::time::Instant;

const RATE_HZ: u32 = 60;

fn main() -> std::io::Result<()> {
    let mut results = Results::of("shards");
    let words: Vec<String> = std::env::args().skip(1).collect();
    let after = |name: &str| words.iter().skip_while(|word| *word != name).nth(1);
    let shards = after("--shards").and_then(|n| n.parse().ok()).unwrap_or(2);
    let seconds = after("--seconds").and_then(|s| s.parse().ok()).unwrap_or(1.0);
    let plain = words.iter().take_while(|word| !word.starts_with("--"));
    let mut counts: Vec<usize> = plain.clone().filter_map(|word| word.parse().ok()).collect();
    if counts.is_empty() {
        counts = vec![1_000, 10_000, 100_000];
    }
    let floors: Vec<&String> = plain.filter(|word| word.parse::<usize>().is_err()).collect();
    results.line(
        "floor     balls  shards  CPU s per s  wall s per s    kept  undone  in one    cuts  copies  state hash",
    );
    for floor in
        ["bowl", "plane"].iter().filter(|name| floors.is_empty() || floors.iter().any(|f| f == *name))
    {
        for count in &counts {
            let scene = if *floor == "plane" { gas::on_a_plane(*count) } else { gas::on_a_bowl(*count) };
            let start = Controller::new(&scene).unwrap_or_else(|fault| panic!("the gas is refused: {fault}"));
            for shards in [1, shards] {
                let mut engine = start.clone();
                engine.divide(shards);
                let ticks = (seconds * f64::from(RATE_HZ)).ceil() as u64;
                advance(&mut engine, 0, 30);
                let (cpu, wall) = (ProcessTime::now(), Instant::now());
                advance(&mut engine, 30, 30 + ticks);
                let spent = [cpu.elapsed(), wall.elapsed()].map(|t| t.as_secs_f64() / seconds);
                let went = engine.division().unwrap_or_default();
                results.line(format_args!(
                    "{floor:<6}{count:>9}{shards:>8}{:>13.4}{:>14.4}{:>8}{:>8}{:>8}{:>8}{:>7.1}%  {:016x}",
                    spent[0],
                    spent[1],
                    went.kept,
                    went.undone,
                    went.in_one,
                    went.cuts,
                    100.0 * went.copies as f64 / *count as f64,
                    engine.state_hash(),
                ));
            }
        }
    }
    results.finish()
}

fn advance(engine: &mut Controller, from: u64, to: u64) {
    let on_threads = &mut |shards: &mut Vec<Shard>, until| {
        std::thread::scope(|scope| {
            for shard in shards {
                scope.spawn(move || shard.advance_to(until));
            }
        });
    };
    for tick in from + 1..=to {
        engine.advance_divided(Time::of_tick(tick, RATE_HZ), on_threads);
    }
}
