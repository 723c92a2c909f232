//! A random scene and what players do in it.

use crate::random::Random;
use crate::script::{Act, Deed};
use protocol::scene::{
    Accuracy, Ball, Floor, Inertia, InertiaName, Integrator, Motion, SCENE_VERSION, Scene, Steering, Term,
    WallBox, WallPlane, Walls,
};

/// Length of a run, in beats of 1/30 s.
pub const BEATS: u64 = 60;
/// Hits a ball may have within 1/64 s. Piles under low restitution reach it; honest scenes stay far below.
const HIT_BUDGET: u32 = 1_000;
/// Part of the floor that balls may cover.
const COVERED: f64 = 0.2;

/// Part of the nets of points whose degree goes up to 12, not 6.
const HIGH_DEGREES: f64 = 0.1;
/// Part of the scenes without a lattice whose radii go down to a thousandth of the largest, not to a third.
const DUSTY: f64 = 0.15;

/// A scene and its script.
pub struct Case {
    pub scene: Scene,
    pub script: Vec<Act>,
}

/// The case of a seed.
pub fn case(seed: u64) -> Case {
    let random = &mut Random::new(seed);
    // Ties to the last bit need places and speeds that arithmetic does not round.
    let dyadic = random.chance(0.2);
    let half = if dyadic { 4.0 } else { random.between(1.0, 3.0).exp2() };
    let middle = if dyadic { [0.0; 2] } else { random.pair(half) };
    let x_m = [middle[0] - half, middle[0] + half];
    let y_m = [middle[1] - half, middle[1] + half];
    let floor = floor(random, x_m, y_m, dyadic);
    let balls = if dyadic { lattice(random) } else { scattered(random, middle, half) };
    let scene = Scene {
        version: SCENE_VERSION,
        name: "random".into(),
        description: String::new(),
        gravity_m_per_s2: gravity(random, dyadic),
        motion: if random.chance(0.5) { Motion::Rolling } else { Motion::Frictionless },
        restitution: restitution(random),
        hit_budget: HIT_BUDGET,
        accuracy: accuracy(random),
        walls: walls(random, middle, half, [x_m, y_m]),
        floor,
        steering: Steering {
            impulse_m_per_s: random.between(0.5, 3.0),
            acceleration_m_per_s2: random.between(0.5, 8.0),
            speed_limit_m_per_s: random.between(1.0, 8.0),
        },
        balls,
        clouds: vec![],
    };
    let script = script(random, &scene);
    Case { scene, script }
}

fn gravity(random: &mut Random, dyadic: bool) -> [f64; 3] {
    let z = if random.chance(0.1) { -random.between(0.1, 2.0) } else { -9.81 };
    if dyadic || random.chance(0.6) {
        return [0.0, 0.0, z];
    }
    let [x, y] = random.pair(0.2 * z);
    [x, y, z]
}

fn restitution(random: &mut Random) -> f64 {
    match random.below(10) {
        0..6 => 1.0,
        6..9 => random.between(0.5, 1.0),
        _ => random.between(0.0, 0.5),
    }
}

fn accuracy(random: &mut Random) -> Accuracy {
    match random.below(8) {
        0 => Accuracy::Fixed { integrator: Integrator::Rk4, step_s: 1.0 / 240.0 },
        1 => Accuracy::Fixed { integrator: Integrator::Tsit5, step_s: 1.0 / 120.0 },
        2 => Accuracy::Fixed { integrator: Integrator::Dop853, step_s: 1.0 / 50.0 },
        _ => Accuracy::Tolerance { tolerance_m: [1e-8, 1e-9, 1e-10, 1e-11][random.below(4)] },
    }
}

fn floor(random: &mut Random, x_m: [f64; 2], y_m: [f64; 2], dyadic: bool) -> Floor {
    let half = (x_m[1] - x_m[0]) / 2.0;
    // Slopes up to about 1: steep, and still flat enough for the balls in most scenes.
    let rise = half * random.unit() * random.unit() * 0.5;
    let kind = if dyadic && random.chance(0.7) { 0 } else { random.below(6) };
    let curve = |random: &mut Random| rise / (half * half) * random.between(0.3, 1.0);
    match kind {
        0 => Floor::Polynomial { x_m, y_m, terms: vec![] },
        1 => {
            let sign = if random.chance(0.3) { -1.0 } else { 1.0 };
            let terms = vec![
                Term { px: 2, py: 0, c: curve(random) },
                Term { px: 0, py: 2, c: sign * curve(random) },
                Term { px: 1, py: 0, c: random.between(-0.1, 0.1) },
            ];
            Floor::Polynomial { x_m, y_m, terms }
        }
        2 => {
            let terms = (0..6).map(|_| {
                let (px, py) = (random.below(5) as u32, random.below(5) as u32);
                let scale: f64 = (0..px + py).map(|_| half).product();
                Term { px, py, c: rise * random.between(-0.3, 0.3) / scale }
            });
            Floor::Polynomial { x_m, y_m, terms: terms.collect() }
        }
        _ => net(random, [x_m, y_m], rise, kind),
    }
}

/// Heights over a grid, or points in full whose inner ones are shifted sideways; borders stay straight for the walls.
fn net(random: &mut Random, [x_m, y_m]: [[f64; 2]; 2], rise: f64, kind: usize) -> Floor {
    // High degrees take long to certify.
    let most = if random.chance(HIGH_DEGREES) { 12 } else { 6 };
    let degree = [1 + random.below(most), 1 + random.below(most)];
    let row = |random: &mut Random| (0..=degree[0]).map(|_| rise * random.between(-1.0, 1.0)).collect();
    let heights: Vec<Vec<f64>> = (0..=degree[1]).map(|_| row(random)).collect();
    if kind < 5 {
        return Floor::Grid { x_m, y_m, control_heights_m: heights };
    }
    let spaced = |[from, to]: [f64; 2], i: usize, n: usize, shift: f64| {
        let inner = i > 0 && i < n;
        from + (to - from) * (i as f64 + if inner { shift } else { 0.0 }) / n as f64
    };
    let point = |random: &mut Random, i: usize, j: usize| {
        let [a, b] = random.pair(0.2);
        [spaced(x_m, i, degree[0], a), spaced(y_m, j, degree[1], b), heights[j][i]]
    };
    let control_points_m =
        (0..=degree[1]).map(|j| (0..=degree[0]).map(|i| point(random, i, j)).collect()).collect();
    Floor::Net { control_points_m }
}

/// The borders' own box; sometimes said in full, with up to four slanting walls that cut corners off.
fn walls(random: &mut Random, middle: [f64; 2], half: f64, [x_m, y_m]: [[f64; 2]; 2]) -> Walls {
    if random.chance(0.5) {
        return Walls::default();
    }
    let plane = |random: &mut Random| {
        let [x, y] = random.pair(1.0);
        let length = x.hypot(y).max(0.1);
        let far = half * random.between(0.95, 1.3);
        WallPlane {
            point_m: [middle[0] - far * x / length, middle[1] - far * y / length],
            normal: [x / length, y / length],
        }
    };
    let planes = (0..random.below(5)).map(|_| plane(random)).collect();
    Walls { bounds: Some(WallBox { x_m, y_m }), planes, drawn_height_m: None }
}

/// Balls anywhere, of mixed sizes, masses and makes.
fn scattered(random: &mut Random, middle: [f64; 2], half: f64) -> Vec<Ball> {
    let count = 1 + (40.0 * random.unit() * random.unit()) as usize;
    let largest = (COVERED * half * half / count as f64).sqrt().min(0.2 * half);
    let (spread, speed) = (random.chance(0.3), random.between(0.0, 4.0));
    let smallest: f64 = if random.chance(DUSTY) { 1e-3 } else { 0.3 };
    let mut balls: Vec<Ball> = vec![];
    let mut places: Vec<([f64; 2], f64)> = vec![];
    for _ in 0..50 * count {
        if balls.len() == count {
            break;
        }
        // As many of each decade.
        let radius = largest * smallest.powf(random.unit());
        let place = random.pair(half - 1.6 * radius);
        let room = |(p, r): &([f64; 2], f64)| {
            // A third more than the reach leaves room for the slope between contact and centre.
            (p[0] - place[0]).hypot(p[1] - place[1]) > 1.3 * (r + radius)
        };
        if !places.iter().all(room) {
            continue;
        }
        places.push((place, radius));
        let mass = if spread { 10_f64.powf(random.between(-2.0, 2.0)) } else { 4000.0 * radius.powi(3) };
        let mut ball = ball(random, balls.len(), radius, mass);
        let at = [middle[0] + place[0], middle[1] + place[1]];
        match random.below(3) {
            0 => ball.center_m = Some(at),
            1 => ball.contact_m = Some(at),
            _ => ball.uv = Some(place.map(|x| 0.5 + 0.5 * x / half)),
        }
        let [x, y] = random.pair(speed);
        ball.velocity_m_per_s = [x, y, 0.0];
        ball.spin_rad_per_s = if random.chance(0.5) { random.between(-20.0, 20.0) } else { 0.0 };
        balls.push(ball);
    }
    balls
}

/// Equal balls on a lattice, some of them touching, with speeds that are whole: many hits at one instant.
fn lattice(random: &mut Random) -> Vec<Ball> {
    let radius = 0.25;
    let step = if random.chance(0.5) { 0.5 } else { 0.75 };
    let mut places: Vec<[f64; 2]> = vec![];
    for i in -4..=4 {
        for j in -4..=4 {
            if random.chance(0.2) {
                places.push([f64::from(i) * step, f64::from(j) * step]);
            }
        }
    }
    let still = random.chance(0.3);
    let set = |(n, place): (usize, [f64; 2])| {
        let mut ball = Ball { inertia: Inertia::default(), ..ball(random, n, radius, 1.0) };
        ball.center_m = Some(place);
        if !still || n == 0 {
            ball.velocity_m_per_s = [random.below(3) as f64 - 1.0, random.below(3) as f64 - 1.0, 0.0];
        }
        ball
    };
    places.into_iter().enumerate().map(set).collect()
}

fn ball(random: &mut Random, number: usize, radius_m: f64, mass_kg: f64) -> Ball {
    let inertia = match random.below(4) {
        0 => Inertia::Named(InertiaName::Hollow),
        1 => Inertia::Factor(random.between(0.0, 2.0 / 3.0)),
        _ => Inertia::Named(InertiaName::Solid),
    };
    Ball {
        // Ranks of names are not places in the list.
        name: format!("{:02}-{number}", random.below(100)),
        radius_m,
        mass_kg,
        inertia,
        center_m: None,
        contact_m: None,
        uv: None,
        velocity_m_per_s: [0.0; 3],
        spin_rad_per_s: 0.0,
        color: None,
        // Commands of players reach every ball.
        player: true,
        tags: vec![],
    }
}

/// A ball that is small and slow, somewhere: most of the time it meets nobody.
pub fn bystander(seed: u64, scene: &Scene) -> Ball {
    let random = &mut Random::new(!seed);
    let smallest = scene.balls.iter().map(|ball| ball.radius_m).fold(0.1, f64::min);
    let mut ball = ball(random, scene.balls.len(), 0.1 * smallest, 1.0);
    ball.uv = Some([random.between(0.02, 0.98), random.between(0.02, 0.98)]);
    ball
}

/// Up to six deeds from outside at random beats.
fn script(random: &mut Random, scene: &Scene) -> Vec<Act> {
    if scene.balls.is_empty() || random.chance(0.3) {
        return vec![];
    }
    let Steering { impulse_m_per_s, acceleration_m_per_s2, speed_limit_m_per_s: limit } = scene.steering;
    let act = |random: &mut Random| {
        let ball = random.below(scene.balls.len());
        let radius = scene.balls[ball].radius_m;
        let deed = match random.below(4) {
            0 => Deed::Push { direction: random.pair(0.7), impulse: impulse_m_per_s, limit },
            1 => Deed::Drive { direction: random.pair(0.7), acceleration: acceleration_m_per_s2, limit },
            2 => Deed::Set {
                by: random.pair(3.0 * radius),
                velocity: random.pair(2.0),
                spin: random.between(-5.0, 5.0),
            },
            _ => Deed::Release,
        };
        Act { beat: random.below(BEATS as usize) as u64, ball, deed }
    };
    let mut script: Vec<Act> = (0..=random.below(6)).map(|_| act(random)).collect();
    script.sort_by_key(|act| act.beat);
    script
}
