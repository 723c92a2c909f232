//! What a bridge sends to whoever watches: the newest tick, and where the eye of a view stands.

use crate::screen::Picture;
use re_protos::sdk_comms::v1alpha1::ReadMessagesRequest;
use re_protos::sdk_comms::v1alpha1::message_proxy_service_client::MessageProxyServiceClient;
use rerun::external::re_log_encoding::{DummyApplicationIdInjector, ToApplication};
use rerun::external::re_sdk_types::blueprint::archetypes::{EyeControls3D, ViewBlueprint};
use rerun::log::{Chunk, LogMsg};
use std::collections::BTreeMap;
use std::time::Duration;

/// Rerun's eye: this angle from the lower to the upper border of a view.
const FIELD_OF_VIEW_DEGREES: f64 = 55.0;

/// Reads what is served at `url` until something is found; panics after `patience`.
fn read_until<T>(url: &str, patience: Duration, mut find: impl FnMut(&LogMsg) -> Option<T>) -> T {
    let address = url.trim_start_matches("rerun+").trim_end_matches("/proxy").to_owned();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    let reading = async {
        let endpoint = tonic::transport::Endpoint::from_shared(address).expect("an address");
        let client = MessageProxyServiceClient::new(endpoint.connect().await.expect("a connection"));
        let mut client = client.max_decoding_message_size(usize::MAX);
        let mut stream = client.read_messages(ReadMessagesRequest {}).await.expect("an answer").into_inner();
        let application = &mut DummyApplicationIdInjector::new("ballroom");
        loop {
            let message = stream.message().await.expect("a stream").expect("more of it");
            let message = message.log_msg.expect("a message").to_application((application, None));
            if let Some(found) = find(&message.expect("a readable message")) {
                return found;
            }
        }
    };
    let found = runtime.block_on(async { tokio::time::timeout(patience, reading).await });
    found.unwrap_or_else(|_| panic!("{url}: waited {patience:?} in vain"))
}

fn chunk(message: &LogMsg) -> Option<(bool, Chunk)> {
    let LogMsg::ArrowMsg(store, arrow) = message else { return None };
    Some((store.is_recording(), Chunk::from_arrow_msg(arrow).expect("a readable chunk")))
}

/// The first tick from `wanted` on that arrives.
pub fn newest_tick_at(url: &str, patience: Duration, wanted: u64) -> u64 {
    read_until(url, patience, |message| {
        let (_, chunk) = chunk(message).filter(|(recording, chunk)| *recording && !chunk.is_static())?;
        let ticks = chunk.timelines().get(&"tick".into())?.times_raw().iter();
        ticks.filter_map(|tick| u64::try_from(*tick).ok()).find(|tick| *tick >= wanted)
    })
}

/// Where the eye of a view stands.
#[derive(Clone, Debug)]
pub struct Camera {
    /// The view's entity in the layout.
    pub view: String,
    eye: [f64; 3],
    target: [f64; 3],
}

impl Camera {
    /// The eye of the view with this title, as the layout that is served at `url` says.
    pub fn of(url: &str, title: &str) -> Self {
        let (mut views, mut eyes) = (BTreeMap::new(), BTreeMap::new());
        read_until(url, crate::wait::PATIENCE, |message| {
            let (_, chunk) = chunk(message).filter(|(recording, _)| !*recording)?;
            let path = chunk.entity_path().to_string();
            let name = ViewBlueprint::descriptor_display_name().component;
            if let Some(name) = chunk.iter_slices::<String>(name).flatten().next() {
                views.insert(name.to_string(), path.clone());
            }
            let point = |component| chunk.iter_slices::<[f32; 3]>(component).flatten().next().copied();
            let eye = point(EyeControls3D::descriptor_position().component);
            let target = point(EyeControls3D::descriptor_look_target().component);
            if let (Some(eye), Some(target)) = (eye, target) {
                eyes.insert(path, (eye.map(f64::from), target.map(f64::from)));
            }
            let view = views.get(title)?;
            let (eye, target) = *eyes.get(&format!("{view}/EyeControls3D"))?;
            Some(Self { view: view.clone(), eye, target })
        })
    }

    /// Where a point of space is seen, pixels from the left and from the top.
    pub fn project(&self, point_m: [f64; 3], picture: &Picture) -> [f64; 2] {
        let (right, up, depth) = self.seen_from(point_m);
        let scale = Self::scale(picture) / depth;
        [0.5 * picture.width as f64 + scale * right, 0.5 * picture.height as f64 - scale * up]
    }

    /// How large a length at a point is seen, pixels.
    pub fn pixels(&self, length_m: f64, point_m: [f64; 3], picture: &Picture) -> f64 {
        length_m * Self::scale(picture) / self.seen_from(point_m).2
    }

    fn scale(picture: &Picture) -> f64 {
        0.5 * picture.height as f64 / (0.5 * FIELD_OF_VIEW_DEGREES.to_radians()).tan()
    }

    /// To the right, upwards and ahead of the eye, m; up in space is z.
    fn seen_from(&self, point: [f64; 3]) -> (f64, f64, f64) {
        let less = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| a[i] - b[i]) };
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let unit = |a: [f64; 3]| a.map(|x| x / dot(a, a).sqrt());
        let ahead = unit(less(self.target, self.eye));
        let right = unit([ahead[1], -ahead[0], 0.0]);
        let up = [
            right[1] * ahead[2] - right[2] * ahead[1],
            right[2] * ahead[0] - right[0] * ahead[2],
            right[0] * ahead[1] - right[1] * ahead[0],
        ];
        let arm = less(point, self.eye);
        (dot(arm, right), dot(arm, up), dot(arm, ahead))
    }
}
