//! Errors to exit codes. Each error is said here, once.

use ballroom_cases::UnknownCase;
use ballroom_client::ClientError;
use server::report::ReportError;
use server::{ArenaError, SceneError};
use std::io::ErrorKind;
use std::process::ExitCode;

/// The server was asked and refused; the text is its own.
#[derive(Debug, thiserror::Error)]
#[error("refused: {0}")]
pub struct Refused(pub String);

/// A signal came before the work was done.
#[derive(Debug, thiserror::Error)]
#[error("ended by a signal before the work was done")]
pub struct Interrupted;

/// Says the error on stderr, unless it is only that nobody reads any more, and picks the code.
pub fn code_of(error: &anyhow::Error) -> ExitCode {
    if is_broken_pipe(error) {
        return ExitCode::SUCCESS;
    }
    eprintln!("ballroom: {error:#}");
    let is_scene = error.is::<SceneError>()
        || matches!(error.downcast_ref::<ArenaError>(), Some(ArenaError::Scene(_)))
        || matches!(error.downcast_ref::<ReportError>(), Some(ReportError::Scene(_)));
    if error.downcast_ref::<ClientError>().is_some_and(ClientError::is_no_server) {
        ExitCode::from(3)
    } else if error.is::<UnknownCase>()
        || matches!(error.downcast_ref(), Some(ClientError::Command(_)))
        || matches!(error.downcast_ref(), Some(ArenaError::Name(_)))
    {
        ExitCode::from(2)
    } else if error.is::<Refused>() {
        ExitCode::from(4)
    } else if is_scene {
        ExitCode::from(5)
    } else if error.is::<Interrupted>() {
        ExitCode::from(130)
    } else {
        ExitCode::FAILURE
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        let io = cause.downcast_ref::<std::io::Error>().map(std::io::Error::kind);
        let json = cause.downcast_ref::<serde_json::Error>().and_then(serde_json::Error::io_error_kind);
        let csv = cause.downcast_ref::<csv::Error>().and_then(|e| match e.kind() {
            csv::ErrorKind::Io(io) => Some(io.kind()),
            _ => None,
        });
        [io, json, csv].contains(&Some(ErrorKind::BrokenPipe))
    })
}
