//! A made-up ride over the original floor, for this crate's tests.

use crate::recording::Recording;
use crate::surface::Surface;
use nalgebra::{UnitQuaternion, Vector3};
use protocol::scene::{Accuracy, Floor, Motion, Scene, Steering, Walls};
use protocol::snapshot::{Collisions, Roster, Snapshot, World};
use rerun::RecordingStreamBuilder;
use rerun::log::{Chunk, LogMsg};
use rerun::sink::MemorySinkStorage;

/// A recording in memory.
pub fn recording() -> (Recording, MemorySinkStorage) {
    let (stream, storage) = RecordingStreamBuilder::new("ballroom_test").memory().expect("a memory stream");
    (Recording::new(stream), storage)
}

/// The rows of an entity's recording among messages, one chunk each.
pub fn chunks(messages: impl Iterator<Item = LogMsg>, path: &str) -> impl Iterator<Item = Chunk> {
    let path = format!("/{path}");
    messages.filter_map(move |message| match message {
        LogMsg::ArrowMsg(store, arrow) if store.is_recording() => {
            let chunk = Chunk::from_arrow_msg(&arrow).expect("a chunk");
            (chunk.entity_path().to_string() == path).then_some(chunk)
        }
        _ => None,
    })
}

/// The original floor with its three balls at tick 0.
pub fn original() -> World {
    let mut rows = vec![vec![0.0; 11]; 11];
    rows[5][3] = -70.0;
    rows[5][7] = 40.0;
    let scene = Scene {
        version: 1,
        name: "original".into(),
        description: String::new(),
        gravity_m_per_s2: [0.0, 0.0, -9.8],
        motion: Motion::Rolling,
        restitution: 1.0,
        accuracy: Accuracy::default(),
        hit_budget: 1 << 22,
        floor: Floor::Grid { x_m: [-10.0, 10.0], y_m: [-10.0, 10.0], control_heights_m: rows },
        walls: Walls { drawn_height_m: Some(2.0), ..Walls::default() },
        steering: Steering::default(),
        balls: vec![],
        clouds: vec![],
    };
    let roster = Roster {
        names: ["a", "b", "player"].map(String::from).to_vec(),
        radius_m: vec![1.0; 3],
        mass_kg: vec![5.0; 3],
        inertia_factor: vec![0.4; 3],
        color_rgb: vec![[46, 134, 222], [38, 166, 91], [214, 48, 49]],
        player: vec![false, false, true],
        ..Roster::default()
    };
    let mut world = World { scene, roster, tick_rate_hz: 60, snapshot: Snapshot::default() };
    world.snapshot = Ride::new(&world).state(0);
    world
}

/// Three balls rolling without slip along closed curves.
pub struct Ride {
    surface: Surface,
    orientations: Vec<UnitQuaternion<f64>>,
    last: Vec<Vector3<f64>>,
}

impl Ride {
    /// At tick 0 of a world of three balls of radius 1.
    pub fn new(world: &World) -> Self {
        let surface = Surface::of(&world.scene.floor).expect("a floor");
        Self { surface, orientations: vec![UnitQuaternion::identity(); 3], last: vec![] }
    }

    /// The next state; ticks must be taken in order.
    pub fn state(&mut self, tick: u64) -> Snapshot {
        let time_s = tick as f64 / 60.0;
        let place = |ball: usize| {
            let phase = 2.1 * ball as f64 + 0.7 * time_s;
            [0.5 + 0.36 * (phase + ball as f64).sin(), 0.5 + 0.33 * (1.3 * phase).cos()]
        };
        let uv: Vec<[f64; 2]> = (0..3).map(place).collect();
        let frames: Vec<_> = uv.iter().map(|[u, v]| self.surface.frame(*u, *v)).collect();
        let centers: Vec<Vector3<f64>> = frames.iter().map(|(point, normal)| point + normal).collect();
        for (ball, last) in self.last.iter().enumerate() {
            let turn = frames[ball].1.cross(&(centers[ball] - last));
            self.orientations[ball] = UnitQuaternion::from_scaled_axis(turn) * self.orientations[ball];
        }
        self.last.clone_from(&centers);
        let xyzw = |q: &UnitQuaternion<f64>| -> [f64; 4] { q.coords.into() };
        Snapshot {
            epoch: 1,
            tick,
            time_s,
            wall_ns: 1_700_000_000_000_000_000 + tick * 16_666_667,
            energy_j: 451.0 * (1.0 + 1e-13 * (tick % 17) as f64),
            collisions: Collisions { ball_ball: tick / 40, ball_wall: tick / 25 },
            uv,
            center_m: centers.into_iter().map(Into::into).collect(),
            velocity_m_per_s: vec![[0.0; 3]; 3],
            omega_rad_per_s: vec![[0.0; 3]; 3],
            orientation_xyzw: self.orientations.iter().map(xyzw).collect(),
            ..Snapshot::default()
        }
    }
}
