//! What comes next for a ball, and the one total order of ties: time, kind, smaller id, larger id.

use super::time::Time;

/// What comes next for a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Next {
    /// When.
    pub time: Time,
    /// What.
    pub what: What,
}

/// What can come next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// A hit with another ball; void if that ball's stamp has changed.
    Ball {
        /// Its id.
        other: u32,
        /// Its stamp when the hit was predicted.
        stamp: u32,
    },
    /// A hit with a wall.
    Wall {
        /// The wall's place in the scene.
        wall: u32,
    },
    /// The ball's window or arc ends.
    Renew,
}

impl Next {
    /// Nothing at all.
    pub const NEVER: Self = Self { time: Time::NEVER, what: What::Renew };

    /// Sorting key of this event of ball `id`.
    #[inline]
    pub fn key(&self, id: u32) -> (Time, u8, u32, u32) {
        match self.what {
            What::Ball { other, .. } => (self.time, 0, id.min(other), id.max(other)),
            What::Wall { wall } => (self.time, 1, id, wall),
            What::Renew => (self.time, 2, id, 0),
        }
    }
}
