//! CPU time of the bridge for one state, encoding included, by number of balls.
//!
//! `cargo bench -p viewer-bridge --bench states`

use cpu_time::ProcessTime;
use protocol::scene::{Accuracy, Floor, Motion, Scene, Steering, Walls};
use protocol::snapshot::{Roster, Snapshot, World};
use rerun::RecordingStreamBuilder;
use rerun::log::LogMsg;
use rerun::sink::CallbackSink;
use std::sync::Arc;
use viewer_bridge::named_view::NamedView;
use viewer_bridge::recording::Recording;
use viewer_bridge::slot::News;
use viewer_bridge::view::View;

const STATES: u64 = 600;

fn main() {
    println!("| balls | ms of CPU a state |\n|---|---|");
    for balls in [3, 64, 1_000, 10_000] {
        println!("| {balls} | {:.3} |", milliseconds_a_state(balls));
    }
}

/// Draws ten seconds of states at 60 Hz.
fn milliseconds_a_state(balls: usize) -> f64 {
    let stream = RecordingStreamBuilder::new("ballroom_bench").buffered().expect("a stream");
    let sink = CallbackSink::new(|messages: &[LogMsg]| {
        std::hint::black_box(messages.len());
    });
    let mut view = View::new(Recording::into_sink(stream, Box::new(sink)), NamedView::default());
    let world = world(balls);
    view.show(&News { world: Some(Arc::new(world.clone())), ..News::default() }).expect("drawn");
    let states: Vec<Arc<Snapshot>> = (1..=STATES).map(|tick| Arc::new(state(balls, tick))).collect();
    view.recording().stream().flush_blocking().expect("flushed");
    let began = ProcessTime::now();
    for state in states {
        view.show(&News { state: Some(state), ..News::default() }).expect("drawn");
    }
    view.recording().stream().flush_blocking().expect("flushed");
    began.elapsed().as_secs_f64() * 1e3 / STATES as f64
}

fn world(balls: usize) -> World {
    let mut rows = vec![vec![0.0; 11]; 11];
    rows[5][3] = -70.0;
    rows[5][7] = 40.0;
    let scene = Scene {
        version: 1,
        name: "bench".into(),
        description: String::new(),
        gravity_m_per_s2: [0.0, 0.0, -9.8],
        motion: Motion::Rolling,
        restitution: 1.0,
        accuracy: Accuracy::default(),
        hit_budget: 1 << 22,
        floor: Floor::Grid { x_m: [-10.0, 10.0], y_m: [-10.0, 10.0], control_heights_m: rows },
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

/// Balls that go round, each on a circle of its own.
fn state(balls: usize, tick: u64) -> Snapshot {
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
