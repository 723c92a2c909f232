//! A gas of any number of balls: equal, a fifth of the floor covered, each hit several times a second; and a crowd whose
//! radii are as 1000 to 1.

use crate::scenes::{SOLID, graph};
use ballroom_physics::{Accuracy, BallSpec, MotionLaw, Place, Scene};
use nalgebra::{Vector2, Vector3};

/// Radius of every ball, m.
pub const RADIUS: f64 = 0.05;
/// Half the side of the floor of a thousand balls, m: they cover a fifth of it.
const HALF: f64 = 3.1333;
/// Height of the bowl's rim over its middle, m, whatever the number of balls.
const RIM: f64 = 0.06;

/// Balls below which a tolerance of 1e-8 m is felt in the energy: hits are too few to cut arcs short, and the same rim over
/// a smaller floor curves it more. Ten then lose 1.4e-10 of it in 20 s, a hundred 5e-11, a thousand 3e-14.
const FEW: usize = 100;

/// On a shallow bowl, as high at the middle of a wall as a sliding ball of 1 m/s climbs; rolling, to 1e-8 m, fewer than a hundred to
/// 1e-9 m. It is the scene `gas` of the server, with other places.
pub fn on_a_bowl(count: usize) -> Scene {
    let half = half(count);
    let c = RIM / (half * half);
    let mut scene = graph(half, &[(2, 0, c), (0, 2, c)], MotionLaw::Rolling);
    scene.accuracy = Accuracy::Tolerance(if count < FEW { 1e-9 } else { 1e-8 });
    scene.balls = crowd(count, half);
    scene
}

/// Area of the floor below so many balls, m^2.
pub fn area(count: usize) -> f64 {
    4.0 * half(count) * half(count)
}

/// On a plane, without friction.
pub fn on_a_plane(count: usize) -> Scene {
    let half = half(count);
    let mut scene = graph(half, &[], MotionLaw::Frictionless);
    scene.balls = crowd(count, half);
    scene
}

/// Half the side of the dusty floor, m.
const DUSTY_HALF: f64 = 8.0;
/// Balls of each size beside the dust: how many, and radii between which theirs lie evenly, m.
const BESIDE_DUST: [(usize, [f64; 2]); 2] = [(9, [0.8, 1.0]), (300, [0.03, 0.06])];
/// Radii of dust, m.
const DUST: [f64; 2] = [0.001, 0.002];

/// Nine balls of up to 1 m, three hundred of a few centimetres and `dust` grains of 1 to 2 mm, all at 1 m/s and of one
/// density, rolling to 1e-8 m in a bowl of 16 m that rises to 1 m at the middle of a wall.
pub fn dusty(dust: usize) -> Scene {
    let c = 1.0 / (DUSTY_HALF * DUSTY_HALF);
    let mut scene = graph(DUSTY_HALF, &[(2, 0, c), (0, 2, c)], MotionLaw::Rolling);
    scene.accuracy = Accuracy::Tolerance(1e-8);
    let mut next = crate::scenes::random(1000);
    let mut taken: Vec<(Vector2<f64>, f64)> = vec![];
    for (count, [small, large]) in BESIDE_DUST.into_iter().chain([(dust, DUST)]) {
        let end = taken.len() + count;
        while taken.len() < end {
            let radius = small + (large - small) * next();
            let at = Vector2::new(2.0 * next() - 1.0, 2.0 * next() - 1.0) * (DUSTY_HALF - 1.3 * radius);
            // A tenth more than the reach leaves room for the slope between the centres.
            if !taken.iter().all(|(other, r)| (at - other).norm() > 1.1 * (r + radius)) {
                continue;
            }
            let way = loop {
                let v = Vector2::new(2.0 * next() - 1.0, 2.0 * next() - 1.0);
                if (0.01..=1.0).contains(&v.norm_squared()) {
                    break v.normalize();
                }
            };
            scene.balls.push(BallSpec {
                name: format!("dusty-{:05}", taken.len()),
                radius,
                mass: 1000.0 * radius.powi(3),
                inertia_factor: SOLID,
                place: Place::Center(at),
                velocity: Vector3::new(way.x, way.y, 0.0),
                spin: 0.0,
            });
            taken.push((at, radius));
        }
    }
    scene
}

fn half(count: usize) -> f64 {
    HALF * (count as f64 / 1000.0).sqrt()
}

/// Balls at random places of the square, with velocities uniform in a disc and 1 m/s in the mean square.
fn crowd(count: usize, half: f64) -> Vec<BallSpec> {
    let mut next = crate::scenes::random(1738);
    let room = half - RADIUS * 1.001;
    // Cells hold at most one centre, so that 5 x 5 of them hold every neighbour.
    let cell = RADIUS * 1.4;
    let across = (2.0 * half / cell) as usize + 1;
    let mut taken: Vec<Option<Vector2<f64>>> = vec![None; across * across];
    let digits = count.to_string().len();
    let mut balls = Vec::with_capacity(count);
    while balls.len() < count {
        let at = Vector2::new(2.0 * next() - 1.0, 2.0 * next() - 1.0) * room;
        let [i, j] = [at.x, at.y].map(|x| ((x + half) / cell) as usize);
        let near = |k: usize| k.saturating_sub(2)..(k + 3).min(across);
        let mut others = near(i).flat_map(|i| near(j).map(move |j| (i, j)));
        // A little more than touching, for the slope between the centres.
        let clear = |other: &Vector2<f64>| (at - other).norm() > 2.001 * RADIUS;
        if !others.all(|(i, j)| taken[i * across + j].as_ref().is_none_or(clear)) {
            continue;
        }
        taken[i * across + j] = Some(at);
        let velocity = loop {
            let v = Vector2::new(2.0 * next() - 1.0, 2.0 * next() - 1.0);
            if v.norm_squared() <= 1.0 {
                break v * std::f64::consts::SQRT_2;
            }
        };
        balls.push(BallSpec {
            name: format!("gas-{:0digits$}", balls.len()),
            radius: RADIUS,
            mass: 0.5,
            inertia_factor: SOLID,
            place: Place::Center(at),
            velocity: Vector3::new(velocity.x, velocity.y, 0.0),
            spin: 0.0,
        });
    }
    balls
}
