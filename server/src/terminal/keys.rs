//! From key presses to what is wanted.

use crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

/// What a key asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wish {
    /// One push of the player's ball along a direction of length 1.
    Push([f64; 2]),
    /// A held force along a direction of length 1, or none.
    Hold(Option<[f64; 2]>),
    /// Pause or go on.
    TogglePause,
    /// Back to the scene's first state.
    Reset,
    /// More simulated seconds a second.
    Faster,
    /// Fewer.
    Slower,
    /// One tick of a paused arena.
    Step,
    /// The end.
    Quit,
}

/// Which arrows are down.
#[derive(Debug, Default)]
pub struct Keys {
    /// Whether the terminal tells when a key is let go.
    releases: bool,
    /// Up, down, left, right.
    down: [bool; 4],
}

const ARROWS: [(KeyCode, [f64; 2]); 4] = [
    (KeyCode::Up, [0.0, 1.0]),
    (KeyCode::Down, [0.0, -1.0]),
    (KeyCode::Left, [-1.0, 0.0]),
    (KeyCode::Right, [1.0, 0.0]),
];

impl Keys {
    /// No key is down. Where the terminal reports releases an arrow is a held force, else each press is a push.
    pub const fn new(releases: bool) -> Self {
        Self { releases, down: [false; 4] }
    }

    /// What an event asks for, if anything.
    pub fn wish(&mut self, event: KeyEvent) -> Option<Wish> {
        if let Some(arrow) = ARROWS.iter().position(|(code, _)| *code == event.code) {
            return self.arrow(arrow, event.kind);
        }
        if event.kind == KeyEventKind::Release {
            return None;
        }
        match event.code {
            KeyCode::Char('c' | 'd') if event.modifiers.contains(KeyModifiers::CONTROL) => Some(Wish::Quit),
            KeyCode::Char('q') | KeyCode::Esc => Some(Wish::Quit),
            KeyCode::Char('+' | '=') => Some(Wish::Faster),
            KeyCode::Char('-') => Some(Wish::Slower),
            KeyCode::Char('.') => Some(Wish::Step),
            // A held space or r would flicker.
            KeyCode::Char(' ') if event.kind == KeyEventKind::Press => Some(Wish::TogglePause),
            KeyCode::Char('r') if event.kind == KeyEventKind::Press => Some(Wish::Reset),
            _ => None,
        }
    }

    /// The force that is held now; it must be renewed, for the server lets go of what it does not hear of.
    pub fn held(&self) -> Option<[f64; 2]> {
        let sum = ARROWS.iter().zip(self.down).filter(|(_, down)| *down);
        let [x, y] = sum.fold([0.0, 0.0], |[x, y], ((_, d), _)| [x + d[0], y + d[1]]);
        let length = f64::hypot(x, y);
        // Rounding must not make a diagonal longer than 1, which the server would refuse.
        (length > 0.0).then(|| [x, y].map(|c| (c / length).clamp(-0.999_999, 0.999_999)))
    }

    /// Lets go of everything: a window that loses its focus is not told of releases any more.
    pub fn let_go(&mut self) -> Option<Wish> {
        let held = std::mem::take(&mut self.down).contains(&true);
        held.then_some(Wish::Hold(None))
    }

    fn arrow(&mut self, arrow: usize, kind: KeyEventKind) -> Option<Wish> {
        match (self.releases, kind) {
            (false, KeyEventKind::Press | KeyEventKind::Repeat) => Some(Wish::Push(ARROWS[arrow].1)),
            (true, KeyEventKind::Press | KeyEventKind::Release) => {
                self.down[arrow] = kind == KeyEventKind::Press;
                Some(Wish::Hold(self.held()))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(code: KeyCode, kind: KeyEventKind) -> KeyEvent {
        KeyEvent::new_with_kind(code, KeyModifiers::NONE, kind)
    }

    #[test]
    fn a_press_pushes_where_releases_are_not_reported() {
        let mut keys = Keys::new(false);
        assert_eq!(keys.wish(key(KeyCode::Left, KeyEventKind::Press)), Some(Wish::Push([-1.0, 0.0])));
        assert_eq!(keys.held(), None);
    }

    #[test]
    fn arrows_are_held_until_released_and_add_up_to_length_one() {
        let mut keys = Keys::new(true);
        keys.wish(key(KeyCode::Up, KeyEventKind::Press));
        let both = keys.wish(key(KeyCode::Right, KeyEventKind::Press));
        let Some(Wish::Hold(Some([x, y]))) = both else { panic!("{both:?}") };
        assert!((x - y).abs() < 1e-12 && x > 0.7 && f64::hypot(x, y) <= 1.0 + 1e-12);
        assert_eq!(keys.wish(key(KeyCode::Up, KeyEventKind::Repeat)), None);
        keys.wish(key(KeyCode::Up, KeyEventKind::Release));
        assert_eq!(keys.wish(key(KeyCode::Right, KeyEventKind::Release)), Some(Wish::Hold(None)));
    }

    #[test]
    fn a_lost_focus_lets_go_once() {
        let mut keys = Keys::new(true);
        keys.wish(key(KeyCode::Up, KeyEventKind::Press));
        assert_eq!((keys.let_go(), keys.let_go(), keys.held()), (Some(Wish::Hold(None)), None, None));
    }

    #[test]
    fn control_c_ends_and_c_alone_does_nothing() {
        let mut keys = Keys::new(true);
        let c = KeyCode::Char('c');
        assert_eq!(keys.wish(KeyEvent::new(c, KeyModifiers::CONTROL)), Some(Wish::Quit));
        assert_eq!(keys.wish(KeyEvent::new(c, KeyModifiers::NONE)), None);
    }

    #[test]
    fn a_held_space_toggles_once() {
        let mut keys = Keys::new(true);
        let space = KeyCode::Char(' ');
        assert_eq!(keys.wish(key(space, KeyEventKind::Press)), Some(Wish::TogglePause));
        assert_eq!(keys.wish(key(space, KeyEventKind::Repeat)), None);
        assert_eq!(keys.wish(key(space, KeyEventKind::Release)), None);
    }
}
