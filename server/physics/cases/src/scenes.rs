//! Scenes in few words, and ways to read a run.

use ballroom_physics::surface::bezier::BezierPatch;
use ballroom_physics::{
    Accuracy, BallSpec, BallState, Controller, Floor, HIT_BUDGET, MotionLaw, Place, Scene, Wall,
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

/// The balls in the order of the scene's list.
pub fn in_list_order(engine: &Controller) -> Vec<BallState> {
    let mut balls = vec![BallState::default(); engine.balls().len()];
    for (state, place) in engine.balls().zip(engine.scene_index()) {
        balls[*place] = state;
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
    engine.balls().flat_map(|ball| bits(&ball)).collect()
}

/// The scene with its floor written as a net.
pub fn as_net(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    if let Floor::Polynomial { x, y, terms } = &scene.floor {
        scene.floor = Floor::Bezier(BezierPatch::from_polynomial(*x, *y, terms).unwrap());
    }
    scene
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
