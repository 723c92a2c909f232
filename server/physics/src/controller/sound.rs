//! Whether a run that came from outside can be one that the engine made: words that fit together may still tell of balls
//! inside each other, or keep a hit that is near from being seen.

use super::Controller;
use crate::schedule::event::{Next, What};
use crate::schedule::time::Time;

/// Overlap that a run of the engine never reaches, in radii.
const DEEPEST: f64 = 1e-6;
/// How much earlier than the events that are due a hit may be found, s.
const EARLY: f64 = 1e-6;

impl Controller {
    /// Whether no ball is in another or in a wall, every ball is filed where it is, and no hit comes before the events
    /// that are due. It looks at every pair of neighbours, which takes as long as loading does.
    pub fn is_sound(&self) -> bool {
        let mut fresh = self.clone();
        if self.shards.is_some() {
            fresh.undivide();
            return fresh.is_sound();
        }
        fresh.now = self.now.max(self.time);
        (0..self.balls.len()).all(|ball| self.is_clear(ball))
            && (0..self.balls.len()).all(|ball| {
                fresh.predict(ball, fresh.now);
                self.expects(ball, fresh.queue.of(ball))
            })
    }

    /// Whether a ball is where it is filed, in no wall and in no neighbour.
    fn is_clear(&self, ball: usize) -> bool {
        let present = self.now.max(self.time);
        let center = |ball: usize, time: Time| {
            let arc = &self.arcs[ball];
            arc.center_at(time.since(arc.start).max(0.0))
        };
        let (r, here) = (self.balls[ball].body.radius, center(ball, present));
        let room = DEEPEST * r;
        let [x0, y0, x1, y1] = *self.broad_phase.bounds_of(ball);
        let filed = [here, center(ball, present.max(self.arcs[ball].window_end))].iter().all(|c| {
            x0 - room <= c.x - r && y0 - room <= c.y - r && c.x + r <= x1 + room && c.y + r <= y1 + room
        });
        let mut clear = filed && self.walls.iter().all(|plane| plane.distance(&here) - r >= -room);
        self.broad_phase.neighbours(ball, |other| {
            let reach = r + self.balls[other].body.radius;
            clear &= (center(other, present) - here).norm() - reach >= -DEEPEST * reach;
        });
        clear
    }

    /// Whether something is due before a ball meets what it is found to meet, so that the engine looks again in time.
    fn expects(&self, ball: usize, found: &Next) -> bool {
        let due = |ball: usize| self.queue.of(ball).time;
        let first = match found.what {
            What::Ball { other, .. } => due(ball).min(due(other as usize)),
            What::Wall { .. } => due(ball),
            What::Renew => return true,
        };
        first <= found.time.after(EARLY)
    }
}
