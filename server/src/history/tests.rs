//! Runs driven by hand that go back to where they were.

use super::*;
use crate::recording::obey;
use crate::scene_file::SceneText;
use crate::simulation::{Moment, Simulation};
use crate::workshop::Bench;
use protocol::command::{Command, Refusal, code};
use protocol::snapshot::Snapshot;
use protocol::timeline::Rewind;
use std::collections::BTreeMap;
use std::sync::Arc;

fn simulation(scene: &str) -> Simulation {
    let loaded = SceneText::open(scene).unwrap().with_balls((scene == "gas").then_some(40)).load().unwrap();
    Simulation::new(Arc::new(loaded), 60, 7).unwrap()
}

/// What was published, without what a clock or an epoch makes of it.
fn published(simulation: &Simulation) -> Snapshot {
    let mut out = Snapshot::default();
    simulation.write_snapshot(&mut out);
    Snapshot { epoch: 0, ..out }
}

struct Random(u64);

impl Random {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % bound
    }
}

/// A run, its history, and what was published at each place of it that can still be gone back to.
struct Ride {
    simulation: Simulation,
    bench: Bench,
    chronicle: Chronicle,
    shown: BTreeMap<Place, Snapshot>,
}

impl Ride {
    fn new(scene: &str, settings: Settings) -> Self {
        let simulation = simulation(scene);
        let chronicle = Chronicle::new(&simulation, settings);
        let shown = [(place(&simulation), published(&simulation))].into();
        Self { bench: Bench::new(&simulation), chronicle, simulation, shown }
    }

    fn tick(&mut self) {
        self.simulation.advance();
        self.chronicle.ticked(&self.simulation);
        self.shown.insert(place(&self.simulation), published(&self.simulation));
    }

    fn ticks(&mut self, count: u64) {
        (0..count).for_each(|_| self.tick());
    }

    fn command(&mut self, json: &str) -> Result<(), Refusal> {
        let command = Command::from_json(json).unwrap();
        let at = place(&self.simulation);
        if command.needs_the_past() {
            self.chronicle.obey(&mut self.simulation, &command)?;
        } else {
            obey(&mut self.simulation, &self.bench, &command).unwrap();
            self.chronicle.obeyed(at, command, &self.simulation);
        }
        if place(&self.simulation).0 != at.0 {
            self.shown.insert(place(&self.simulation), published(&self.simulation));
        }
        Ok(())
    }

    fn go_to(&mut self, (epoch, tick): Place) -> Result<(), Refusal> {
        let next = self.simulation.epoch() + 1;
        self.command(&format!(r#"{{"cmd":"rewind","tick":{tick},"epoch":{epoch}}}"#))?;
        assert_eq!(place(&self.simulation), (next, tick));
        // What came after lies on a line that was left.
        self.shown.retain(|shown, _| *shown <= (epoch, tick) || shown.0 == next);
        Ok(())
    }
}

fn place(simulation: &Simulation) -> Place {
    (simulation.epoch(), simulation.tick())
}

const COMMANDS: [&str; 12] = [
    r#"{"key":"up"}"#,
    r#"{"cmd":"steer","direction":[0.6,-0.8],"mode":"force"}"#,
    r#"{"cmd":"steer","direction":[-0.9,0.1],"mode":"force"}"#,
    r#"{"key":"left","down":false}"#,
    r#"{"cmd":"set_balls","balls":[{"name":"player","velocity_m_per_s":[1,0,0]}]}"#,
    r#"{"cmd":"reset"}"#,
    r#"{"cmd":"reset","scope":"time"}"#,
    r#"{"cmd":"reset","scope":"state"}"#,
    r#"{"cmd":"reset","seed":9}"#,
    r#"{"cmd":"save_state","slot":"a"}"#,
    r#"{"cmd":"load_state","slot":"a"}"#,
    r#"{"cmd":"load_scene","name":"bowl"}"#,
];

#[test]
fn going_back_anywhere_gives_what_was_published_there() {
    for (scene, seed) in [("original", 3), ("bowl", 17), ("original", 2026)] {
        let mut random = Random(seed);
        let mut ride = Ride::new(scene, Settings::live(DEFAULT_HISTORY_BYTES));
        ride.command(COMMANDS[9]).unwrap();
        for round in 0..60 {
            for _ in 0..random.below(4) {
                let rare = random.below(6) == 0;
                let command = COMMANDS[random.below(if rare { 12 } else { 5 }) as usize];
                ride.command(command).unwrap();
            }
            ride.ticks(random.below(90));
            if random.below(3) == 0 {
                let places: Vec<Place> = ride.shown.keys().copied().collect();
                let there = places[random.below(places.len() as u64) as usize];
                let then = ride.shown[&there].clone();
                ride.go_to(there).unwrap();
                assert_eq!(
                    published(&ride.simulation),
                    then,
                    "{scene}, seed {seed}, round {round}: {there:?}"
                );
            }
        }
        assert!(ride.simulation.epoch() > 20, "{}", ride.simulation.epoch());
    }
}

#[test]
fn seconds_reach_back_through_resets_and_ticks_do_not() {
    let mut ride = Ride::new("original", Settings::live(DEFAULT_HISTORY_BYTES));
    ride.ticks(300);
    ride.command(r#"{"cmd":"reset"}"#).unwrap();
    ride.ticks(60);
    let ahead = ride.command(r#"{"cmd":"rewind","tick":200}"#).unwrap_err();
    assert!(ahead.why.contains("lies ahead: it is tick 60 of epoch 8"), "{ahead}");
    let never = ride.command(r#"{"cmd":"rewind","tick":301,"epoch":7}"#).unwrap_err();
    assert!(never.why.contains("epoch 7 was left at tick 300"), "{never}");
    // A second back is the first state after the reset, two are before it.
    ride.command(r#"{"cmd":"rewind","seconds":1}"#).unwrap();
    assert_eq!(place(&ride.simulation), (9, 0));
    ride.ticks(60);
    ride.command(r#"{"cmd":"rewind","seconds":2}"#).unwrap();
    assert_eq!(place(&ride.simulation), (10, 240));
    assert_eq!(published(&ride.simulation), ride.shown[&(7, 240)]);
    // The count of ticks goes on through a rewind.
    ride.ticks(10);
    ride.command(r#"{"cmd":"rewind","tick":100}"#).unwrap();
    assert_eq!(published(&ride.simulation), ride.shown[&(7, 100)]);
    let gone = ride.command(r#"{"cmd":"rewind","tick":50,"epoch":9}"#).unwrap_err();
    assert!(gone.why.contains("did not lead to the present"), "{gone}");
    let far = ride.command(r#"{"cmd":"rewind","seconds":100}"#).unwrap_err();
    assert!(far.code == code::OPERATION_FAILED && far.why.contains("at tick 0 of epoch 7"), "{far}");
}

#[test]
fn a_full_history_keeps_its_bound_and_its_reach_and_the_last_ten_minutes_dense() {
    let simulation = simulation("original");
    let ground = Arc::new(simulation.ground());
    let mut moment = Moment::with_room(&ground);
    simulation.write_moment(&mut moment);
    let one = Past::new(&ground, &moment).bytes();
    // Room for as many points as the last ten minutes have twice, which is what all the time before may take.
    let max_bytes = ground.bytes() + 1300 * one;
    let mut store = Store::new(ground, Settings::live(max_bytes));
    for second in 0..7200 {
        moment.tick = 60 * second;
        store.point(&moment);
    }
    let now = (7, 60 * 7199);
    let entry = store.timeline(now).history;
    assert!(entry.bytes <= max_bytes && entry.reach_s == 7199.0, "{entry:?}");
    let run_forward = |seconds: f64| {
        let rewind = Command::Rewind(Rewind::by_seconds(seconds));
        let (command, plan) = store.plan(rewind, now).unwrap();
        let (Command::Rewind(Rewind { tick: Some(tick), .. }), Plan::Go(way)) = (command, plan) else {
            panic!()
        };
        (tick - way.from.place().1) as f64 / 60.0
    };
    for seconds in 0..600 {
        assert!(run_forward(f64::from(seconds) + 0.5) <= 1.0, "{seconds} s back");
    }
    let far = run_forward(3600.0);
    assert!((1.0..120.0).contains(&far), "an hour back it is {far} s to the point before");
}

#[test]
fn commands_that_fill_the_memory_cost_the_oldest() {
    let mut ride = Ride::new("original", Settings::live(200_000));
    for _ in 0..40 {
        for _ in 0..100 {
            ride.command(r#"{"key":"up"}"#).unwrap();
        }
        ride.ticks(30);
    }
    let now = place(&ride.simulation);
    let history = ride.chronicle.store().timeline(now).history;
    assert!(history.bytes <= 200_000 && history.oldest_tick > 0 && history.points > 0, "{history:?}");
}

#[test]
fn slots_are_bounded_and_a_stranger_is_named() {
    let mut ride = Ride::new("original", Settings::live(0));
    let none = ride.command(r#"{"cmd":"load_state","slot":"a"}"#).unwrap_err();
    assert!(none.code == code::NOT_FOUND && none.why.contains("none was saved yet"), "{none}");
    let off = ride.command(r#"{"cmd":"rewind","seconds":0}"#).unwrap_err();
    assert!(off.code == code::FEATURE_UNSUPPORTED && off.why.contains("--history"), "{off}");
    for slot in 0..protocol::timeline::MAX_SLOTS {
        ride.command(&format!(r#"{{"cmd":"save_state","slot":"s{slot}"}}"#)).unwrap();
    }
    let store = ride.chronicle.store();
    assert!(store.has_room_for("s1").is_ok());
    assert_eq!(store.has_room_for("another").unwrap_err().code, code::OPERATION_FAILED);
}

#[test]
fn a_state_as_text_is_the_same_run_and_belongs_to_its_scene() {
    let mut ride = Ride::new("original", Settings::live(0));
    ride.command(r#"{"cmd":"steer","direction":[0.6,-0.8],"mode":"force"}"#).unwrap();
    ride.ticks(17);
    let ground = Arc::new(ride.simulation.ground());
    let mut moment = Moment::with_room(&ground);
    ride.simulation.write_moment(&mut moment);
    let saved = Past::new(&ground, &moment).to_saved().unwrap();
    let text = serde_json::to_string(&saved).unwrap();
    let saved = serde_json::from_str(&text).unwrap();
    let mut twin = Past::of_saved(&ground, &saved).unwrap().simulation().unwrap();
    for _ in 0..60 {
        assert_eq!(published(&twin), published(&ride.simulation));
        twin.advance();
        ride.tick();
    }
    let other = Arc::new(simulation("bowl").ground());
    let why = Past::of_saved(&other, &saved).err().unwrap().to_string();
    assert!(why.contains("another scene"), "{why}");
    for (words, what) in [("", "damaged"), ("!", "damaged"), ("AAAA", "damaged")] {
        let broken = protocol::timeline::SavedState { words: words.into(), ..saved.clone() };
        assert!(Past::of_saved(&ground, &broken).is_err(), "{words} {what}");
    }
}

#[test]
fn a_tick_that_writes_its_history_takes_no_memory() {
    let mut simulation = simulation("original");
    let (archive, mut diary) = Archive::new(&simulation, Settings::live(DEFAULT_HISTORY_BYTES));
    let files = std::thread::spawn({
        let archive = archive.clone();
        move || archive.run()
    });
    for _ in 0..60 {
        simulation.advance();
        diary.ticked(&simulation);
    }
    let taken = allocation_counter::measure(|| {
        for _ in 0..600 {
            simulation.advance();
            diary.ticked(&simulation);
        }
    });
    assert_eq!(taken.count_total, 0);
    assert!(archive.timeline().history.points >= 2);
    drop(diary);
    files.join().unwrap();
    // And nobody waits for a tick thread that is gone.
    assert!(archive.saved(None).is_err());
}
