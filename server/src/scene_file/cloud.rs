//! Clouds: many balls placed at random without overlap, repeatably from a seed.
//!
//! Two balls do not overlap on any floor when their centres are, seen from above, at least the sum of their radii
//! apart; placing by centre with this test needs no floor at all. Only additions, multiplications and square roots are
//! used, which round alike everywhere, so that a seed means one cloud on every machine.

use super::{Card, Placed, SceneError, SceneText};
use ballroom_physics::{BallSpec, Place, Wall};
use nalgebra::{Vector2, Vector3};
use protocol::scene::{Cloud, Floor, Scene};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Work a ball on average before a cloud is called too dense: one for each wall and each other ball looked at. Small
/// balls in cells of large ones have many neighbours, so counting tries alone would not bound it.
const LOOKS_PER_BALL: u64 = 10_000;
/// Most work for one cloud, about a second's.
const MAX_LOOKS: u64 = 100_000_000;
/// What a try costs beside.
const LOOKS_PER_TRY: u64 = 5;
/// Relative room kept between balls and to walls, far above rounding and far below sight.
const ROOM: f64 = 1e-9;

/// Places every cloud of the scene after, and clear of, the balls written out.
pub fn place_all(
    text: &SceneText,
    scene: &Scene,
    walls: &[(Wall, String)],
    balls: &mut Vec<Placed>,
) -> Result<(), SceneError> {
    if scene.clouds.is_empty() {
        return Ok(());
    }
    let largest = scene.clouds.iter().map(|cloud| cloud.radius_m[1]);
    let largest = largest.chain(scene.balls.iter().map(|ball| 2.0 * ball.radius_m)).fold(0.0, f64::max);
    let mut crowd = Crowd::new(2.0 * largest);
    for ball in balls.iter() {
        if let Some((xy, radius)) = footprint(&ball.spec, &scene.floor) {
            crowd.add(xy, radius);
        }
    }
    let mut names: std::collections::BTreeSet<String> = balls.iter().map(|b| b.spec.name.clone()).collect();
    for (i, cloud) in scene.clouds.iter().enumerate() {
        for ball in place(text, i, cloud, walls, &mut crowd)? {
            if !names.insert(ball.spec.name.clone()) {
                let message =
                    format!("makes a second ball {:?}: give the cloud another name", ball.spec.name);
                return Err(text.error(format_args!("cloud[{i}].name"), message));
            }
            balls.push(ball);
        }
    }
    Ok(())
}

/// A disc that certainly holds the ball's centre disc seen from above. A centre lies at most a radius beside its
/// contact point. Where u, v are not affine in x, y the engine's own check for overlap has to do.
fn footprint(ball: &BallSpec, floor: &Floor) -> Option<(Vector2<f64>, f64)> {
    let from_uv = |uv: Vector2<f64>| match floor {
        Floor::Grid { x_m, y_m, .. } | Floor::Polynomial { x_m, y_m, .. } => {
            Some(Vector2::new(x_m[0] + (x_m[1] - x_m[0]) * uv.x, y_m[0] + (y_m[1] - y_m[0]) * uv.y))
        }
        Floor::Net { .. } => None,
    };
    match ball.place {
        Place::Center(xy) => Some((xy, ball.radius)),
        Place::Contact(xy) => Some((xy, 2.0 * ball.radius)),
        Place::Uv(uv) => from_uv(uv).map(|xy| (xy, 2.0 * ball.radius)),
    }
}

fn place(
    text: &SceneText,
    index: usize,
    cloud: &Cloud,
    walls: &[(Wall, String)],
    crowd: &mut Crowd,
) -> Result<Vec<Placed>, SceneError> {
    let mut random = Random::new(cloud.seed);
    let [smallest, largest] = cloud.radius_m;
    let mut radii: Vec<f64> =
        (0..cloud.count).map(|_| smallest + (largest - smallest) * random.unit()).collect();
    // The largest first: the small ones find room between them.
    radii.sort_by(|a, b| b.total_cmp(a));
    let around = Vector2::from(cloud.around_m);
    // A uniform disc of radius R has the mean square R^2 / 2.
    let speed = cloud.speed_rms_m_per_s * std::f64::consts::SQRT_2;
    // Names of one length sort as their numbers do.
    let digits = cloud.count.to_string().len().max(4);
    let mut looks = (LOOKS_PER_BALL * u64::from(cloud.count)).min(MAX_LOOKS);
    let mut out = Vec::with_capacity(radii.len());
    for radius in radii {
        let center = loop {
            if looks == 0 {
                let message = format!(
                    "only {} of {} balls found room: make within_m larger, or radius_m or count smaller",
                    out.len(),
                    cloud.count
                );
                return Err(text.error(format_args!("cloud[{index}].within_m"), message));
            }
            looks = looks.saturating_sub(LOOKS_PER_TRY + walls.len() as u64);
            let center = around + random.in_disc() * cloud.within_m;
            let inside =
                |(wall, _): &(Wall, String)| wall.normal.dot(&(center - wall.point)) >= radius * (1.0 + ROOM);
            if walls.iter().all(inside) && crowd.has_room(center, radius, &mut looks) {
                break center;
            }
        };
        crowd.add(center, radius);
        let velocity = random.in_disc() * speed;
        out.push(Placed {
            spec: BallSpec {
                name: format!("{}-{:0digits$}", cloud.name, out.len() + 1),
                radius,
                mass: cloud.density_kg_per_m3 * (4.0 / 3.0 * PI) * (radius * radius * radius),
                inertia_factor: cloud.inertia.factor(),
                place: Place::Center(center),
                velocity: Vector3::new(velocity.x, velocity.y, 0.0),
                spin: 0.0,
            },
            card: Card {
                field: format!("cloud[{index}]"),
                color_rgb: None,
                player: false,
                tags: super::distinct(&cloud.tags),
                is_spawned: false,
            },
        });
    }
    Ok(out)
}

/// Discs in square cells no smaller than any two radii together, so that nine cells hold every neighbour.
struct Crowd {
    cell: f64,
    cells: BTreeMap<[i64; 2], Vec<(Vector2<f64>, f64)>>,
}

impl Crowd {
    const fn new(cell: f64) -> Self {
        Self { cell, cells: BTreeMap::new() }
    }

    fn key(&self, xy: Vector2<f64>) -> [i64; 2] {
        [(xy.x / self.cell).floor() as i64, (xy.y / self.cell).floor() as i64]
    }

    fn add(&mut self, xy: Vector2<f64>, radius: f64) {
        self.cells.entry(self.key(xy)).or_default().push((xy, radius));
    }

    /// Whether a disc fits; each neighbour looked at is taken off `looks`.
    fn has_room(&self, xy: Vector2<f64>, radius: f64, looks: &mut u64) -> bool {
        let [i, j] = self.key(xy);
        let near = (i - 1..=i + 1).flat_map(|i| self.cells.range([i, j - 1]..=[i, j + 1]));
        near.flat_map(|(_, discs)| discs).all(|(other, r)| {
            *looks = looks.saturating_sub(1);
            let reach = (radius + r) * (1.0 + ROOM);
            (xy - other).norm_squared() >= reach * reach
        })
    }
}

/// The generator splitmix64 (Steele, Lea, Flood 2014): one word of state, good enough for placing things.
struct Random(u64);

impl Random {
    const fn new(seed: u64) -> Self {
        Self(seed)
    }

    const fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1), all 53 bits.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Uniform in the unit disc, by rejection: no sine is the same everywhere. A try fails with probability 0.21, so
    /// the bound is never met in practice; its answer is still in the disc.
    fn in_disc(&mut self) -> Vector2<f64> {
        for _ in 0..200 {
            let xy = Vector2::new(2.0 * self.unit() - 1.0, 2.0 * self.unit() - 1.0);
            if xy.norm_squared() <= 1.0 {
                return xy;
            }
        }
        Vector2::zeros()
    }
}
