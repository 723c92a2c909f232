//! Towards a viewer elsewhere: this side connects, and connects again whenever the viewer was gone.
//!
//! Each connection begins with all that stands, for the viewer may be another one.

use crate::hub::Hub;
use re_protos::sdk_comms::v1alpha1::WriteMessagesRequest;
use re_protos::sdk_comms::v1alpha1::message_proxy_service_client::MessageProxyServiceClient;
use rerun::external::re_uri::ProxyUri;
use std::io;
use std::sync::Arc;
use std::time::Duration;
use tonic::transport::{Channel, Endpoint};

/// Time between two attempts to connect.
const AGAIN_AFTER: Duration = Duration::from_millis(250);
/// How long an attempt may take.
const CONNECT_PATIENCE: Duration = Duration::from_secs(5);
/// A viewer that does not answer for this long is asked whether it lives.
const ASK_AFTER: Duration = Duration::from_secs(5);
/// One that does not answer then either is given up, and connected to anew.
const ANSWER_WITHIN: Duration = Duration::from_secs(10);

/// Sends what the hub holds to a viewer, from a thread of its own, until the hub is closed.
pub fn start(hub: Arc<Hub>, viewer: ProxyUri) -> io::Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let endpoint = Endpoint::from_shared(viewer.origin.as_url()).map_err(io::Error::other)?;
    let endpoint = endpoint
        .tcp_nodelay(true)
        .connect_timeout(CONNECT_PATIENCE)
        .http2_keep_alive_interval(ASK_AFTER)
        .keep_alive_timeout(ANSWER_WITHIN)
        .keep_alive_while_idle(true);
    std::thread::Builder::new().name("push".into()).spawn(move || {
        runtime.block_on(async {
            let mut waiting = false;
            while !hub.is_closed() {
                match endpoint.connect().await {
                    Ok(channel) => {
                        tracing::info!("connected to the viewer at {viewer}");
                        waiting = false;
                        send(&hub, channel).await;
                        if !hub.is_closed() {
                            hub.count_reconnect();
                            tracing::warn!("the viewer at {viewer} is gone, waiting for it");
                        }
                    }
                    Err(_) if !std::mem::replace(&mut waiting, true) => {
                        tracing::info!("no viewer answers at {viewer} yet, waiting for it");
                    }
                    Err(_) => {}
                }
                tokio::time::sleep(AGAIN_AFTER).await;
            }
        });
    })?;
    Ok(())
}

/// Sends until the viewer or the hub ends.
async fn send(hub: &Arc<Hub>, channel: Channel) {
    let messages = futures_util::stream::unfold(hub.join(), |mut viewer| async {
        let message = viewer.next().await?;
        Some((WriteMessagesRequest { log_msg: Some(message) }, viewer))
    });
    let mut client = MessageProxyServiceClient::new(channel);
    if let Err(fault) = client.write_messages(messages).await {
        tracing::debug!("the viewer hung up: {fault}");
    }
}
