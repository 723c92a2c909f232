//! The terminal: raw mode with a few lines at the bottom, log lines above them, and back to normal at every end.

use crossterm::event::{
    DisableFocusChange, EnableFocusChange, KeyboardEnhancementFlags, PopKeyboardEnhancementFlags,
    PushKeyboardEnhancementFlags,
};
use crossterm::terminal::{Clear, ClearType};
use crossterm::{cursor, execute, queue, terminal};
use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The one screen of this process: log lines may come from any thread at any time.
static SCREEN: Mutex<Screen> =
    Mutex::new(Screen { raw: false, releases: false, lines: Vec::new(), drawn: 0 });

struct Screen {
    raw: bool,
    releases: bool,
    /// What is shown at the bottom.
    lines: Vec<String>,
    /// How many lines of that stand there now.
    drawn: u16,
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
        let (width, _) = size();
        // A line as wide as the terminal wraps on some.
        let mut line: String = status.chars().take(width.saturating_sub(1)).collect();
        if line.chars().count() + tail.chars().count() < width {
            line.push_str(tail);
        }
        let mut screen = lock();
        screen.lines = vec![line];
        screen.draw(b"")
    }

    /// Shows lines in place of the last ones, cut to the terminal.
    pub fn show_lines(&self, lines: &[String]) -> io::Result<()> {
        let (width, height) = size();
        let cut = |line: &String| line.chars().take(width.saturating_sub(1)).collect();
        let mut screen = lock();
        screen.lines = lines.iter().take(height.saturating_sub(1)).map(cut).collect();
        screen.draw(b"")
    }
}

/// Columns and rows; some terminals say that they have none.
fn size() -> (usize, usize) {
    let known = terminal::size().ok().filter(|(columns, rows)| *columns > 0 && *rows > 0);
    known.map_or((80, 24), |(columns, rows)| (columns.into(), rows.into()))
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
    // The last lines stay.
    execute!(out, DisableFocusChange, cursor::Show).ok();
    terminal::disable_raw_mode().ok();
    writeln!(out).ok();
}

/// Writes log lines above what is shown, or plainly while nothing is.
#[derive(Clone, Copy, Debug, Default)]
pub struct LogLines;

impl Write for LogLines {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut screen = lock();
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
    /// Draws whole lines of text, then what is shown under them, in one write.
    fn draw(&mut self, lines: &[u8]) -> io::Result<()> {
        let mut frame = Vec::new();
        if self.drawn > 1 {
            queue!(frame, cursor::MoveUp(self.drawn - 1))?;
        }
        queue!(frame, cursor::MoveToColumn(0), Clear(ClearType::FromCursorDown))?;
        // Raw mode does not return the carriage by itself.
        for line in lines.split(|byte| *byte == b'\n').filter(|line| !line.is_empty()) {
            frame.extend_from_slice(line);
            frame.extend_from_slice(b"\r\n");
        }
        frame.extend_from_slice(self.lines.join("\r\n").as_bytes());
        self.drawn = self.lines.len() as u16;
        let mut out = io::stderr().lock();
        out.write_all(&frame)?;
        out.flush()
    }
}

/// A panic elsewhere must not keep the terminal from being given back.
fn lock() -> MutexGuard<'static, Screen> {
    SCREEN.lock().unwrap_or_else(PoisonError::into_inner)
}
