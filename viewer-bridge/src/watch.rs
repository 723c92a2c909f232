//! The door for viewers: they may look, and nothing that they say is heard.
//!
//! It speaks the proxy protocol of Rerun, whose own server lets whoever reaches it draw into everybody's picture,
//! and slows the recording down to the slowest viewer.

use crate::hub::{Hub, Viewer};
use re_protos::sdk_comms::v1alpha1::message_proxy_service_server::{
    MessageProxyService, MessageProxyServiceServer,
};
use re_protos::sdk_comms::v1alpha1::{
    ReadMessagesRequest, ReadMessagesResponse, ReadTablesRequest, ReadTablesResponse, WriteMessagesRequest,
    WriteMessagesResponse, WriteTableRequest, WriteTableResponse,
};
use rerun::external::re_grpc_server::cors_layer;
use std::io;
use std::net::TcpListener;
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;
use tokio_stream::Stream;
use tonic::transport::Server;
use tonic::transport::server::TcpIncoming;
use tonic::{Request, Response, Status, Streaming};

/// Viewers at one time.
pub const MAX_VIEWERS: usize = 32;

/// A viewer that does not answer for this long is asked whether it lives.
const ASK_AFTER: Duration = Duration::from_secs(10);
/// One that does not answer then either is let go of.
const ANSWER_WITHIN: Duration = Duration::from_secs(20);

/// Serves what the hub holds to viewers, until the process ends. `origins` are those from which web pages may ask.
pub fn serve(hub: Arc<Hub>, listener: TcpListener, origins: &[String]) -> io::Result<()> {
    listener.set_nonblocking(true)?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let cors = cors_layer(origins);
    std::thread::Builder::new().name("viewers".into()).spawn(move || {
        let served = runtime.block_on(async {
            let incoming =
                TcpIncoming::from(tokio::net::TcpListener::from_std(listener)?).with_nodelay(Some(true));
            let service = MessageProxyServiceServer::new(Door(hub)).max_encoding_message_size(usize::MAX);
            Server::builder()
                // The web viewer speaks HTTP 1.
                .accept_http1(true)
                .http2_keepalive_interval(Some(ASK_AFTER))
                .http2_keepalive_timeout(Some(ANSWER_WITHIN))
                .layer(cors)
                .layer(tonic_web::GrpcWebLayer::new())
                .add_service(service)
                .serve_with_incoming(incoming)
                .await
                .map_err(io::Error::other)
        });
        if let Err(fault) = served {
            tracing::error!("viewers are no longer served: {fault}");
        }
    })?;
    Ok(())
}

struct Door(Arc<Hub>);

type Answers<T> = Pin<Box<dyn Stream<Item = Result<T, Status>> + Send>>;

fn read_only<T>() -> Result<Response<T>, Status> {
    Err(Status::permission_denied("Ballroom's viewer bridge is read-only: run a viewer of your own to draw"))
}

#[tonic::async_trait]
impl MessageProxyService for Door {
    type ReadMessagesStream = Answers<ReadMessagesResponse>;
    type ReadTablesStream = Answers<ReadTablesResponse>;

    async fn read_messages(
        &self,
        _: Request<ReadMessagesRequest>,
    ) -> Result<Response<Self::ReadMessagesStream>, Status> {
        if self.0.sent().viewers >= MAX_VIEWERS {
            return Err(Status::resource_exhausted(format!("{MAX_VIEWERS} viewers are here: close one")));
        }
        let answer = |mut viewer: Viewer| async {
            let message = viewer.next().await?;
            Some((Ok(ReadMessagesResponse { log_msg: Some(message) }), viewer))
        };
        Ok(Response::new(Box::pin(futures_util::stream::unfold(self.0.join(), answer))))
    }

    async fn write_messages(
        &self,
        _: Request<Streaming<WriteMessagesRequest>>,
    ) -> Result<Response<WriteMessagesResponse>, Status> {
        read_only()
    }

    async fn write_table(
        &self,
        _: Request<WriteTableRequest>,
    ) -> Result<Response<WriteTableResponse>, Status> {
        read_only()
    }

    async fn read_tables(
        &self,
        _: Request<ReadTablesRequest>,
    ) -> Result<Response<Self::ReadTablesStream>, Status> {
        Ok(Response::new(Box::pin(tokio_stream::empty())))
    }
}
