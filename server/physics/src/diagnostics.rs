//! What an advance reports.

use crate::schedule::time::Time;
use nalgebra::Vector3;

/// Counts of hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Collisions {
    /// Between two balls.
    pub ball_ball: u64,
    /// Between a ball and a wall.
    pub ball_wall: u64,
}

/// Whom a ball hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HitPartner {
    /// A ball, by id.
    Ball(usize),
    /// A wall, by its place in the scene.
    Wall(usize),
}

/// One hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// When.
    pub time: Time,
    /// Id of the ball.
    pub ball: usize,
    /// Whom it hit.
    pub partner: HitPartner,
    /// Where they touched, m.
    pub point: Vector3<f64>,
    /// Size of the impulse, N s.
    pub impulse: f64,
}

/// What happened: in one advance, or summed since the controller was made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Hits.
    pub collisions: Collisions,
    /// Deepest overlap found at an impact, m.
    pub deepest_penetration: f64,
    /// Hits slower than the rest speed, taken without rebound.
    pub rest_hits: u64,
    /// Simultaneous impacts of more than one contact.
    pub clusters: u64,
    /// Times a ball was held for a quantum because hits piled up.
    pub fallbacks: u64,
    /// Ball-seconds during which the floor would have had to pull.
    pub negative_reaction: f64,
    /// Energy put in from outside, J: by pushes and held forces (of one still held, up to the present arc), and by setting
    /// balls anew, adding and removing them, and changing the floor or gravity under them.
    pub steering_work: f64,
    /// Integration steps, kept and thrown away.
    pub steps: u64,
    /// Searches for what a ball will meet within its window.
    pub searches: u64,
    /// Pairs looked at, and pairs whose distance polynomial was formed.
    pub pairs: [u64; 2],
    /// Hits left out of the list because it was full.
    pub hits_dropped: u64,
}

impl Report {
    /// Adds what can be added in any order: counts, and the deepest penetration. Sums whose bits depend on the order of their
    /// addends stay.
    pub(crate) fn add_counts(&mut self, other: &Self) {
        self.collisions.ball_ball += other.collisions.ball_ball;
        self.collisions.ball_wall += other.collisions.ball_wall;
        self.deepest_penetration = self.deepest_penetration.max(other.deepest_penetration);
        self.rest_hits += other.rest_hits;
        self.clusters += other.clusters;
        self.fallbacks += other.fallbacks;
        self.steps += other.steps;
        self.searches += other.searches;
        self.pairs[0] += other.pairs[0];
        self.pairs[1] += other.pairs[1];
        self.hits_dropped += other.hits_dropped;
    }

    /// What happened when nothing did: see [`Self::since`].
    pub(crate) fn of_nothing(&self) -> Self {
        Self { deepest_penetration: self.deepest_penetration, ..Self::default() }
    }

    /// What happened since `before`, a report of the same controller. The deepest penetration stays that of the
    /// whole run.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        Self {
            collisions: Collisions {
                ball_ball: self.collisions.ball_ball - before.collisions.ball_ball,
                ball_wall: self.collisions.ball_wall - before.collisions.ball_wall,
            },
            deepest_penetration: self.deepest_penetration,
            rest_hits: self.rest_hits - before.rest_hits,
            clusters: self.clusters - before.clusters,
            fallbacks: self.fallbacks - before.fallbacks,
            negative_reaction: self.negative_reaction - before.negative_reaction,
            steering_work: self.steering_work - before.steering_work,
            steps: self.steps - before.steps,
            searches: self.searches - before.searches,
            pairs: [self.pairs[0] - before.pairs[0], self.pairs[1] - before.pairs[1]],
            hits_dropped: self.hits_dropped - before.hits_dropped,
        }
    }
}
