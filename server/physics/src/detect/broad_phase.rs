//! Whom a ball could meet within its window: grids of cells, one grid for each class of radii.
//!
//! A ball is filed under one cell of its class's grid, the cell of the middle of its swept bounds. Windows end
//! before a ball has travelled farther than [`travel`], so the bounds of every ball of a class reach no farther than a
//! fixed distance from its cell, and a search knows which cells to visit. The grid's plane is rolled up to a torus of a
//! few cells a ball: memory goes with the balls, cells with their radii, and neither with the size of the floor.

#![expect(clippy::needless_bitwise_bool, reason = "what cannot be foretold is computed, not jumped over")]

use crate::number::of_few_bits;
use crate::tolerance::{
    GRID_CELL_RADII, GRID_CELLS_PER_BALL, WINDOW_BITS, WINDOW_FLOOR_SHARE, WINDOW_MAX, WINDOW_MIN,
    WINDOW_TRAVEL,
};
use nalgebra::Vector3;
use prefetch_index::prefetch_index;

/// Most balls that a search looks at together: several times what a search in a crowd finds.
const BATCH: usize = 64;
/// What a grid's reach grows by beyond what is filed: rounding, and fewer times that it grows.
const REACH_SPARE: f64 = 1.0625;
const NOBODY: u32 = u32::MAX;
/// The cell of a ball whose bounds are wider than its class allows: everybody looks there.
const WIDE: u32 = u32::MAX - 1;

/// Swept bounds of a ball over its window: low x, low y, high x, high y, m.
pub type Bounds = [f64; 4];

/// How far a ball of `radius` may travel within a window, m, on a floor whose longer side is `span` m. It depends on the
/// ball and the floor alone: a ball that nobody meets cannot change another's windows.
pub fn travel(radius: f64, span: f64) -> f64 {
    (WINDOW_TRAVEL * radius).max(WINDOW_FLOOR_SHARE * span)
}

/// Length of the window of a ball of `speed` that may `travel` so far, s; its acceleration is at most `acceleration`.
#[inline]
pub fn window(travel: f64, speed: f64, acceleration: f64) -> f64 {
    of_few_bits(time_of(travel, speed, acceleration), WINDOW_BITS).clamp(WINDOW_MIN, WINDOW_MAX)
}

/// Seconds in which a ball surely travels no farther; without end for one that stays where it is.
#[inline]
fn time_of(travel: f64, speed: f64, acceleration: f64) -> f64 {
    if acceleration == 0.0 {
        return travel / speed;
    }
    2.0 * travel / (speed + (speed * speed + 2.0 * acceleration * travel).sqrt())
}

/// Cells of balls whose radii lie within a factor of two.
#[derive(Clone, Debug)]
struct Grid {
    origin: [f64; 2],
    /// Cells along x and y: powers of two.
    cells: [i64; 2],
    inverse_size: f64,
    /// How far bounds may reach from their middle, m, and how far those filed so far do, or a little farther.
    extent: f64,
    reach: f64,
    first: Vec<u32>,
}

/// All balls' bounds, filed.
#[derive(Clone, Debug)]
pub struct BroadPhase {
    grids: Vec<Grid>,
    wide: u32,
    /// The next ball in the list of each one's cell.
    next: Vec<u32>,
    filed: Vec<Filed>,
}

/// A ball's bounds and where it is filed, in a line of cache.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Filed {
    bounds: Bounds,
    previous: u32,
    cell: u32,
    class: u8,
}

impl BroadPhase {
    /// Grids for balls of `radii` over the rectangle `floor` (bounds in x and y).
    pub fn new(radii: &[f64], floor: Bounds) -> Self {
        let smallest = radii.iter().copied().fold(f64::INFINITY, f64::min);
        let class_of = |r: f64| {
            let mut class = 0_u8;
            let mut limit = 2.0 * smallest;
            while r >= limit && class < 63 {
                limit *= 2.0;
                class += 1;
            }
            class
        };
        let mut occupied = [(0_usize, 0.0_f64); 64];
        for r in radii {
            let entry = &mut occupied[usize::from(class_of(*r))];
            entry.0 += 1;
            entry.1 = entry.1.max(*r);
        }
        let mut grid_of_class = [0_u8; 64];
        let mut grids = Vec::new();
        for (class, (count, largest)) in occupied.iter().enumerate() {
            if *count > 0 {
                grid_of_class[class] = grids.len() as u8;
                grids.push(Grid::new(*count, *largest, floor));
            }
        }
        let filed = |r: &f64| {
            let class = grid_of_class[usize::from(class_of(*r))];
            Filed { bounds: [0.0; 4], previous: NOBODY, cell: NOBODY, class }
        };
        let next = vec![NOBODY; radii.len()];
        Self { grids, wide: NOBODY, next, filed: radii.iter().map(filed).collect() }
    }

    /// Files `ball` under new bounds.
    pub fn file(&mut self, ball: usize, bounds: Bounds) {
        let lone = self.is_lone();
        let filed = &mut self.filed[ball];
        filed.bounds = bounds;
        if lone {
            return;
        }
        let cell = self.grids[usize::from(filed.class)].take_in(&bounds);
        if filed.cell != cell {
            self.move_to(ball, cell);
        }
    }

    fn move_to(&mut self, ball: usize, cell: u32) {
        self.unlink(ball);
        let head = self.head(ball, cell);
        let second = std::mem::replace(head, ball as u32);
        self.next[ball] = second;
        let filed = &mut self.filed[ball];
        (filed.previous, filed.cell) = (NOBODY, cell);
        if second != NOBODY {
            self.filed[second as usize].previous = ball as u32;
        }
    }

    /// Takes `ball` out: nobody finds it until it is filed again.
    pub fn remove(&mut self, ball: usize) {
        self.unlink(ball);
        self.filed[ball].cell = NOBODY;
    }

    /// Bounds that `ball` is filed under.
    #[inline]
    pub fn bounds_of(&self, ball: usize) -> &Bounds {
        &self.filed[ball].bounds
    }

    /// Whether there is nobody to be found.
    const fn is_lone(&self) -> bool {
        self.filed.len() == 1
    }

    /// The first ball of a cell in the grid of `ball`.
    fn head(&mut self, ball: usize, cell: u32) -> &mut u32 {
        if cell == WIDE {
            return &mut self.wide;
        }
        &mut self.grids[usize::from(self.filed[ball].class)].first[cell as usize]
    }

    fn unlink(&mut self, ball: usize) {
        let next = self.next[ball];
        let Filed { previous, cell, .. } = self.filed[ball];
        if cell == NOBODY {
            return;
        }
        if next != NOBODY {
            self.filed[next as usize].previous = previous;
        }
        if previous == NOBODY {
            *self.head(ball, cell) = next;
        } else {
            self.next[previous as usize] = next;
        }
    }

    /// Asks memory for what is filed of a ball.
    #[inline]
    pub fn prefetch(&self, ball: usize) {
        prefetch_index(&self.filed, ball);
        prefetch_index(&self.next, ball);
    }

    /// Asks memory for the cells around `bounds` among balls of the class of `ball`.
    pub fn prefetch_cells(&self, ball: usize, bounds: &Bounds) {
        self.cells_around(ball, bounds, |cells| {
            prefetch_index(cells, 0);
            prefetch_index(cells, cells.len() - 1);
        });
    }

    /// Asks memory for what is filed of the first ball of each of those cells.
    pub fn prefetch_firsts(&self, ball: usize, bounds: &Bounds) {
        self.cells_around(ball, bounds, |cells| {
            for first in cells {
                // An address that there is not would be looked for in vain.
                self.prefetch(if *first == NOBODY { ball } else { *first as usize });
            }
        });
    }

    fn cells_around(&self, ball: usize, bounds: &Bounds, mut visit: impl FnMut(&[u32])) {
        let grid = &self.grids[usize::from(self.filed[ball].class)];
        let (columns, [j0, j1]) = grid.around(bounds);
        for j in j0..=j1 {
            grid.row(j, columns).into_iter().filter(|cells| !cells.is_empty()).for_each(&mut visit);
        }
    }

    /// Calls `visit` for every other ball whose bounds meet those of `ball`, in no particular order.
    #[inline]
    pub fn neighbours(&self, ball: usize, visit: impl FnMut(usize)) {
        self.neighbours_asked_for(ball, |_| {}, visit);
    }

    /// The same, and `ask` is told of some of them before the first of these is visited.
    #[inline]
    pub fn neighbours_asked_for(&self, ball: usize, ask: impl Fn(usize), mut visit: impl FnMut(usize)) {
        if self.is_lone() {
            return;
        }
        let mine = self.filed[ball].bounds;
        let mut batch = Batch { balls: [NOBODY; BATCH], count: 0 };
        for grid in &self.grids {
            let (columns, [j0, j1]) = grid.around(&mine);
            for j in j0..=j1 {
                for cells in grid.row(j, columns) {
                    for some in cells.chunks(BATCH / 4) {
                        if batch.count + some.len() > BATCH / 2 {
                            self.visit_batch(&mut batch, (ball, &mine), &ask, &mut visit);
                        }
                        batch.add_all(some);
                    }
                }
            }
        }
        batch.add_all(&[self.wide]);
        self.visit_batch(&mut batch, (ball, &mine), &ask, &mut visit);
    }

    /// Those of some lists whose bounds meet those of `ball`; the lists' first are in the batch. Which lists go on and which
    /// bounds meet cannot be foretold: nothing is jumped over, and memory is asked for many of them at once.
    #[inline]
    fn visit_batch(
        &self,
        batch: &mut Batch,
        (ball, mine): (usize, &Bounds),
        ask: &impl Fn(usize),
        visit: &mut impl FnMut(usize),
    ) {
        while batch.count > 0 {
            let followed = batch.follow(&self.next);
            let mut met = 0;
            for place in 0..followed {
                let other = batch.balls[place];
                batch.balls[met] = other;
                let meets = meet(mine, &self.filed[other as usize].bounds) & (other as usize != ball);
                met += usize::from(meets);
            }
            batch.balls[..met].iter().for_each(|other| ask(*other as usize));
            batch.balls[..met].iter().for_each(|other| visit(*other as usize));
            if followed < batch.count {
                batch.balls.copy_within(followed..batch.count, 0);
            }
            batch.count -= followed;
        }
    }
}

/// Balls that a search looks at together.
struct Batch {
    balls: [u32; BATCH],
    count: usize,
}

impl Batch {
    /// Adds those that there are.
    #[inline]
    fn add_all(&mut self, some: &[u32]) {
        let mut count = self.count;
        for ball in some {
            self.balls[count] = *ball;
            count += usize::from(*ball != NOBODY);
        }
        self.count = count;
    }

    /// Adds those that come `next`, as long as there is room; returns how many have been followed.
    #[inline]
    fn follow(&mut self, next: &[u32]) -> usize {
        let (mut followed, mut count) = (0, self.count);
        while followed < count && count < BATCH {
            let ball = next[self.balls[followed] as usize];
            self.balls[count] = ball;
            count += usize::from(ball != NOBODY);
            followed += 1;
        }
        self.count = count;
        followed
    }
}

/// Whether bounds lie inside of others.
#[inline]
pub fn is_within(bounds: &Bounds, room: &Bounds) -> bool {
    (room[0] < bounds[0]) & (room[1] < bounds[1]) & (bounds[2] < room[2]) & (bounds[3] < room[3])
}

/// Whether two bounds share a point. Most do not, and on which side cannot be foretold: nothing is jumped over.
#[inline]
fn meet(a: &Bounds, b: &Bounds) -> bool {
    (a[0] <= b[2]) & (b[0] <= a[2]) & (a[1] <= b[3]) & (b[1] <= a[3])
}

impl Grid {
    fn new(count: usize, largest: f64, floor: Bounds) -> Self {
        let span = [floor[2] - floor[0], floor[3] - floor[1]];
        let extent = largest + travel(largest, span[0].max(span[1]));
        // A cell a ball or so where they are spread, and never so fine or coarse that a search visits many cells or balls.
        let spread = (span[0] * span[1] / (2.0 * count as f64 + 1.0)).sqrt();
        let [fine, coarse] = GRID_CELL_RADII.map(|radii| radii * extent);
        let size = spread.clamp(fine, coarse);
        let most = (GRID_CELLS_PER_BALL * count).next_power_of_two() as f64;
        let needed = span.map(|s| (s / size).ceil().max(1.0));
        let columns = needed[0].min((most * needed[0] / needed[1]).sqrt().clamp(1.0, most));
        let rows = needed[1].min(most / columns);
        let cells = [columns, rows].map(|x| (x as i64).max(1).unsigned_abs().next_power_of_two());
        Self {
            origin: [floor[0], floor[1]],
            cells: cells.map(u64::cast_signed),
            inverse_size: 1.0 / size,
            extent,
            reach: 0.0,
            first: vec![NOBODY; (cells[0] * cells[1]) as usize],
        }
    }

    /// Number of the column or row at x or y, before the plane is rolled up: it never falls as x rises. Those that are
    /// farthest off count as one.
    #[inline]
    fn index(&self, axis: usize, x: f64) -> i64 {
        const FARTHEST: f64 = (1_i64 << 40) as f64;
        /// Where a float has no room for fractions: its last bits count.
        const INTEGERS: f64 = 1.5 * (1_i64 << (f64::MANTISSA_DIGITS - 1)) as f64;
        let place = (x - self.origin[axis]) * self.inverse_size;
        (place.clamp(-FARTHEST, FARTHEST) + INTEGERS).to_bits().cast_signed()
            - INTEGERS.to_bits().cast_signed()
    }

    /// First and last column and row where a search within `bounds` looks.
    #[inline]
    fn around(&self, bounds: &Bounds) -> ([usize; 2], [i64; 2]) {
        let [i0, i1] = self.span(0, bounds);
        let column = |i: i64| (i & (self.cells[0] - 1)) as usize;
        ([column(i0), column(i1)], self.span(1, bounds))
    }

    /// The same along one axis, before the plane is rolled up.
    #[inline(always)]
    fn span(&self, axis: usize, bounds: &Bounds) -> [i64; 2] {
        let low = self.index(axis, bounds[axis] - self.reach);
        let high = self.index(axis, bounds[axis + 2] + self.reach);
        // Once around the torus is everywhere.
        [low, high.min(low.saturating_add(self.cells[axis] - 1))]
    }

    /// Cells of row `j` from one column to another, around the torus if that comes before: up to two runs.
    #[inline]
    fn row(&self, j: i64, [low, high]: [usize; 2]) -> [&[u32]; 2] {
        let from = ((j & (self.cells[1] - 1)) * self.cells[0]) as usize;
        let row = &self.first[from..from + self.cells[0] as usize];
        if low <= high { [&row[low..=high], &[]] } else { [&row[low..], &row[..=high]] }
    }

    /// The cell of bounds, which searches find there from now on.
    fn take_in(&mut self, bounds: &Bounds) -> u32 {
        let half = [0.5 * (bounds[2] - bounds[0]), 0.5 * (bounds[3] - bounds[1])];
        if !(half[0] <= self.reach && half[1] <= self.reach) {
            // A NaN is wide too.
            if !(half[0] <= self.extent && half[1] <= self.extent) {
                return WIDE;
            }
            self.reach = (REACH_SPARE * half[0].max(half[1])).min(self.extent);
        }
        let [i, j] = [0, 1]
            .map(|axis| self.index(axis, 0.5 * (bounds[axis] + bounds[axis + 2])) & (self.cells[axis] - 1));
        (j * self.cells[0] + i) as u32
    }
}

/// Bounds of a ball that moves from `center` with `velocity` for `duration`, its acceleration at most
/// `acceleration`.
pub fn swept_bounds(
    center: &Vector3<f64>,
    velocity: &Vector3<f64>,
    acceleration: f64,
    radius: f64,
    duration: f64,
) -> Bounds {
    let end = center + velocity * duration;
    let margin = radius + 0.5 * acceleration * duration * duration;
    [
        center.x.min(end.x) - margin,
        center.y.min(end.y) - margin,
        center.x.max(end.x) + margin,
        center.y.max(end.y) + margin,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Files `radii` at random places of a floor again and again, and compares with a search over all pairs.
    fn assert_all_found(radii: &[f64], floor: Bounds, crowd: f64, fastest: f64, seed: u64) -> usize {
        let mut seed = seed;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut phase = BroadPhase::new(radii, floor);
        let [wide, deep] = [floor[2] - floor[0], floor[3] - floor[1]];
        let mut bounds = vec![[0.0; 4]; radii.len()];
        let mut meetings = 0;
        for round in 0..5 {
            for (i, r) in radii.iter().enumerate() {
                // Some stand outside.
                let [x, y] = [random() * 1.1 - 0.05, random() * 1.1 - 0.05].map(|x| x * crowd);
                let c = Vector3::new(floor[0] + wide * x, floor[1] + deep * y, 0.0);
                let v = Vector3::new(random() - 0.5, random() - 0.5, 0.0);
                let far = travel(*r, wide.max(deep)) * if i % 100 == 0 { fastest } else { 1.0 };
                bounds[i] = swept_bounds(&c, &v, 0.0, *r, far / v.norm());
                phase.file(i, bounds[i]);
            }
            for i in 0..radii.len() {
                let mut found = Vec::new();
                phase.neighbours(i, |j| found.push(j));
                found.sort_unstable();
                let want: Vec<usize> =
                    (0..radii.len()).filter(|j| *j != i && meet(&bounds[i], &bounds[*j])).collect();
                assert_eq!(found, want, "round {round}, ball {i}");
                meetings += found.len();
            }
        }
        meetings
    }

    #[test]
    fn neighbours_are_those_of_a_search_over_all_pairs() {
        let hall = [-2.0, -1.0, 2.0, 1.0];
        let spread = |least: f64, most: f64, count: usize| -> Vec<f64> {
            // Even in the logarithm.
            (0..count).map(|i| least * (most / least).powf((i * 7 % count) as f64 / count as f64)).collect()
        };
        for (seed, count) in [(1, 1), (2, 2), (3, 10), (4, 100), (5, 1000)] {
            let met = assert_all_found(&spread(0.03, 0.03, count), hall, 1.0, 1.0, seed);
            assert!(met > 0 || count < 100);
            // 1000 : 1 in one room.
            assert_all_found(&spread(0.001, 1.0, count), hall, 1.0, 1.0, seed + 10);
            // A crowd in a corner of a vast floor, and a long thin one.
            assert_all_found(&spread(0.02, 0.05, count), [0.0, 0.0, 1e4, 1e4], 1e-4, 1.0, seed + 20);
            assert_all_found(&spread(0.02, 0.05, count), [-500.0, 0.0, 500.0, 0.2], 0.05, 1.0, seed + 30);
            // Bounds wider than any window should be.
            assert_all_found(&spread(0.001, 0.01, count), hall, 1.0, 300.0, seed + 40);
        }
    }

    #[test]
    fn a_search_looks_at_few_whatever_the_floor() {
        // 4 000 balls in a corner of a floor a thousand times as wide: lists stay as short as on a floor of their own.
        let radii = vec![0.05; 4000];
        let longest = |floor: f64| {
            let mut phase = BroadPhase::new(&radii, [0.0, 0.0, floor, floor]);
            for i in 0..radii.len() {
                let (x, y) = ((i % 64) as f64 * 0.2, (i / 64) as f64 * 0.2);
                phase.file(i, [x - 0.05, y - 0.05, x + 0.05, y + 0.05]);
            }
            let length = |first: &u32| {
                let (mut length, mut ball) = (0, *first);
                while ball != NOBODY {
                    (length, ball) = (length + 1, phase.next[ball as usize]);
                }
                length
            };
            phase.grids[0].first.iter().map(length).max().unwrap_or(0)
        };
        assert!(longest(12.8) <= 4 && longest(12_800.0) <= 16, "{} {}", longest(12.8), longest(12_800.0));
    }

    proptest! {
        #[test]
        fn a_window_is_nearly_as_long_as_the_travel_allows_and_no_longer(
            travel in 1e-3..10.0_f64, speed in 1e-3..1e3_f64, acceleration in prop_oneof![Just(0.0), 1e-3..1e3_f64],
        ) {
            let length = of_few_bits(time_of(travel, speed, acceleration), WINDOW_BITS);
            let far = |t: f64| t * (speed + 0.5 * acceleration * t);
            prop_assert!(far(length) <= travel * (1.0 + 4.0 * f64::EPSILON), "{}", far(length) / travel);
            prop_assert!(far(length * 1.126) > travel, "{}", far(length) / travel);
        }
    }

    #[test]
    fn one_that_stays_where_it_is_looks_ahead_as_far_as_any() {
        let length = |speed: f64| window(0.1, speed, 0.0);
        assert_eq!([length(0.0), length(1e-9)], [WINDOW_MAX; 2]);
        assert_eq!(length(1e15), WINDOW_MIN);
    }
}
