//! What the descriptions of the built-in scenes promise.

use ballroom_physics::surface::certify::certify;
use ballroom_physics::{BallState, Controller, Hit, HitPartner, Time};
use nalgebra::Vector3;
use server::SceneText;
use server::scene_file::built_in_names;

const RATE_HZ: u32 = 60;

/// A built-in scene being watched; balls go by name.
struct Watched {
    engine: Controller,
    names: Vec<String>,
    tick: u64,
}

impl Watched {
    fn open(scene: &str) -> Self {
        let loaded = SceneText::open(scene).unwrap().load().unwrap();
        let engine = loaded.controller().unwrap();
        let names = engine.scene_index().iter().map(|&i| loaded.physics().balls[i].name.clone()).collect();
        Self { engine, names, tick: 0 }
    }

    fn id(&self, name: &str) -> usize {
        self.names.iter().position(|n| n == name).unwrap()
    }

    fn ball(&self, name: &str) -> BallState {
        self.engine.ball(self.id(name))
    }

    fn step(&mut self) {
        self.tick += 1;
        self.engine.advance_to(Time::of_tick(self.tick, RATE_HZ));
    }

    fn run(&mut self, seconds: u64) {
        (0..seconds * u64::from(RATE_HZ)).for_each(|_| self.step());
    }

    /// Hits of the first `seconds`.
    fn hits(&mut self, seconds: u64) -> Vec<Hit> {
        let mut all = vec![];
        for _ in 0..seconds * u64::from(RATE_HZ) {
            self.step();
            all.extend_from_slice(self.engine.hits());
        }
        all
    }
}

/// Boxes and pairs of boxes that the certificates of the built-in scenes may take: some half more than they do.
const CERTIFIED_IN: [(&str, [usize; 2]); 16] = [
    ("bicubic", [400, 7_500]),
    ("bowl", [500, 200]),
    ("break", [6, 27]),
    ("bullet", [6, 27]),
    ("corner", [6, 27]),
    ("cradle", [6, 27]),
    ("derby", [300, 130]),
    ("galperin", [6, 27]),
    ("gas", [36, 39]),
    ("monkey", [340, 1_800]),
    ("original", [1_100, 4_000]),
    ("original_frictionless", [1_100, 4_000]),
    ("plane", [6, 27]),
    ("saddle", [250, 63]),
    ("thousand", [580, 330]),
    ("trough", [72, 620]),
];

#[test]
fn every_built_in_floor_is_certified_within_its_own_boxes() {
    assert!(built_in_names().all(|name| CERTIFIED_IN.iter().any(|(known, _)| *known == name)));
    for (name, [boxes, pairs]) in CERTIFIED_IN {
        let scene = Watched::open(name);
        let gravity = SceneText::open(name).unwrap().load().unwrap().physics().gravity;
        let certificate = certify(scene.engine.patch(), &-gravity);
        assert_eq!(certificate.regular, Ok(()), "{name}");
        assert!(
            certificate.boxes <= boxes && certificate.pairs <= pairs,
            "{name}: {} boxes and {} pairs",
            certificate.boxes,
            certificate.pairs
        );
    }
}

#[test]
fn on_the_saddle_nobody_leaves_the_ridge_line_by_a_bit() {
    let mut saddle = Watched::open("saddle");
    for _ in 0..60 {
        saddle.run(1);
        assert!(saddle.engine.balls().all(|ball| ball.center.y == 0.0));
    }
    assert!(saddle.engine.report().collisions.ball_ball > 40);
}

#[test]
fn on_the_monkey_saddle_the_middle_stays_and_the_legs_are_mirror_twins() {
    let mut monkey = Watched::open("monkey");
    let start = monkey.ball("player");
    for _ in 0..10 {
        monkey.run(1);
        assert_eq!(monkey.ball("player"), start);
        let [left, right] = ["left-leg", "right-leg"].map(|name| monkey.ball(name).center);
        assert_eq!(left, Vector3::new(right.x, -right.y, right.z));
    }
    assert_eq!(monkey.engine.report().negative_reaction, 0.0);
}

#[test]
fn in_the_trough_travel_and_spin_keep_their_sum_of_squares_and_the_spinner_gets_nowhere() {
    let mut trough = Watched::open("trough");
    let sum = |ball: BallState| {
        let spin = 0.25 * ball.omega.dot(&ball.normal);
        ball.velocity.x.powi(2) + 2.0 / 7.0 * spin * spin
    };
    let before = ["player", "spinning"].map(|name| sum(trough.ball(name)));
    // The scene asks for 1e-9 m over 10 s, and these speeds are near 1 m/s.
    let mut farthest = 0.0_f64;
    for _ in 0..600 {
        trough.step();
        for (name, before) in ["player", "spinning"].iter().zip(before) {
            assert!((sum(trough.ball(name)) - before).abs() < 1e-9, "{name}");
        }
        farthest = farthest.max(trough.ball("spinning").center.x.abs());
    }
    assert!((0.1..1.0).contains(&farthest), "{farthest}");
    assert_eq!(trough.engine.report().negative_reaction, 0.0);
}

#[test]
fn the_break_is_one_impact_and_for_two_seconds_its_halves_are_mirror_images() {
    let mut table = Watched::open("break");
    // Each row from one side to the other; a ball in the middle is its own twin.
    let rows: [&[&str]; 5] = [
        &["01"],
        &["02", "03"],
        &["04", "05", "06"],
        &["07", "08", "09", "10"],
        &["11", "12", "13", "14", "15"],
    ];
    for _ in 0..2 * RATE_HZ {
        table.step();
        for row in rows {
            for (low, high) in row.iter().zip(row.iter().rev()) {
                let [low, high] = [low, high].map(|name| table.ball(name).center);
                let apart = (low - Vector3::new(high.x, -high.y, high.z)).norm();
                assert!(apart < 1e-13, "{apart:e} m at tick {}", table.tick);
            }
        }
    }
    assert!(table.engine.report().clusters >= 1);
}

#[test]
fn corners_turn_balls_by_two_three_and_six_hits() {
    let mut room = Watched::open("corner");
    let before = ["square", "sixty", "thirty"].map(|name| room.ball(name).velocity);
    // Then two of them meet.
    let hits = room.hits(3);
    assert!(hits.iter().all(|hit| matches!(hit.partner, HitPartner::Wall(_))), "{hits:?}");
    let count = |name: &str| hits.iter().filter(|hit| hit.ball == room.id(name)).count();
    assert_eq!(["square", "sixty", "thirty"].map(count), [2, 3, 6]);
    assert!((room.ball("square").velocity + before[0]).norm() < 1e-12);
    assert!((room.ball("thirty").velocity + before[2]).norm() < 1e-12);
}

#[test]
fn the_bullet_meets_the_pin_on_its_first_pass_and_nothing_leaves_the_room() {
    let mut room = Watched::open("bullet");
    room.step();
    let first = room.engine.hits()[0];
    let [shot, pin] = ["shot", "pin"].map(|name| room.id(name));
    assert_eq!((first.ball, first.partner), (pin.min(shot), HitPartner::Ball(pin.max(shot))));
    for _ in 0..600 {
        room.step();
        assert!(room.engine.balls().all(|b| b.center.x.abs() < 1.0 && b.center.y.abs() < 0.5));
    }
}

#[test]
fn on_the_bicubic_the_ball_is_where_the_description_says() {
    let mut bowl = Watched::open("bicubic");
    bowl.run(10);
    let error = (bowl.ball("player").center - Vector3::new(0.628_522_87, 0.480_545_48, 0.526_132_94)).norm();
    assert!(error < 1e-8, "{error}");
}
