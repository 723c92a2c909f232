//! Any number of balls that go round, for benches and tests of what viewers get.

use protocol::scene::{Accuracy, Floor, Motion, Scene, Steering, Walls};
use protocol::snapshot::{Roster, Snapshot, World};

/// So many balls on a floor of 20 m by 20 m, at tick 0.
pub fn world(floor: Floor, balls: usize) -> World {
    let scene = Scene {
        version: 1,
        name: "crowd".into(),
        description: String::new(),
        gravity_m_per_s2: [0.0, 0.0, -9.8],
        motion: Motion::Rolling,
        restitution: 1.0,
        accuracy: Accuracy::default(),
        hit_budget: 1 << 22,
        floor,
        walls: Walls::default(),
        steering: Steering::default(),
        balls: vec![],
        clouds: vec![],
    };
    let roster = Roster {
        names: (0..balls).map(|ball| format!("b{ball:05}")).collect(),
        radius_m: vec![0.1; balls],
        mass_kg: vec![1.0; balls],
        inertia_factor: vec![0.4; balls],
        color_rgb: (0..balls).map(|ball| [(ball % 12) as u8 * 20, 120, 60]).collect(),
        player: (0..balls).map(|ball| ball == 0).collect(),
        ..Roster::default()
    };
    World { scene, roster, tick_rate_hz: 60, snapshot: state(balls, 0) }
}

/// The balls at a tick, each on a circle of its own.
pub fn state(balls: usize, tick: u64) -> Snapshot {
    let time_s = tick as f64 / 60.0;
    let place = |ball: usize| {
        let (sin, cos) = (0.01 * ball as f64 + 0.7 * time_s).sin_cos();
        let radius = 9.0 * ((ball + 1) as f64 / balls as f64).sqrt();
        [radius * cos, radius * sin]
    };
    let each = || (0..balls).map(place);
    Snapshot {
        epoch: 1,
        tick,
        time_s,
        wall_ns: 1_700_000_000_000_000_000 + tick * 16_666_667,
        uv: each().map(|[x, y]| [0.5 + x / 20.0, 0.5 + y / 20.0]).collect(),
        center_m: each().map(|[x, y]| [x, y, 0.1]).collect(),
        velocity_m_per_s: each().map(|[x, y]| [-0.7 * y, 0.7 * x, 0.0]).collect(),
        omega_rad_per_s: each().map(|[x, y]| [-7.0 * x, -7.0 * y, 0.3]).collect(),
        orientation_xyzw: each().map(|[x, y]| [0.6 * x.signum(), 0.0, 0.0, 0.8 * y.signum()]).collect(),
        ..Snapshot::default()
    }
}
