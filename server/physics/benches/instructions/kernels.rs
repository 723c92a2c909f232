//! The kernels that most of the time goes to, each on inputs that differ from call to call.

use crate::counted::count;
use ballroom_cases::scenes;
use ballroom_physics::detect::ball_ball::{self, Standing};
use ballroom_physics::detect::ball_wall::{self, Plane};
use ballroom_physics::detect::broad_phase::{BroadPhase, swept_bounds};
use ballroom_physics::motion::arc::Arc;
use ballroom_physics::motion::body::{Body, Stepping};
use ballroom_physics::motion::law::State;
use ballroom_physics::schedule::event::{Next, What};
use ballroom_physics::schedule::queue::Queue;
use ballroom_physics::schedule::time::Time;
use ballroom_physics::surface::bezier::BezierPatch;
use ballroom_physics::surface::chart::Surface;
use ballroom_physics::{Accuracy, Floor, Scheme};
use nalgebra::{Vector2, Vector3};
use std::hint::black_box;

const TIMES: usize = 1000;
const RADIUS: f64 = 0.05;
/// A step that a ball of 1 m/s takes on these floors with a tolerance of 1e-9 m, s.
const STEP: Accuracy = Accuracy::Fixed(Scheme::Dop853, 0.125);

/// Counts all of them.
pub fn run() {
    let floors = [
        ("flat", Floor::Polynomial { x: [-1.5, 1.5], y: [-1.5, 1.5], terms: vec![] }),
        ("quadric", bowl()),
        ("bicubic", Floor::Bezier(bicubic(0.0))),
        ("general net", Floor::Bezier(bicubic(0.1))),
    ];
    for (name, floor) in &floors {
        for rolls in [true, false] {
            let motion = if rolls { "rolling" } else { "sliding" };
            motion_on(&format!("{motion} {name}"), floor, rolls);
        }
    }
    hits(&floors[1].1);
    broad_phase();
    queue();
}

fn bowl() -> Floor {
    let terms = vec![vec![0.0, 0.0, 0.25], vec![], vec![0.25]];
    Floor::Polynomial { x: [-1.5, 1.5], y: [-1.5, 1.5], terms }
}

/// A bumpy bowl; its middle columns are moved aside by `bend` m, which makes it a general net.
fn bicubic(bend: f64) -> BezierPatch {
    let heights =
        [[1.7, 0.55, 0.45, 1.1], [0.03, 0.08, 0.96, 0.5], [0.77, -0.37, 0.19, 0.4], [1.1, 0.61, 0.56, 1.1]];
    let net = (0..4).flat_map(|i| {
        let x = f64::from(i) - 1.5 + if i == 1 { bend } else { 0.0 };
        heights
            .map(|row| row[i as usize])
            .into_iter()
            .zip(0..)
            .map(move |(z, j)| Vector3::new(x, f64::from(j) - 1.5, z))
    });
    BezierPatch::new([3, 3], net.collect()).expect("a net of 16")
}

fn surface_of(floor: &Floor) -> Surface {
    let patch = match floor {
        Floor::Bezier(patch) => patch.clone(),
        Floor::Polynomial { x, y, terms } => {
            BezierPatch::from_polynomial(*x, *y, terms).expect("of low degree")
        }
    };
    let side = patch.orientation(&Vector3::z());
    Surface::new(floor, &patch, side)
}

fn body(rolls: bool) -> Body {
    let inertia_factor = if rolls { 0.4 } else { 0.0 };
    Body { radius: RADIUS, inertia_factor, rolls, applied: Vector3::new(0.0, 0.0, -9.81) }
}

/// Places in the middle third of the floor, 1 m/s over the ground.
fn states(surface: &Surface, body: &Body) -> Vec<State> {
    let mut random = scenes::random(1);
    let mut within = |half: f64| half * (2.0 * random() - 1.0);
    let [width, depth] = surface.width.map(|side| side / 6.0);
    let mut state = |_| {
        let v = Vector2::new(within(1.0), within(1.0)).normalize();
        let mut state = [within(width), within(depth), v.x, v.y, 0.0, 0.0];
        body.settle(surface, &mut state);
        state[5] = if body.rolls { within(0.5) } else { 0.0 };
        state
    };
    (0..TIMES).map(&mut state).collect()
}

fn launched(surface: &Surface, body: &Body, state: &State) -> Arc {
    let mut arc = Arc::empty(RADIUS);
    let mut stepping = Stepping { try_s: 0.125, steps: 0, forced: 0 };
    body.launch(surface, STEP, (Time::ZERO, state), &mut stepping, &mut arc);
    arc
}

fn motion_on(name: &str, floor: &Floor, rolls: bool) {
    let (surface, body) = (surface_of(floor), body(rolls));
    let states = states(&surface, &body);
    if !surface.is_flat() {
        count(&format!("right-hand side: {name}"), TIMES as u64, || {
            for state in &states {
                black_box(body.slope(&surface, state));
            }
        });
    }
    let mut arc = Arc::empty(RADIUS);
    let mut stepping = Stepping { try_s: 0.125, steps: 0, forced: 0 };
    count(&format!("launch of an arc: {name}"), TIMES as u64, || {
        for state in &states {
            body.launch(&surface, STEP, (Time::ZERO, state), &mut stepping, &mut arc);
            black_box(&arc);
        }
    });
    let mut arcs: Vec<Arc> = states.iter().map(|state| launched(&surface, &body, state)).collect();
    count(&format!("state at a tick: {name}"), TIMES as u64, || {
        for (arc, i) in arcs.iter().zip(0..) {
            black_box(arc.sample(&body, &surface, 0.1 * f64::from(i) / TIMES as f64));
        }
    });
    if rolls {
        count(&format!("orientation at a tick: {name}"), TIMES as u64, || {
            for (arc, i) in arcs.iter_mut().zip(0..) {
                black_box(arc.orientation_at(0.1 * f64::from(i) / TIMES as f64));
            }
        });
    }
}

/// Times of impact on curved arcs: a ball ahead in the same direction is caught up with, or passes beside.
fn hits(floor: &Floor) {
    let (surface, body) = (surface_of(floor), body(true));
    let states = states(&surface, &body);
    let arcs: Vec<Arc> = states.iter().map(|state| launched(&surface, &body, state)).collect();
    let met = |aside: f64| -> Vec<Arc> {
        let other = |state: &State| {
            let (v, apart) = (Vector2::new(state[2], state[3]), 0.05 + 2.0 * RADIUS);
            let ahead = v * (apart / v.norm()) + Vector2::new(-v.y, v.x) * (aside / v.norm());
            let mut state = [state[0] + ahead.x, state[1] + ahead.y, -0.5 * v.x, -0.5 * v.y, 0.0, 0.0];
            body.settle(&surface, &mut state);
            launched(&surface, &body, &state)
        };
        states.iter().map(other).collect()
    };
    for (name, aside) in [("hit", 0.0), ("miss", 0.11)] {
        let others = met(aside);
        let mut found = 0;
        count(&format!("time of impact of two balls: {name}"), TIMES as u64, || {
            for (a, b) in arcs.iter().zip(&others) {
                let now = (Standing::of(a, Time::ZERO), Standing::of(b, Time::ZERO));
                let hit =
                    ball_ball::time_of_impact((a, b), (&now.0, &now.1), Time::ZERO, 0.0625, 2.0 * RADIUS);
                found += usize::from(hit.is_some());
            }
        });
        assert_eq!(found, if name == "hit" { TIMES } else { 0 }, "{name}");
    }
    let mut found = 0;
    count("time of impact with a wall: hit", TIMES as u64, || {
        for (arc, state) in arcs.iter().zip(&states) {
            let toward = Vector3::new(state[2], state[3], 0.0).normalize();
            let plane = Plane { normal: -toward, point: arc.center[0] + toward * (RADIUS + 0.03) };
            let now = Standing::of(arc, Time::ZERO);
            found += usize::from(
                ball_wall::time_of_impact((arc, &now), &plane, Time::ZERO, 0.0625, RADIUS).is_some(),
            );
        }
    });
    assert_eq!(found, TIMES);
}

/// A thousand equal balls that cover a fifth of the floor.
fn broad_phase() {
    let mut random = scenes::random(1);
    let radii = vec![RADIUS; TIMES];
    let mut phase = BroadPhase::new(&radii, [0.0, 0.0, 6.3, 6.3]);
    let mut bounds = |_| {
        let center = Vector3::new(6.3 * random(), 6.3 * random(), 0.0);
        let velocity = Vector3::new(2.0 * random() - 1.0, 2.0 * random() - 1.0, 0.0);
        swept_bounds(&center, &velocity, 1.0, RADIUS, 0.0625)
    };
    let [first, second]: [Vec<_>; 2] = [0, 1].map(|_| (0..TIMES).map(&mut bounds).collect());
    first.iter().enumerate().for_each(|(ball, bounds)| phase.file(ball, *bounds));
    let mut met = 0;
    count("neighbours of one of 1000 balls", TIMES as u64, || {
        (0..TIMES).for_each(|ball| phase.neighbours(ball, |_| met += 1));
    });
    assert!(met > TIMES, "{met} neighbours");
    count("filing one of 1000 balls", TIMES as u64, || {
        second.iter().enumerate().for_each(|(ball, bounds)| phase.file(ball, *bounds));
    });
}

fn queue() {
    let mut random = scenes::random(2);
    let mut queue = Queue::new(TIMES);
    let mut next = || Next { time: Time::of_seconds(random()), what: What::Renew };
    (0..TIMES).for_each(|ball| queue.set(ball, next()));
    let later: Vec<Next> = (0..TIMES).map(|_| next()).collect();
    count("next event of one of 1000 balls", TIMES as u64, || {
        later.iter().enumerate().for_each(|(ball, next)| queue.set(ball, *next));
    });
    black_box(queue.first());
}
