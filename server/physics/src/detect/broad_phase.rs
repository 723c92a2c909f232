//! Whom a ball could meet within its window: grids of cells, one grid for each class of radii.
//!
//! A ball is filed under one cell of its class's grid, the cell of the middle of its swept bounds. Windows end
//! before a ball has travelled [`WINDOW_TRAVEL`] radii, so the bounds of every ball of a class reach no
//! farther than a fixed distance from its cell, and a search knows which cells to visit.

use crate::tolerance::WINDOW_TRAVEL;
use nalgebra::Vector3;

const NOBODY: u32 = u32::MAX;

/// Swept bounds of a ball over its window: low x, low y, high x, high y, m.
pub type Bounds = [f64; 4];

/// Cells of balls whose radii lie within a factor of two.
#[derive(Clone, Debug)]
struct Grid {
    origin: [f64; 2],
    cells: [usize; 2],
    inverse_size: f64,
    /// How far bounds reach from the middle, m.
    extent: f64,
    first: Vec<u32>,
}

/// All balls' bounds, filed.
#[derive(Clone, Debug)]
pub struct BroadPhase {
    grids: Vec<Grid>,
    class: Vec<u8>,
    cell: Vec<u32>,
    next: Vec<u32>,
    previous: Vec<u32>,
    bounds: Vec<Bounds>,
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
        let n = radii.len();
        Self {
            grids,
            class: radii.iter().map(|r| grid_of_class[usize::from(class_of(*r))]).collect(),
            cell: vec![NOBODY; n],
            next: vec![NOBODY; n],
            previous: vec![NOBODY; n],
            bounds: vec![[0.0; 4]; n],
        }
    }

    /// Files `ball` under new bounds.
    pub fn file(&mut self, ball: usize, bounds: Bounds) {
        self.bounds[ball] = bounds;
        let grid = &self.grids[usize::from(self.class[ball])];
        let middle = [0.5 * (bounds[0] + bounds[2]), 0.5 * (bounds[1] + bounds[3])];
        let [i, j] = [grid.index(0, middle[0]), grid.index(1, middle[1])];
        let cell = (j * grid.cells[0] + i) as u32;
        if self.cell[ball] == cell {
            return;
        }
        self.unlink(ball);
        let head = &mut self.grids[usize::from(self.class[ball])].first[cell as usize];
        self.next[ball] = *head;
        self.previous[ball] = NOBODY;
        if *head != NOBODY {
            self.previous[*head as usize] = ball as u32;
        }
        *head = ball as u32;
        self.cell[ball] = cell;
    }

    /// Bounds that `ball` is filed under.
    pub fn bounds_of(&self, ball: usize) -> &Bounds {
        &self.bounds[ball]
    }

    fn unlink(&mut self, ball: usize) {
        if self.cell[ball] == NOBODY {
            return;
        }
        let (next, previous) = (self.next[ball], self.previous[ball]);
        if next != NOBODY {
            self.previous[next as usize] = previous;
        }
        if previous == NOBODY {
            self.grids[usize::from(self.class[ball])].first[self.cell[ball] as usize] = next;
        } else {
            self.next[previous as usize] = next;
        }
    }

    /// Calls `visit` for every other ball whose bounds meet those of `ball`, in no particular order.
    pub fn neighbours(&self, ball: usize, mut visit: impl FnMut(usize)) {
        let mine = self.bounds[ball];
        for grid in &self.grids {
            let [i0, i1] = [grid.index(0, mine[0] - grid.extent), grid.index(0, mine[2] + grid.extent)];
            let [j0, j1] = [grid.index(1, mine[1] - grid.extent), grid.index(1, mine[3] + grid.extent)];
            for j in j0..=j1 {
                for first in &grid.first[j * grid.cells[0] + i0..=j * grid.cells[0] + i1] {
                    let mut other = *first;
                    while other != NOBODY {
                        let theirs = &self.bounds[other as usize];
                        let apart = theirs[0] > mine[2]
                            || mine[0] > theirs[2]
                            || theirs[1] > mine[3]
                            || mine[1] > theirs[3];
                        if !apart && other as usize != ball {
                            visit(other as usize);
                        }
                        other = self.next[other as usize];
                    }
                }
            }
        }
    }
}

impl Grid {
    fn new(count: usize, largest: f64, floor: Bounds) -> Self {
        let extent = (1.0 + WINDOW_TRAVEL) * largest;
        let span = [floor[2] - floor[0], floor[3] - floor[1]];
        // No more cells than a few for each ball, no smaller than two radii of the largest.
        let by_count = (span[0] * span[1] / (2.0 * count as f64 + 1.0)).sqrt();
        let size = by_count.max(2.0 * largest).max(1e-3 * span[0].max(span[1]) / 4.0);
        let cells = span.map(|s| ((s / size).ceil() as usize).clamp(1, 4096));
        Self {
            origin: [floor[0], floor[1]],
            cells,
            inverse_size: 1.0 / size,
            extent,
            first: vec![NOBODY; cells[0] * cells[1]],
        }
    }

    #[inline]
    fn index(&self, axis: usize, x: f64) -> usize {
        // Casting saturates: what lies outside is filed in the border cells.
        let cell = ((x - self.origin[axis]) * self.inverse_size) as usize;
        cell.min(self.cells[axis] - 1)
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

    #[test]
    fn neighbours_are_those_of_a_search_over_all_pairs() {
        let mut seed = 7_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let radii: Vec<f64> =
            (0..300).map(|i| if i % 50 == 0 { 0.5 } else { 0.002 + 0.03 * random() }).collect();
        let mut phase = BroadPhase::new(&radii, [-2.0, -1.0, 2.0, 1.0]);
        let mut bounds = vec![[0.0; 4]; radii.len()];
        for round in 0..5 {
            for (i, r) in radii.iter().enumerate() {
                let c = Vector3::new(4.4 * random() - 2.2, 2.2 * random() - 1.1, 0.0);
                let v = Vector3::new(random() - 0.5, random() - 0.5, 0.0);
                bounds[i] = swept_bounds(&c, &v, 0.0, *r, WINDOW_TRAVEL * r / v.norm());
                phase.file(i, bounds[i]);
            }
            for i in (0..radii.len()).step_by(7) {
                let mut found = Vec::new();
                phase.neighbours(i, |j| found.push(j));
                found.sort_unstable();
                let meet =
                    |a: &Bounds, b: &Bounds| a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3];
                let want: Vec<usize> =
                    (0..radii.len()).filter(|j| *j != i && meet(&bounds[i], &bounds[*j])).collect();
                assert_eq!(found, want, "round {round}, ball {i}");
            }
        }
    }
}
