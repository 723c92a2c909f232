//! The terminal while the dashboard is shown, and what its keys mean.

use super::table;
use crate::cli::sight::Sight;
use crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use crossterm::{cursor, execute, queue, style, terminal};
use std::io::{Stdout, Write, stdout};

/// The terminal, given back when this is dropped and also when something panics.
pub struct Terminal(Stdout);

impl Terminal {
    /// Takes it over.
    pub fn take() -> std::io::Result<Self> {
        terminal::enable_raw_mode()?;
        // From here on whatever happens gives it back.
        let taken = Self(stdout());
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            give_back();
            hook(panic);
        }));
        execute!(stdout(), terminal::EnterAlternateScreen, cursor::Hide)?;
        Ok(taken)
    }

    /// Characters that a line has room for.
    pub fn width() -> std::io::Result<usize> {
        Ok(usize::from(terminal::size()?.0))
    }

    /// Shows lines, as many and as much of each as there is room for.
    pub fn show(&self, lines: &[String]) -> std::io::Result<()> {
        let (width, height) = terminal::size()?;
        let mut out = self.0.lock();
        queue!(out, terminal::BeginSynchronizedUpdate)?;
        for (row, line) in (0..height).zip(lines) {
            let line: String = line.chars().take(usize::from(width)).collect();
            let until_end = terminal::Clear(terminal::ClearType::UntilNewLine);
            queue!(out, cursor::MoveTo(0, row), style::Print(line), until_end)?;
        }
        if lines.len() < usize::from(height) {
            queue!(out, cursor::MoveTo(0, lines.len() as u16))?;
            queue!(out, terminal::Clear(terminal::ClearType::FromCursorDown))?;
        }
        queue!(out, terminal::EndSynchronizedUpdate)?;
        out.flush()
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        give_back();
    }
}

fn give_back() {
    // What cannot be given back is gone; there is nobody to tell.
    drop(execute!(stdout(), terminal::LeaveAlternateScreen, cursor::Show));
    drop(terminal::disable_raw_mode());
}

/// What a key asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wish {
    /// To end.
    Quit,
    /// To pause the arena if it runs, else to let it run.
    PauseOrResume(String),
    /// To reset the arena.
    Reset(String),
}

/// What is shown and what is chosen.
#[derive(Default)]
pub struct Screen {
    sights: Vec<Sight>,
    chosen: Option<String>,
    /// The arena whose reset waits for a yes.
    asks: Option<String>,
    said: String,
}

impl Screen {
    /// Takes in what is seen; an arena that ended is chosen no more.
    pub fn see(&mut self, sights: Vec<Sight>) {
        let is_there = |name: &String| sights.iter().any(|sight| sight.row.arena == *name);
        self.chosen = self.chosen.take().filter(is_there);
        self.asks = self.asks.take().filter(is_there);
        self.chosen = self.chosen.take().or_else(|| sights.first().map(|sight| sight.row.arena.clone()));
        self.sights = sights;
    }

    /// Takes in what came of the last wish.
    pub fn say(&mut self, what: String) {
        self.said = what;
    }

    /// The chosen arena as it was seen.
    pub fn chosen(&self) -> Option<&Sight> {
        self.sights.iter().find(|sight| Some(&sight.row.arena) == self.chosen.as_ref())
    }

    /// What a key asks for, if it is more than another choice.
    pub fn press(&mut self, key: KeyEvent) -> Option<Wish> {
        if key.kind == KeyEventKind::Release {
            return None;
        }
        if let Some(arena) = self.asks.take() {
            return (key.code == KeyCode::Char('y')).then_some(Wish::Reset(arena));
        }
        self.said.clear();
        match key.code {
            KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => return Some(Wish::Quit),
            KeyCode::Char('q') | KeyCode::Esc => return Some(Wish::Quit),
            KeyCode::Up => self.choose(-1),
            KeyCode::Down => self.choose(1),
            KeyCode::Char('p') => return self.chosen.clone().map(Wish::PauseOrResume),
            KeyCode::Char('r') => self.asks.clone_from(&self.chosen),
            _ => {}
        }
        None
    }

    fn choose(&mut self, by: isize) {
        let here = self.sights.iter().position(|sight| Some(&sight.row.arena) == self.chosen.as_ref());
        let there = here.unwrap_or(0).saturating_add_signed(by).min(self.sights.len().saturating_sub(1));
        self.chosen = self.sights.get(there).map(|sight| sight.row.arena.clone());
    }

    /// As lines of text, of at most `width` characters where columns can be left out.
    pub fn lines(&self, width: usize) -> Vec<String> {
        let mut lines = table::arenas(&self.sights, self.chosen.as_deref(), width);
        lines.extend(self.chosen().map(|sight| table::details(sight, width)).unwrap_or_default());
        lines.push(String::new());
        lines.push(match &self.asks {
            Some(arena) => format!("  reset {arena}? y for yes, any other key for no"),
            None => "  up, down: choose   p: pause or resume   r: reset   q: quit".to_owned(),
        });
        if !self.said.is_empty() {
            lines.push(format!("  {}", self.said));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::tests::sight;
    use super::*;

    fn screen() -> Screen {
        let mut screen = Screen::default();
        screen.see(vec![sight("left"), sight("right")]);
        screen
    }

    fn press(screen: &mut Screen, code: KeyCode) -> Option<Wish> {
        screen.press(KeyEvent::new(code, KeyModifiers::NONE))
    }

    #[test]
    fn arrows_choose_within_the_list_and_keys_mean_the_chosen_arena() {
        let mut screen = screen();
        for (key, chosen) in [
            (KeyCode::Up, "left"),
            (KeyCode::Down, "right"),
            (KeyCode::Down, "right"),
            (KeyCode::Up, "left"),
            (KeyCode::Down, "right"),
        ] {
            assert_eq!(press(&mut screen, key), None);
            assert_eq!(screen.chosen().unwrap().row.arena, chosen);
        }
        assert_eq!(press(&mut screen, KeyCode::Char('p')), Some(Wish::PauseOrResume("right".into())));
        assert_eq!(press(&mut screen, KeyCode::Char('q')), Some(Wish::Quit));
        let interrupt = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert_eq!(screen.press(interrupt), Some(Wish::Quit));
    }

    #[test]
    fn a_reset_is_asked_for_twice_and_any_other_key_means_no() {
        let mut screen = screen();
        assert_eq!(press(&mut screen, KeyCode::Char('r')), None);
        assert!(screen.lines(usize::MAX).last().unwrap().contains("reset left?"));
        assert_eq!(press(&mut screen, KeyCode::Char('q')), None);
        assert_eq!(press(&mut screen, KeyCode::Char('r')), None);
        assert_eq!(press(&mut screen, KeyCode::Char('y')), Some(Wish::Reset("left".into())));
    }

    #[test]
    fn an_arena_that_ended_is_chosen_no_more() {
        let mut screen = screen();
        press(&mut screen, KeyCode::Down);
        press(&mut screen, KeyCode::Char('r'));
        screen.see(vec![sight("left")]);
        assert_eq!(screen.chosen().unwrap().row.arena, "left");
        assert_eq!(press(&mut screen, KeyCode::Char('y')), None);
        screen.see(Vec::new());
        assert!(screen.chosen().is_none() && press(&mut screen, KeyCode::Char('p')).is_none());
    }
}
