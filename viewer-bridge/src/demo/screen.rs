//! The terminal: raw mode with one status line at the bottom, log lines above it, and back to normal at every end.

use crossterm::event::{
    DisableFocusChange, EnableFocusChange, KeyboardEnhancementFlags, PopKeyboardEnhancementFlags,
    PushKeyboardEnhancementFlags,
};
use crossterm::terminal::{Clear, ClearType};
use crossterm::{cursor, execute, queue, terminal};
use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The one screen of this process: log lines may come from any thread at any time.
static SCREEN: Mutex<Screen> = Mutex::new(Screen { raw: false, releases: false, status: String::new() });

struct Screen {
    raw: bool,
    releases: bool,
    status: String,
}

/// Raw mode while this lives.
pub struct RawMode(());

impl RawMode {
    /// Takes the terminal over; None where keys or the status line would go nowhere. A panic gives it back before
    /// it is told.
    pub fn enter() -> io::Result<Option<Self>> {
        if !io::stdin().is_terminal() || !io::stderr().is_terminal() {
            return Ok(None);
        }
        let tell = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if std::thread::current().name() == Some("main") {
                restore();
                tell(panic);
            } else {
                // The others do not own the terminal; what they leave undone is seen and ends the program.
                tracing::error!("{panic}");
            }
        }));
        terminal::enable_raw_mode()?;
        let guard = Self(());
        let mut screen = lock();
        screen.raw = true;
        // Some terminals do not answer the question; then a press is all there is.
        screen.releases = cfg!(windows) || terminal::supports_keyboard_enhancement().unwrap_or(false);
        let flags = KeyboardEnhancementFlags::DISAMBIGUATE_ESCAPE_CODES
            | KeyboardEnhancementFlags::REPORT_EVENT_TYPES;
        if screen.releases && !cfg!(windows) {
            execute!(io::stderr(), PushKeyboardEnhancementFlags(flags))?;
        }
        execute!(io::stderr(), EnableFocusChange, cursor::Hide)?;
        drop(screen);
        Ok(Some(guard))
    }

    /// Whether the terminal tells when a key is let go.
    pub fn reports_releases(&self) -> bool {
        lock().releases
    }

    /// Shows a status line in place of the last one, cut to the terminal's width. The tail is shown if all of it
    /// fits: half an address is none.
    pub fn show(&self, status: &str, tail: &str) -> io::Result<()> {
        let width = terminal::size().map_or(80, |(columns, _)| usize::from(columns));
        let mut screen = lock();
        // A line as wide as the terminal wraps on some.
        screen.status = status.chars().take(width.saturating_sub(1)).collect();
        if screen.status.chars().count() + tail.chars().count() < width {
            screen.status.push_str(tail);
        }
        screen.draw(b"")
    }
}

impl Drop for RawMode {
    fn drop(&mut self) {
        restore();
    }
}

/// Gives the terminal back; more than once does no harm.
pub fn restore() {
    let mut screen = lock();
    if !std::mem::take(&mut screen.raw) {
        return;
    }
    let mut out = io::stderr();
    if screen.releases && !cfg!(windows) {
        execute!(out, PopKeyboardEnhancementFlags).ok();
    }
    // The last status stays as the last line.
    execute!(out, DisableFocusChange, cursor::Show).ok();
    terminal::disable_raw_mode().ok();
    writeln!(out).ok();
}

/// Writes log lines above the status line, or plainly while there is none.
#[derive(Clone, Copy, Debug, Default)]
pub struct LogLines;

impl Write for LogLines {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let screen = lock();
        if screen.raw {
            screen.draw(bytes)?;
        } else {
            io::stderr().write_all(bytes)?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}

impl Screen {
    /// Draws whole lines of text, then the status line under them, in one write.
    fn draw(&self, lines: &[u8]) -> io::Result<()> {
        let mut frame = Vec::with_capacity(lines.len() + self.status.len() + 16);
        queue!(frame, cursor::MoveToColumn(0), Clear(ClearType::CurrentLine))?;
        // Raw mode does not return the carriage by itself.
        for line in lines.split(|byte| *byte == b'\n').filter(|line| !line.is_empty()) {
            frame.extend_from_slice(line);
            frame.extend_from_slice(b"\r\n");
        }
        frame.extend_from_slice(self.status.as_bytes());
        let mut out = io::stderr().lock();
        out.write_all(&frame)?;
        out.flush()
    }
}

/// A panic elsewhere must not keep the terminal from being given back.
fn lock() -> MutexGuard<'static, Screen> {
    SCREEN.lock().unwrap_or_else(PoisonError::into_inner)
}
