//! The session of a process, shared by its arenas.

use super::{CLOSE_TIMEOUT, NetworkError, session};
use crate::arena::NetworkOptions;
use crate::checker::Checker;
use std::sync::Arc;
use zenoh::{Session, Wait};

/// A session and where it listens; its copies are the same session.
#[derive(Clone)]
pub(crate) struct Link {
    session: Session,
    endpoints: Arc<[String]>,
    checker: Checker,
}

impl Link {
    /// Opens the session.
    pub fn open(options: &NetworkOptions) -> Result<Self, NetworkError> {
        let (session, endpoints) = session::open(options)?;
        Ok(Self { session, endpoints: endpoints.into(), checker: Checker::start()? })
    }

    /// The session.
    pub const fn session(&self) -> &Session {
        &self.session
    }

    /// Where clients connect to.
    pub fn endpoints(&self) -> &[String] {
        &self.endpoints
    }

    /// Who checks scenes.
    pub const fn checker(&self) -> &Checker {
        &self.checker
    }

    /// Ends the session for all copies.
    pub fn close(self) {
        // Closing may wait long for a link that is in trouble; nobody has to wait for that.
        let (done, closed) = std::sync::mpsc::sync_channel(1);
        let session = self.session;
        std::thread::spawn(move || drop(done.send(session.close().wait())));
        if !matches!(closed.recv_timeout(CLOSE_TIMEOUT), Ok(Ok(()))) {
            tracing::debug!("the session did not close in order");
        }
    }
}
