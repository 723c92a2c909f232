//! H24: one run in other guises: at other rates, in shards on threads of their own, paused at odd times, saved and loaded.

use crate::case::Case;
use crate::demand::{Demand, Span};
use crate::gas;
use crate::ride::run;
use crate::scenes::{all_bits, cloud, graph, original, random};
use ballroom_physics::{Checkpoint, Controller, MotionLaw, Scene, SceneFault, Shard, Time};

const RATE_HZ: u32 = 60;

/// Everything that is shown: the state hash, every bit of every ball, the energy's bits.
fn shown(engine: &Controller) -> (u64, Vec<u64>, u64) {
    (engine.state_hash(), all_bits(engine), engine.energy().to_bits())
}

/// Every shard on a thread of its own.
fn on_threads(shards: &mut Vec<Shard>, until: Time) {
    std::thread::scope(|scope| {
        for shard in shards {
            scope.spawn(move || shard.advance_to(until));
        }
    });
}

/// Ticks that differ between the gas in one piece and in shards, and the share of phases that were not run apart.
fn divided(count: usize, seconds: u64) -> Result<[f64; 2], SceneFault> {
    let mut apart = Controller::new(&gas::on_a_bowl(1500))?;
    let mut whole = apart.clone();
    apart.divide(count);
    let mut differing = 0;
    for tick in 1..=seconds * u64::from(RATE_HZ) {
        let time = Time::of_tick(tick, RATE_HZ);
        whole.advance_to(time);
        apart.advance_divided(time, &mut on_threads);
        differing += u64::from(shown(&whole) != shown(&apart) || whole.hits() != apart.hits());
    }
    let together = match apart.division() {
        None => f64::from(u8::from(count > 1)),
        Some(went) if went.shards == count => {
            let [kept, other] = [went.kept, went.undone + went.in_one].map(|phases| phases as f64);
            other / (kept + other)
        }
        Some(_) => 1.0,
    };
    Ok([differing as f64, together])
}

/// Seconds at which a bit or the hash differs from the run at 60 Hz.
fn rates(rate_hz: u32, seconds: u64) -> Result<[f64; 1], SceneFault> {
    let look = |rate_hz: u32| {
        let mut states = vec![];
        run(&original(), rate_hz, seconds * u64::from(rate_hz), |tick, engine| {
            if tick.is_multiple_of(u64::from(rate_hz)) {
                states.push(shown(engine));
            }
        })?;
        Ok(states)
    };
    let (own, other) = (look(RATE_HZ)?, look(rate_hz)?);
    Ok([own.iter().zip(&other).filter(|(a, b)| a != b).count() as f64])
}

/// Ticks that differ from the straight run when the run is written as words every second, and read by an engine that was
/// just made of the scene. Words that are refused differ.
fn saved(scene: &Scene, seconds: u64) -> Result<[f64; 1], SceneFault> {
    let mut straight = Controller::new(scene)?;
    let mut stopped = straight.clone();
    let mut differing = 0;
    for tick in 1..=seconds * u64::from(RATE_HZ) {
        for engine in [&mut straight, &mut stopped] {
            engine.advance_to(Time::of_tick(tick, RATE_HZ));
        }
        if tick.is_multiple_of(u64::from(RATE_HZ)) {
            let words = stopped.checkpoint().words().to_vec();
            stopped = Controller::new(scene)?;
            differing += u64::from(stopped.restore(&Checkpoint::of_words(words)).is_err());
        }
        differing += u64::from(shown(&straight) != shown(&stopped));
    }
    Ok([differing as f64])
}

/// Ticks that differ from the straight run when the run halts at random instants between them, is asked there to go to
/// where it stands and to where it was, and goes on; and pauses at which a ball, the hash or the time moved, or a hit was told.
fn paused(scene: &Scene, seconds: u64) -> Result<[f64; 2], SceneFault> {
    let mut straight = Controller::new(scene)?;
    let mut halting = straight.clone();
    let mut next = random(24);
    let (mut differing, mut restless) = (0, 0);
    let at = |tick| Time::of_tick(tick, RATE_HZ);
    for tick in 1..=seconds * u64::from(RATE_HZ) {
        straight.advance_to(at(tick));
        let mut halts: Vec<f64> = (0..(5.0 * next()) as usize).map(|_| next() / f64::from(RATE_HZ)).collect();
        halts.sort_by(f64::total_cmp);
        for halt in halts {
            let here = at(tick - 1).after(halt);
            halting.advance_to(here);
            let before = (shown(&halting), halting.time());
            for again in [here, at(tick - 1), Time::ZERO, here] {
                halting.advance_to(again);
                restless +=
                    u64::from((shown(&halting), halting.time()) != before || !halting.hits().is_empty());
            }
        }
        halting.advance_to(at(tick));
        differing += u64::from(shown(&straight) != shown(&halting));
    }
    Ok([differing as f64, restless as f64])
}

/// Forty balls of mixed radii that roll and hit in a bumpy bowl.
fn crowd() -> Scene {
    let mut scene = graph(1.5, &[(2, 0, 0.1), (0, 2, 0.12), (3, 1, 0.01)], MotionLaw::Rolling);
    scene.balls = cloud(40, [0.05, 0.12], 1.3, 3.0, 24);
    scene
}

/// The cases of this family.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![];
    for rate_hz in [30, 240, 1000] {
        cases.push(Case::new(
            format!("H24/{rate_hz}-hz"),
            format!("the scene original at {rate_hz} Hz and at 60 Hz"),
            [Demand::never("seconds that differ", Span::Seconds(30.0))],
            move || rates(rate_hz, 30),
        ));
    }
    for shards in [1, 2, 8] {
        let span = Span::Seconds(3.0);
        cases.push(Case::new(
            format!("H24/{shards}-shards"),
            format!("a gas of 1500 in a bowl, shards: {shards}, each on a thread of its own"),
            [
                Demand::never("ticks that differ", span),
                // Else it was never divided. A phase is undone when a ball was moved from beyond the halo.
                Demand {
                    norm: "share",
                    ..Demand { limit: 0.1, ..Demand::never("phases not run apart", span) }
                },
            ],
            move || divided(shards, 3),
        ));
    }
    for (name, scene, seconds) in [("original", original(), 30), ("crowd", crowd(), 10)] {
        let (span, twin) = (Span::Seconds(seconds as f64), scene.clone());
        cases.push(Case::new(
            format!("H24/saved-{name}"),
            format!("{name}, written as words and read again every second"),
            [Demand::never("ticks that differ", span)],
            move || saved(&scene, seconds),
        ));
        cases.push(Case::new(
            format!("H24/paused-{name}"),
            format!("{name}, halted up to four times a tick, asked to stay and to go back, resumed"),
            [Demand::never("ticks that differ", span), Demand::never("pauses that changed something", span)],
            move || paused(&twin, seconds),
        ));
    }
    cases
}
