//! CPU time of the bridge for one state, encoding included, by number of balls.
//!
//! `cargo bench -p viewer-bridge --bench states`

#[path = "../tests/common/crowd.rs"]
mod crowd;

use cpu_time::ProcessTime;
use crowd::{state, world};
use protocol::scene::Floor;
use protocol::snapshot::Snapshot;
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
    let world = world(original_floor(), balls);
    view.show(&News { world: Some(Arc::new(world)), ..News::default() }).expect("drawn");
    let states: Vec<Arc<Snapshot>> = (1..=STATES).map(|tick| Arc::new(state(balls, tick))).collect();
    view.recording().stream().flush_blocking().expect("flushed");
    let began = ProcessTime::now();
    for state in states {
        view.show(&News { state: Some(state), ..News::default() }).expect("drawn");
    }
    view.recording().stream().flush_blocking().expect("flushed");
    began.elapsed().as_secs_f64() * 1e3 / STATES as f64
}

/// That of the scene `original`.
fn original_floor() -> Floor {
    let mut rows = vec![vec![0.0; 11]; 11];
    rows[5][3] = -70.0;
    rows[5][7] = 40.0;
    Floor::Grid { x_m: [-10.0, 10.0], y_m: [-10.0, 10.0], control_heights_m: rows }
}
