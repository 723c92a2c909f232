//! What the kernels cost, with the error beside every time.
//!
//! `cargo bench -p ballroom-physics --bench kernels`. Times are CPU times, the least of several rounds; errors are
//! the largest of a centre over all states at 60 Hz of 10 s, beside the same balls at 1e-13 m. `--save` keeps the table
//! for this machine.

#[path = "common/results.rs"]
mod results;

use ballroom_cases::scenes::walls;
use ballroom_physics::motion::arc::Arc;
use ballroom_physics::motion::body::{Body, Stepping};
use ballroom_physics::motion::follow;
use ballroom_physics::motion::together::{self, Landing, Launch, Seat};
use ballroom_physics::surface::bezier::BezierPatch;
use ballroom_physics::surface::chart::Surface;
use ballroom_physics::tolerance::STEP_FIRST;
use ballroom_physics::{Accuracy, BallSpec, Controller, Floor, HIT_BUDGET, MotionLaw, Place, Scene, Time};
use cpu_time::ProcessTime;
use nalgebra::{Vector2, Vector3};
use results::Results;
use std::hint::black_box;

/// Simulated seconds of a ride.
const SECONDS: u32 = 10;
/// Ticks a second at which errors are looked for.
const RATE_HZ: u32 = 60;
/// Evaluations of the right-hand side in a step that is kept, its first one and those of its dense output with it.
const STAGES: u32 = 16;
/// Those of a landing, the slope where it lands with them.
const STAGES_OF_A_LANDING: u32 = 12;
/// Balls that are turned at once.
const GROUP: usize = 8;
/// Free balls at once.
const BALLS: usize = 1000;

fn main() -> std::io::Result<()> {
    let mut results = Results::of("kernels");
    results.line(format_args!("{:<44}{:>12}{:>14}", "", "us per s", "error, m"));
    for tolerance in [1e-9, 1e-12] {
        alone(tolerance, &mut results);
        bound(tolerance, &mut results);
        free(tolerance, &mut results);
        bound_in_lanes(tolerance, &mut results);
    }
    results.finish()
}

/// The floor of the scene `bicubic`.
fn floor() -> Floor {
    let rows = [
        [1.710_229_780_346_295_6, 0.553_504_343_639_055_2, 0.450_363_397_597_931_2, 1.129_678_145_462_162_3],
        [0.027_750_408_838_121_188, 0.079_434_042_560_891_86, 0.964_083_212_494_554, 0.499_655_080_139_429_1],
        [
            0.771_191_378_348_111_4,
            -0.371_663_198_953_479_43,
            0.189_779_986_640_313_76,
            0.402_879_028_865_386_3,
        ],
        [1.058_057_598_468_017_6, 0.608_683_572_255_619_3, 0.578_508_968_081_267_8, 1.102_299_755_691_336_3],
    ];
    let heights = rows.map(Vec::from).to_vec();
    Floor::Bezier(BezierPatch::from_heights([-1.5, 1.5], [-1.5, 1.5], &heights).expect("a regular grid"))
}

fn scene(tolerance: f64) -> Scene {
    let player = BallSpec {
        name: "player".into(),
        radius: 0.05,
        mass: 1.0,
        inertia_factor: 0.4,
        place: Place::Uv(Vector2::new(0.3, 0.42)),
        velocity: Vector3::new(1.0, 0.6, 0.0),
        spin: 16.0,
    };
    Scene {
        floor: floor(),
        walls: walls([-1.5, 1.5], [-1.5, 1.5]),
        balls: vec![player],
        gravity: Vector3::new(0.0, 0.0, -9.81),
        motion: MotionLaw::Rolling,
        restitution: 1.0,
        accuracy: Accuracy::Tolerance(tolerance),
        hit_budget: HIT_BUDGET,
    }
}

/// What one ball cannot go below: its evaluations of the right-hand side, each of which waits for the one before.
fn bound(tolerance: f64, results: &mut Results) {
    let mut engine = Controller::new(&scene(tolerance)).expect("a good scene");
    engine.advance_to(Time::of_seconds(f64::from(SECONDS)));
    let evaluations = engine.report().steps * u64::from(STAGES) / u64::from(SECONDS);
    let free = Free::new(tolerance);
    let (surface, body) = (&free.surface, &free.bodies[0]);
    let mut state = free.arcs[0].state;
    let calls = 1000;
    let each = least(30, calls, || {
        let slope = body.slope(surface, &state);
        state.iter_mut().zip(&slope).for_each(|(y, s)| *y += 1e-12 * s);
    });
    black_box(state);
    let what = format!("alone, {tolerance:.0e} m, bound: {evaluations} of {:.0} ns", 1e9 * each);
    results.line(format_args!("{what:<44}{:>12.2}", evaluations as f64 * each * 1e6));
}

/// What one of many balls cannot go below: its evaluations in full lanes, as a landing makes them, and nothing kept of them.
fn bound_in_lanes(tolerance: f64, results: &mut Results) {
    let mut free = Free::new(tolerance);
    let before: u64 = free.steppings.iter().map(|stepping| stepping.steps).sum();
    free.advance(Time::of_seconds(f64::from(SECONDS)));
    let steps = free.steppings.iter().map(|stepping| stepping.steps).sum::<u64>() - before;
    let evaluations = steps * u64::from(STAGES) / u64::from(SECONDS) / BALLS as u64;
    let width = together::width(&free.surface, free.accuracy);
    let balls = free.bodies.iter().zip(&free.arcs).take(width);
    let seats: Vec<_> = balls.map(|(body, arc)| Some(Seat { body, arc, dt: 0.5 * arc.length })).collect();
    let mut landings = vec![Landing::NOWHERE; width];
    let each = least(30, 1000, || {
        let mut targets: Vec<_> = landings.iter_mut().map(Some).collect();
        together::land(&free.surface, free.accuracy, &seats, &mut targets);
    }) / (width as f64 * f64::from(STAGES_OF_A_LANDING));
    black_box(&landings);
    let what =
        format!("one of {BALLS} free, {tolerance:.0e} m, bound: {evaluations} of {:.0} ns", 1e9 * each);
    results.line(format_args!("{what:<44}{:>12.2}", evaluations as f64 * each * 1e6));
}

fn row(results: &mut Results, what: &str, us: f64, error: f64) {
    results.line(format_args!("{what:<44}{us:>12.2}{error:>14.1e}"));
}

/// The least CPU time of a call, s; each round makes `calls` of them.
fn least(rounds: u32, calls: u32, mut call: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..rounds {
        let start = ProcessTime::now();
        for _ in 0..calls {
            call();
        }
        best = best.min(start.elapsed().as_secs_f64() / f64::from(calls));
    }
    best
}

/// One ball in a whole engine: when states are asked for at the end only, and at every tick.
fn alone(tolerance: f64, results: &mut Results) {
    let start = Controller::new(&scene(tolerance)).expect("a good scene");
    let mut fine = Controller::new(&scene(1e-13)).expect("a good scene");
    let mut engine = start.clone();
    let mut error = 0.0_f64;
    for tick in 1..=u64::from(SECONDS * RATE_HZ) {
        for run in [&mut engine, &mut fine] {
            run.advance_to(Time::of_tick(tick, RATE_HZ));
        }
        error = error.max((engine.ball(0).center - fine.ball(0).center).norm());
    }
    for (rate, name) in [(1, "looked at once a second"), (RATE_HZ, "at 60 Hz")] {
        let mut engine = start.clone();
        let time = least(30, 20, || {
            engine.clone_from(&start);
            for tick in 1..=u64::from(SECONDS * rate) {
                engine.advance_to(Time::of_tick(tick, rate));
            }
            black_box(engine.ball(0));
        });
        row(results, &format!("alone, {tolerance:.0e} m, {name}"), time * 1e6 / f64::from(SECONDS), error);
    }
}

/// A ball of its own for each number, all in the same bowl and none in another's way.
struct Free {
    surface: Surface,
    accuracy: Accuracy,
    bodies: Vec<Body>,
    steppings: Vec<Stepping>,
    arcs: Vec<Arc>,
}

impl Free {
    fn new(tolerance: f64) -> Self {
        let patch = match floor() {
            Floor::Bezier(patch) => patch,
            Floor::Polynomial { .. } => unreachable!("the bench's floor is a net"),
        };
        let surface = Surface::new(&floor(), &patch, 1.0);
        let body =
            Body { radius: 0.05, inertia_factor: 0.4, rolls: true, applied: Vector3::new(0.0, 0.0, -9.81) };
        let accuracy = Accuracy::Tolerance(tolerance);
        let stepping = Stepping { try_s: STEP_FIRST, steps: 0, forced: 0 };
        let mut free = Self {
            surface,
            accuracy,
            bodies: vec![body; BALLS],
            steppings: vec![stepping; BALLS],
            arcs: vec![Arc::empty(body.radius); BALLS],
        };
        for ball in 0..BALLS {
            let (i, j) = ((ball % 32) as f64 / 32.0, (ball / 32) as f64 / 32.0);
            let mut state = [0.6 * i - 0.75, 0.6 * j - 0.42, 1.0 - 0.4 * i, 0.6 - 0.7 * j, 0.0, 0.8 - i * j];
            body.settle(&free.surface, &mut state);
            free.launch(ball, Time::ZERO, state);
        }
        free
    }

    fn launch(&mut self, ball: usize, start: Time, state: [f64; 6]) {
        let arc = &mut self.arcs[ball];
        arc.turning.start = arc.orientation_at(arc.length);
        let from = (start, &state);
        self.bodies[ball].launch(&self.surface, self.accuracy, from, &mut self.steppings[ball], arc);
    }

    /// Every ball's arc that reaches `time`, each ball for itself.
    fn advance(&mut self, time: Time) {
        for ball in 0..BALLS {
            while self.arcs[ball].finish() <= time {
                let (start, state) = (self.arcs[ball].finish(), self.arcs[ball].end);
                self.launch(ball, start, state);
            }
        }
    }

    /// The same, in full lanes.
    fn advance_together(&mut self, time: Time) {
        let Self { surface, accuracy, bodies, steppings, arcs } = self;
        loop {
            let balls = bodies.iter().zip(steppings.iter_mut()).zip(arcs.iter_mut());
            let mut due: Vec<_> = balls
                .filter(|(_, arc)| arc.finish() <= time)
                .map(|((body, stepping), arc)| Some(Launch { body, stepping, arc }))
                .collect();
            if due.is_empty() {
                return;
            }
            for group in due.chunks_mut(GROUP) {
                let mut q = [[0.0; 4]; GROUP];
                let mut courses = [None; GROUP];
                for (course, Launch { arc, .. }) in courses.iter_mut().zip(group.iter().flatten()) {
                    *course = Some((&arc.turning, arc.length / arc.scale));
                }
                follow::orientations(&courses[..group.len()], &mut [], &mut q[..group.len()]);
                for (Launch { arc, .. }, q) in group.iter_mut().flatten().zip(q) {
                    (arc.start, arc.state, arc.turning.start) = (arc.finish(), arc.end, q);
                }
            }
            together::launch(surface, *accuracy, &mut due);
        }
    }

    fn centers(&self, time: Time) -> impl Iterator<Item = Vector3<f64>> {
        self.arcs.iter().map(move |arc| arc.center_at(time.since(arc.start)))
    }
}

/// Many balls, arcs only.
fn free(tolerance: f64, results: &mut Results) {
    let (mut coarse, mut fine) = (Free::new(tolerance), Free::new(1e-13));
    let mut error = 0.0_f64;
    for tick in 1..=u64::from(SECONDS * RATE_HZ) {
        let time = Time::of_tick(tick, RATE_HZ);
        coarse.advance(time);
        fine.advance(time);
        let apart = coarse.centers(time).zip(fine.centers(time)).map(|(a, b)| (a - b).norm());
        error = apart.fold(error, f64::max);
    }
    let mut run = |name: &str, advance: fn(&mut Free, Time)| {
        let mut free = Free::new(tolerance);
        let mut seconds = 0;
        let time = least(30, 1, || {
            seconds += 1;
            advance(&mut free, Time::of_seconds(f64::from(seconds)));
        });
        row(
            results,
            &format!("one of {BALLS} free, {tolerance:.0e} m, {name}"),
            time * 1e6 / BALLS as f64,
            error,
        );
    };
    run("one at a time", Free::advance);
    run("side by side", Free::advance_together);
}
