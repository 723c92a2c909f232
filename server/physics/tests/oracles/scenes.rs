//! Scenes in few words, and what tests ask of a run.

use ballroom_physics::surface::bezier::BezierPatch;
use ballroom_physics::{
    Accuracy, BallSpec, BallState, Controller, Floor, HIT_BUDGET, MotionLaw, Place, Scene, Time, Wall,
};
use nalgebra::{Vector2, Vector3};

/// Solid, hollow.
pub const SOLID: f64 = 2.0 / 5.0;
/// See [`SOLID`].
pub const HOLLOW: f64 = 2.0 / 3.0;

/// z = the sum of `c x^i y^j` over [-half, half]^2, in its own box, without balls.
pub fn graph(half: f64, terms: &[(usize, usize, f64)], motion: MotionLaw) -> Scene {
    let degree = terms.iter().map(|t| t.0.max(t.1)).max().unwrap_or(0);
    let mut table = vec![vec![0.0; degree + 1]; degree + 1];
    for (i, j, c) in terms {
        table[*i][*j] = *c;
    }
    let border = [-half, half];
    scene(Floor::Polynomial { x: border, y: border, terms: table }, border, border, motion)
}

/// The plane z = 0 over [-half, half]^2, in its own box, without friction and balls.
pub fn plane(half: f64) -> Scene {
    graph(half, &[], MotionLaw::Frictionless)
}

/// A floor in a box, elastic.
pub fn scene(floor: Floor, x: [f64; 2], y: [f64; 2], motion: MotionLaw) -> Scene {
    Scene {
        floor,
        walls: walls(x, y),
        balls: vec![],
        gravity: Vector3::new(0.0, 0.0, -9.81),
        motion,
        restitution: 1.0,
        accuracy: Accuracy::Tolerance(1e-12),
        hit_budget: HIT_BUDGET,
    }
}

/// Four walls along x and y.
pub fn walls(x: [f64; 2], y: [f64; 2]) -> Vec<Wall> {
    let wall = |px, py, nx, ny| Wall { point: Vector2::new(px, py), normal: Vector2::new(nx, ny) };
    vec![
        wall(x[0], 0.0, 1.0, 0.0),
        wall(x[1], 0.0, -1.0, 0.0),
        wall(0.0, y[0], 0.0, 1.0),
        wall(0.0, y[1], 0.0, -1.0),
    ]
}

/// The floor of the program this one grew out of: a pit of control height -70 m and, if wanted, a hill of 40 m.
pub fn pit_floor(hill: bool) -> Floor {
    let mut heights = vec![vec![0.0; 11]; 11];
    heights[5][3] = -70.0;
    heights[5][7] = if hill { 40.0 } else { 0.0 };
    let border = [-10.0, 10.0];
    Floor::Bezier(BezierPatch::from_heights(border, border, &heights).unwrap())
}

/// Its whole scene: three solid balls that roll, restitution 1.
pub fn original() -> Scene {
    let border = [-10.0, 10.0];
    let mut scene = scene(pit_floor(true), border, border, MotionLaw::Rolling);
    scene.gravity = Vector3::new(0.0, 0.0, -9.8);
    let center = |x, y| Place::Center(Vector2::new(x, y));
    let heavy = |name, place, vx, vy| BallSpec { mass: 5.0, ..moving(name, 1.0, place, vx, vy) };
    scene.balls = vec![
        heavy("south-west", center(-9.0, -9.0), 5.0, 5.0),
        heavy("north-east", center(9.0, 9.0), -5.0, -5.0),
        heavy("player", center(0.0, 5.0), 0.0, 5.0),
    ];
    scene
}

/// A solid ball of 1 kg at rest.
pub fn still(name: &str, radius: f64, place: Place) -> BallSpec {
    BallSpec {
        name: name.into(),
        radius,
        mass: 1.0,
        inertia_factor: SOLID,
        place,
        velocity: Vector3::zeros(),
        spin: 0.0,
    }
}

/// A solid ball of 1 kg with a horizontal velocity.
pub fn moving(name: &str, radius: f64, place: Place, vx: f64, vy: f64) -> BallSpec {
    BallSpec { velocity: Vector3::new(vx, vy, 0.0), ..still(name, radius, place) }
}

/// The centre over (x, y).
pub fn center(x: f64, y: f64) -> Place {
    Place::Center(Vector2::new(x, y))
}

/// Touching the floor over (x, y).
pub fn contact(x: f64, y: f64) -> Place {
    Place::Contact(Vector2::new(x, y))
}

/// The engine with a scene that it must take.
pub fn load(scene: &Scene) -> Controller {
    Controller::new(scene).unwrap_or_else(|fault| panic!("the scene is refused: {fault}"))
}

/// Advances tick by tick up to and including `ticks`, showing every tick's state, the start included.
pub fn run(scene: &Scene, rate_hz: u32, ticks: u64, mut look: impl FnMut(u64, &Controller)) -> Controller {
    let mut engine = load(scene);
    look(0, &engine);
    for tick in 1..=ticks {
        engine.advance_to(Time::of_tick(tick, rate_hz));
        look(tick, &engine);
    }
    engine
}

/// The balls in the order of the scene's list.
pub fn in_list_order(engine: &Controller) -> Vec<BallState> {
    let mut balls = vec![BallState::default(); engine.balls().len()];
    for (state, place) in engine.balls().iter().zip(engine.scene_index()) {
        balls[*place] = *state;
    }
    balls
}

/// Every bit of a ball's state.
pub fn bits(ball: &BallState) -> Vec<u64> {
    let numbers = [ball.center, ball.normal, ball.velocity, ball.omega];
    let numbers = numbers.iter().flat_map(|v| v.iter()).chain(ball.uv.iter()).chain(&ball.orientation);
    numbers.map(|x| x.to_bits()).collect()
}

/// Every bit of all balls by id.
pub fn all_bits(engine: &Controller) -> Vec<u64> {
    engine.balls().iter().flat_map(bits).collect()
}

/// The scene with its floor written as a net.
pub fn as_net(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    if let Floor::Polynomial { x, y, terms } = &scene.floor {
        scene.floor = Floor::Bezier(BezierPatch::from_polynomial(*x, *y, terms).unwrap());
    }
    scene
}

/// The scene in a mirror across x = 0: coordinates negated, parameters kept, spin turned about.
pub fn mirrored(scene: &Scene) -> Scene {
    let mut scene = as_net(scene);
    if let Floor::Bezier(patch) = &scene.floor {
        let net = patch.net().iter().map(mirrored_vector).collect();
        scene.floor = Floor::Bezier(BezierPatch::new(patch.degree(), net).unwrap());
    }
    for wall in &mut scene.walls {
        wall.point.x = -wall.point.x;
        wall.normal.x = -wall.normal.x;
    }
    for ball in &mut scene.balls {
        if let Place::Center(p) | Place::Contact(p) = &mut ball.place {
            p.x = -p.x;
        }
        ball.velocity.x = -ball.velocity.x;
        ball.spin = -ball.spin;
    }
    scene
}

fn mirrored_vector(v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(-v.x, v.y, v.z)
}

/// A ball seen in the same mirror.
pub fn mirrored_state(ball: &BallState) -> BallState {
    let [x, y, z, w] = ball.orientation;
    BallState {
        uv: ball.uv,
        center: mirrored_vector(&ball.center),
        normal: mirrored_vector(&ball.normal),
        velocity: mirrored_vector(&ball.velocity),
        omega: -mirrored_vector(&ball.omega),
        orientation: [x, -y, -z, w],
    }
}

/// Asserts that a scene and its mirror image run as mirror images, without a bit of difference (0 and -0 are one number).
pub fn assert_mirrors(scene: &Scene, rate_hz: u32, ticks: u64) {
    let scene = as_net(scene);
    let mut image = load(&mirrored(&scene));
    run(&scene, rate_hz, ticks, |tick, engine| {
        image.advance_to(Time::of_tick(tick, rate_hz));
        for (id, (ball, seen)) in engine.balls().iter().zip(image.balls()).enumerate() {
            assert_eq!(mirrored_state(ball), *seen, "ball {id} at tick {tick}");
        }
    });
}

/// The same stream of numbers in [0, 1) for the same seed: splitmix64.
pub fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// `count` balls of mixed radii around the middle, none overlapping, with random velocities up to `speed`.
pub fn cloud(count: usize, radii: [f64; 2], within: f64, speed: f64, seed: u64) -> Vec<BallSpec> {
    let mut next = random(seed);
    let mut balls: Vec<(Vector2<f64>, BallSpec)> = vec![];
    for _ in 0..1000 * count {
        if balls.len() == count {
            break;
        }
        let radius = radii[0] + (radii[1] - radii[0]) * next();
        let place = Vector2::new(2.0 * next() - 1.0, 2.0 * next() - 1.0) * within;
        let velocity = Vector2::new(2.0 * next() - 1.0, 2.0 * next() - 1.0) * speed;
        // Half again the reach leaves room for the slope between the centres.
        if balls.iter().all(|(p, b)| (place - p).norm() > 1.5 * (radius + b.radius)) {
            let name = format!("ball-{:03}", balls.len());
            let mut ball = moving(&name, radius, Place::Contact(place), velocity.x, velocity.y);
            ball.mass = radius.powi(3) * 4000.0;
            balls.push((place, ball));
        }
    }
    assert_eq!(balls.len(), count, "the cloud does not fit");
    balls.into_iter().map(|(_, ball)| ball).collect()
}

/// Positions on a line of equal rods that hit each other and two ends elastically: their centres at any time, exactly.
/// Without their lengths they are points; points of equal mass pass through each other as far as places are concerned; an
/// end unfolds into a mirror.
pub fn rods(starts: &[(f64, f64)], radius: f64, ends: [f64; 2], t: f64) -> Vec<f64> {
    let shorter = |rank: usize| (2 * rank + 1) as f64 * radius;
    let length = ends[1] - ends[0] - 2.0 * radius * starts.len() as f64;
    let mut places: Vec<f64> = starts
        .iter()
        .enumerate()
        .map(|(rank, (x, v))| {
            let unfolded = (x - ends[0] - shorter(rank) + v * t).rem_euclid(2.0 * length);
            if unfolded > length { 2.0 * length - unfolded } else { unfolded }
        })
        .collect();
    places.sort_by(f64::total_cmp);
    places.iter().enumerate().map(|(rank, x)| x + ends[0] + shorter(rank)).collect()
}
