//! Viewers over real connections: what they hold after how long, what they may not do, and how they are found again.

#[path = "common/crowd.rs"]
mod crowd;

use crowd::state;
use protocol::scene::Floor;
use protocol::snapshot::World;
use re_protos::sdk_comms::v1alpha1::message_proxy_service_client::MessageProxyServiceClient;
use re_protos::sdk_comms::v1alpha1::{ReadMessagesRequest, ReadMessagesResponse, WriteMessagesRequest};
use rerun::RecordingStreamBuilder;
use rerun::external::re_grpc_server::{self, ServerOptions, shutdown};
use rerun::external::re_log_encoding::{DummyApplicationIdInjector, ToApplication};
use rerun::log::{Chunk, ChunkBatcherConfig, LogMsg};
use std::collections::BTreeMap;
use std::net::{SocketAddr, TcpListener};
use std::ops::RangeInclusive;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tonic::Code;
use tonic::transport::Channel;
use viewer_bridge::hub::{HISTORY_BYTES, Hub, HubSink};
use viewer_bridge::named_view::NamedView;
use viewer_bridge::recording::Recording;
use viewer_bridge::slot::News;
use viewer_bridge::view::View;
use viewer_bridge::{ball_view, push, scene_view, watch};

/// How long anything may take for which no claim says how long.
const PATIENCE: Duration = Duration::from_mins(1);

/// So many balls that go round on a plane.
fn world(balls: usize) -> World {
    crowd::world(Floor::Polynomial { x_m: [-10.0, 10.0], y_m: [-10.0, 10.0], terms: vec![] }, balls)
}

/// A recording into a hub.
fn view_into(hub: &Arc<Hub>) -> View {
    // A chunk a row, as when time goes by.
    let builder =
        RecordingStreamBuilder::new("ballroom_test").batcher_config(ChunkBatcherConfig::ALWAYS_TEST_ONLY);
    let stream = builder.buffered().unwrap();
    View::new(Recording::into_sink(stream, Box::new(HubSink(hub.clone()))), NamedView::default())
}

fn show_world(view: &mut View, world: World) {
    view.show(&News { world: Some(Arc::new(world)), ..News::default() }).unwrap();
    view.recording().stream().flush_blocking().unwrap();
}

fn show_states(view: &mut View, balls: usize, ticks: RangeInclusive<u64>) {
    for tick in ticks {
        view.show(&News { state: Some(Arc::new(state(balls, tick))), ..News::default() }).unwrap();
    }
    view.recording().stream().flush_blocking().unwrap();
}

/// A hub with a door.
fn open_door() -> (Arc<Hub>, SocketAddr) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let hub = Hub::new(HISTORY_BYTES);
    watch::serve(hub.clone(), listener, &[]).unwrap();
    (hub, address)
}

async fn viewer(address: SocketAddr) -> MessageProxyServiceClient<Channel> {
    let channel = tonic::transport::Endpoint::from_shared(format!("http://{address}")).unwrap();
    let channel = tokio::time::timeout(PATIENCE, channel.connect()).await.unwrap().unwrap();
    MessageProxyServiceClient::new(channel).max_decoding_message_size(usize::MAX)
}

/// What a viewer holds: for each entity how many instances, and the newest tick.
#[derive(Default)]
struct Held {
    entities: BTreeMap<String, usize>,
    tick: u64,
}

impl Held {
    fn take(&mut self, message: &LogMsg) {
        let LogMsg::ArrowMsg(store, arrow) = message else { return };
        if !store.is_recording() {
            return;
        }
        let chunk = Chunk::from_arrow_msg(arrow).unwrap();
        let translations = rerun::InstancePoses3D::descriptor_translations().component;
        let instances = chunk.iter_slices::<[f32; 3]>(translations).last().map_or(0, <[_]>::len);
        let held = self.entities.entry(chunk.entity_path().to_string()).or_default();
        *held = instances.max(*held);
        if instances > 0 {
            let ticks = chunk.timelines()[&"tick".into()].times_raw().iter().copied().max();
            self.tick = self.tick.max(ticks.and_then(|tick| u64::try_from(tick).ok()).unwrap_or(0));
        }
    }

    fn has_floor(&self) -> bool {
        self.entities.contains_key(&format!("/{}", scene_view::FLOOR))
    }

    fn balls(&self) -> usize {
        let below = format!("/{}/", ball_view::BALLS);
        self.entities.iter().filter(|(path, _)| path.starts_with(&below)).map(|(_, balls)| balls).sum()
    }
}

fn decoded(message: ReadMessagesResponse) -> LogMsg {
    let application = &mut DummyApplicationIdInjector::new("ballroom_test");
    message.log_msg.unwrap().to_application((application, None)).unwrap()
}

/// Reads until enough is held.
async fn read_until(address: SocketAddr, enough: impl Fn(&Held) -> bool) -> Held {
    let mut stream = viewer(address).await.read_messages(ReadMessagesRequest {}).await.unwrap().into_inner();
    let mut held = Held::default();
    while !enough(&held) {
        let message = tokio::time::timeout(PATIENCE, stream.message()).await.expect("more of it");
        held.take(&decoded(message.unwrap().unwrap()));
    }
    held
}

#[tokio::test]
async fn a_late_viewer_holds_floor_and_all_balls_of_the_newest_state_at_once() {
    let (hub, address) = open_door();
    let mut view = view_into(&hub);
    let (balls, ticks) = (1000, 1800);
    show_world(&mut view, world(balls));
    show_states(&mut view, balls, 1..=ticks);
    let mut slowest = Duration::ZERO;
    for _ in 0..5 {
        let began = Instant::now();
        let held = read_until(address, |held| held.has_floor() && held.balls() == balls).await;
        slowest = slowest.max(began.elapsed());
        assert_eq!(held.tick, ticks, "not the newest state");
    }
    let past = hub.held_bytes() >> 20;
    println!("floor and {balls} balls of the newest state, after {past} MiB of past: {slowest:.1?} at most");
}

#[tokio::test]
async fn a_viewer_may_look_and_not_draw() {
    let (hub, address) = open_door();
    let mut view = view_into(&hub);
    show_world(&mut view, world(3));
    let drawing = futures_util::stream::iter([WriteMessagesRequest { log_msg: None }]);
    let refused = viewer(address).await.write_messages(drawing).await.unwrap_err();
    assert_eq!(refused.code(), Code::PermissionDenied, "{refused}");
    let held = read_until(address, |held| held.has_floor() && held.balls() == 3).await;
    assert_eq!(held.balls(), 3);
}

/// Rerun's own server, as a viewer runs it, until the runtime is dropped.
fn viewer_elsewhere(address: SocketAddr) -> tokio::runtime::Runtime {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().unwrap();
    runtime.spawn(re_grpc_server::serve(address, ServerOptions::default(), shutdown::never()));
    runtime
}

fn until(what: &str, probe: impl Fn() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !probe() {
        assert!(Instant::now() < deadline, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_viewer_elsewhere_is_found_again_and_gets_everything_that_stands_anew() {
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let hub = Hub::new(HISTORY_BYTES);
    push::start(hub.clone(), format!("rerun+http://{address}/proxy").parse().unwrap()).unwrap();
    let mut view = view_into(&hub);
    show_world(&mut view, world(20));
    let reading = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    for round in 0..2 {
        let newest = 100 * (round + 1);
        show_states(&mut view, 20, 100 * round + 1..=newest);
        let elsewhere = viewer_elsewhere(address);
        until("a connection", || hub.sent().viewers == 1);
        reading.block_on(async {
            let all = |held: &Held| held.has_floor() && held.balls() == 20 && held.tick == newest;
            read_until(address, all).await;
        });
        elsewhere.shutdown_background();
        until("the loss to be noticed", || hub.sent().reconnects == round + 1 && hub.sent().viewers == 0);
    }
}

#[test]
fn a_viewer_elsewhere_that_stands_still_holds_nothing_up_and_costs_no_memory() {
    let stopped = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = stopped.local_addr().unwrap();
    let bytes = 4 << 20;
    let hub = Hub::new(bytes);
    push::start(hub.clone(), format!("rerun+http://{address}/proxy").parse().unwrap()).unwrap();
    // As a stopped process does: the system connects, nobody reads.
    let _connection = stopped.accept().unwrap();
    let mut view = view_into(&hub);
    let (balls, ticks) = (1000, 1000);
    show_world(&mut view, world(balls));
    show_states(&mut view, balls, 1..=ticks);
    assert!(hub.held_bytes() <= bytes, "{}", hub.held_bytes());
    let taken = hub.sent().taken;
    assert!(taken < ticks, "{taken} messages were taken by one who reads none");
}
