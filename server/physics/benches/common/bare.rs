//! The least that a flat gas can be: equal discs in a square box, and nothing else that an engine has.
//!
//! A disc is a place, a velocity, the time they belong to and a count of its hits; cells hold lists of discs, a heap holds events,
//! and one whose discs have hit since is thrown away when its turn comes (the textbook's event-driven hard discs: B. J. Alder
//! and T. E. Wainwright, J. Chem. Phys. 31, 1959, with cells). No radii of several sizes, no masses, no third dimension, no
//! checks, no states that can be saved, shown or changed: what our engine costs beyond it is what those cost.

use ballroom_cases::gas;
use ballroom_physics::{Place, Scene};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

const NOBODY: u32 = u32::MAX;
/// Twice the radius, m.
const REACH: f64 = 2.0 * gas::RADIUS;

/// A box of discs.
#[derive(Clone)]
pub struct Bare {
    discs: Vec<Disc>,
    /// The first disc in each cell, row by row.
    first: Vec<u32>,
    cells: i32,
    /// Sides of the box and of a cell, m.
    side: f64,
    size: f64,
    heap: BinaryHeap<Event>,
    now: f64,
    /// Hits so far, with walls too.
    pub hits: u64,
}

#[derive(Clone)]
struct Disc {
    place: [f64; 2],
    velocity: [f64; 2],
    time: f64,
    count: u32,
    cell: [i32; 2],
    previous: u32,
    next: u32,
}

#[derive(Clone, Copy)]
enum What {
    Disc { other: u32, count: u32 },
    Wall { axis: usize },
    Cell { axis: usize, step: i32 },
}

#[derive(Clone)]
struct Event {
    time: f64,
    disc: u32,
    count: u32,
    what: What,
}

/// The earliest is the greatest: a heap gives its greatest first.
impl Ord for Event {
    fn cmp(&self, other: &Self) -> Ordering {
        other.time.total_cmp(&self.time)
    }
}
impl PartialOrd for Event {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Event {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Event {}

impl Bare {
    /// The balls of a gas on a plane.
    pub fn of(scene: &Scene) -> Self {
        let side = gas::area(scene.balls.len()).sqrt();
        let cells = (side / (1.0001 * REACH)) as i32;
        let disc = |ball: &ballroom_physics::BallSpec| {
            let Place::Center(at) = ball.place else {
                unreachable!("a gas places its balls by their centres")
            };
            Disc {
                place: [at.x + 0.5 * side, at.y + 0.5 * side],
                velocity: [ball.velocity.x, ball.velocity.y],
                time: 0.0,
                count: 0,
                cell: [0; 2],
                previous: NOBODY,
                next: NOBODY,
            }
        };
        let mut bare = Self {
            discs: scene.balls.iter().map(disc).collect(),
            first: vec![NOBODY; (cells * cells) as usize],
            cells,
            side,
            size: side / f64::from(cells),
            heap: BinaryHeap::new(),
            now: 0.0,
            hits: 0,
        };
        let all = 0..bare.discs.len() as u32;
        for disc in all.clone() {
            let place = bare.discs[disc as usize].place;
            bare.enter(disc, place.map(|x| ((x / bare.size) as i32).min(cells - 1)));
        }
        for disc in all {
            bare.predict(disc, [-1..=1, -1..=1]);
        }
        bare
    }

    /// Twice the kinetic energy of discs of unit mass, J.
    pub fn energy(&self) -> f64 {
        self.discs.iter().map(|disc| disc.velocity.iter().map(|v| v * v).sum::<f64>()).sum()
    }

    /// Every event up to `time`, s.
    pub fn advance_to(&mut self, time: f64) {
        while self.heap.peek().is_some_and(|event| event.time <= time) {
            let Some(Event { time, disc, count, what }) = self.heap.pop() else { break };
            if count != self.discs[disc as usize].count {
                continue;
            }
            match what {
                What::Disc { other, count } if count != self.discs[other as usize].count => {}
                What::Disc { other, .. } => {
                    self.now = time;
                    self.hit(disc as usize, other as usize);
                    self.predict(disc, [-1..=1, -1..=1]);
                    self.predict(other, [-1..=1, -1..=1]);
                }
                What::Wall { axis } => {
                    self.now = time;
                    self.hits += 1;
                    let disc_at = self.bring(disc as usize);
                    disc_at.velocity[axis] = -disc_at.velocity[axis];
                    disc_at.count += 1;
                    self.predict(disc, [-1..=1, -1..=1]);
                }
                What::Cell { axis, step } => {
                    self.now = time;
                    self.cross(disc, axis, step);
                }
            }
        }
    }

    /// The disc where it is now.
    fn bring(&mut self, disc: usize) -> &mut Disc {
        let now = self.now;
        let disc = &mut self.discs[disc];
        let dt = now - disc.time;
        for axis in 0..2 {
            disc.place[axis] += disc.velocity[axis] * dt;
        }
        disc.time = now;
        disc
    }

    fn hit(&mut self, a: usize, b: usize) {
        self.hits += 1;
        let (from, v) = (self.bring(a).place, self.discs[a].velocity);
        let (to, w) = (self.bring(b).place, self.discs[b].velocity);
        let apart = [to[0] - from[0], to[1] - from[1]];
        let closing = apart[0] * (w[0] - v[0]) + apart[1] * (w[1] - v[1]);
        let share = closing / (apart[0] * apart[0] + apart[1] * apart[1]);
        for axis in 0..2 {
            self.discs[a].velocity[axis] += share * apart[axis];
            self.discs[b].velocity[axis] -= share * apart[axis];
        }
        self.discs[a].count += 1;
        self.discs[b].count += 1;
    }

    fn list(&mut self, cell: [i32; 2]) -> &mut u32 {
        &mut self.first[(cell[1] * self.cells + cell[0]) as usize]
    }

    fn enter(&mut self, disc: u32, cell: [i32; 2]) {
        let next = std::mem::replace(self.list(cell), disc);
        let at = &mut self.discs[disc as usize];
        (at.cell, at.previous, at.next) = (cell, NOBODY, next);
        if next != NOBODY {
            self.discs[next as usize].previous = disc;
        }
    }

    fn cross(&mut self, disc: u32, axis: usize, step: i32) {
        let Disc { mut cell, previous, next, .. } = *self.bring(disc as usize);
        match previous {
            NOBODY => *self.list(cell) = next,
            previous => self.discs[previous as usize].next = next,
        }
        if next != NOBODY {
            self.discs[next as usize].previous = previous;
        }
        cell[axis] += step;
        self.enter(disc, cell);
        // Only the row of cells that it comes near is new.
        let mut near = [-1..=1, -1..=1];
        near[axis] = step..=step;
        self.predict(disc, near);
    }

    /// The next wall or cell of a disc, and its hits with those in cells around its own.
    fn predict(&mut self, disc: u32, near: [std::ops::RangeInclusive<i32>; 2]) {
        let Self { discs, heap, .. } = self;
        let Disc { place, velocity, count, cell, time, .. } = discs[disc as usize];
        let (mut after, mut what) = (f64::INFINITY, What::Wall { axis: 0 });
        let mut consider = |dt: f64, event: What| {
            if dt < after {
                (after, what) = (dt, event);
            }
        };
        for axis in 0..2 {
            let (x, v, i) = (place[axis], velocity[axis], cell[axis]);
            let step = if v > 0.0 { 1 } else { -1 };
            let wall = if v > 0.0 { self.side - 0.5 * REACH } else { 0.5 * REACH };
            let edge = f64::from(i + i32::from(v > 0.0)) * self.size;
            if v != 0.0 {
                consider((wall - x) / v, What::Wall { axis });
                if (0..self.cells).contains(&(i + step)) {
                    consider((edge - x) / v, What::Cell { axis, step });
                }
            }
        }
        heap.push(Event { time: time + after.max(0.0), disc, count, what });
        let [columns, rows] = near;
        for row in rows {
            for column in columns.clone() {
                let at = [cell[0] + column, cell[1] + row];
                if at.iter().any(|i| !(0..self.cells).contains(i)) {
                    continue;
                }
                let mut other = self.first[(at[1] * self.cells + at[0]) as usize];
                while other != NOBODY {
                    let them = &discs[other as usize];
                    if other != disc
                        && let Some(dt) = meeting((place, velocity), them, time)
                    {
                        let what = What::Disc { other, count: them.count };
                        heap.push(Event { time: time + dt, disc, count, what });
                    }
                    other = them.next;
                }
            }
        }
    }
}

/// Seconds after `now` until a disc meets another.
fn meeting((place, velocity): ([f64; 2], [f64; 2]), them: &Disc, now: f64) -> Option<f64> {
    let dt = now - them.time;
    let [mut apart, mut relative] = [[0.0; 2]; 2];
    for axis in 0..2 {
        relative[axis] = them.velocity[axis] - velocity[axis];
        apart[axis] = them.place[axis] + them.velocity[axis] * dt - place[axis];
    }
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let closing = -dot(apart, relative);
    let gap = dot(apart, apart) - REACH * REACH;
    let discriminant = closing * closing - dot(relative, relative) * gap;
    (closing > 0.0 && discriminant >= 0.0).then(|| gap.max(0.0) / (closing + discriminant.sqrt()))
}
