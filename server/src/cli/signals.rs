//! Ctrl-C and SIGTERM: the first asks for an orderly end, the second is at once.

use ballroom_client::Abort;

/// A switch that the first signal throws.
pub fn abort_on_signal() -> anyhow::Result<Abort> {
    let abort = Abort::default();
    let switch = abort.clone();
    // A thread of its own: everything else here blocks.
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    std::thread::Builder::new().name("signals".into()).spawn(move || {
        let listened = runtime.block_on(async {
            next_signal().await?;
            switch.abort();
            next_signal().await
        });
        match listened {
            Ok(()) => std::process::exit(130),
            Err(e) => tracing::error!("signals are not heard: {e}"),
        }
    })?;
    Ok(abort)
}

#[cfg(unix)]
async fn next_signal() -> std::io::Result<()> {
    use tokio::signal::unix::{SignalKind, signal};
    let mut terminate = signal(SignalKind::terminate())?;
    tokio::select! {
        interrupted = tokio::signal::ctrl_c() => interrupted,
        _ = terminate.recv() => Ok(()),
    }
}

#[cfg(not(unix))]
async fn next_signal() -> std::io::Result<()> {
    tokio::signal::ctrl_c().await
}
