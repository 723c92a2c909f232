//! Ctrl-C and SIGTERM: the first asks for an orderly end, the second is at once.

use anyhow::Context;
use ballroom_client::Abort;

/// A switch that the first signal throws. Signals are caught from the moment this returns.
pub fn abort_on_signal() -> anyhow::Result<Abort> {
    let abort = Abort::default();
    let switch = abort.clone();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let mut signals = {
        let _registers_with = runtime.enter();
        Signals::catch().context("signals cannot be caught")?
    };
    // A thread of its own: everything else here blocks.
    std::thread::Builder::new().name("signals".into()).spawn(move || {
        runtime.block_on(async {
            signals.next().await;
            switch.abort();
            signals.next().await;
        });
        server::terminal::screen::restore();
        std::process::exit(130)
    })?;
    Ok(abort)
}

#[cfg(unix)]
struct Signals {
    interrupt: tokio::signal::unix::Signal,
    terminate: tokio::signal::unix::Signal,
}

#[cfg(unix)]
impl Signals {
    fn catch() -> std::io::Result<Self> {
        use tokio::signal::unix::{SignalKind, signal};
        Ok(Self { interrupt: signal(SignalKind::interrupt())?, terminate: signal(SignalKind::terminate())? })
    }

    async fn next(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
        }
    }
}

#[cfg(windows)]
struct Signals(tokio::signal::windows::CtrlC);

#[cfg(windows)]
impl Signals {
    fn catch() -> std::io::Result<Self> {
        tokio::signal::windows::ctrl_c().map(Self)
    }

    async fn next(&mut self) {
        self.0.recv().await;
    }
}
