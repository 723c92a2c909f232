//! Hits that flash where they happened, larger for a larger impulse.

use crate::palette;
use crate::recording::Recording;
use protocol::event::Event;
use protocol::snapshot::{Roster, Snapshot};
use rerun::{LineStrips3D, Radius, RecordingStreamResult};
use std::collections::VecDeque;

/// Entity of the flashes.
pub const HITS: &str = "world/hits";

/// How long a hit is seen, simulated s.
const FLASH_S: f64 = 0.35;
/// Flashes at one time; further hits push the oldest out, they are counted in the plots all the same.
pub const MAX_FLASHES: usize = 256;
/// Strokes of a flash, through its middle: a star, which nobody takes for a ball.
const STROKES: [[f32; 3]; 4] = [[1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [-1.0, -1.0, 1.0]];
/// Width of a stroke, points of the screen.
const STROKE_POINTS: f32 = 1.5;
const YOUNG: [u8; 3] = [255, 250, 220];
const OLD: [u8; 3] = [255, 96, 32];

/// Hits of the last moments.
pub struct HitView {
    flashes: VecDeque<Flash>,
    /// Size of a flash of the reference impulse, m: the median radius.
    size_m: f64,
    /// Impulse of a hit that shows at that size, N s: the median mass at 1 m/s.
    reference_n_s: f64,
    shown: bool,
}

struct Flash {
    time_s: f64,
    point: [f32; 3],
    radius_m: f64,
}

impl HitView {
    /// Sizes flashes for balls of this roster.
    pub fn of(roster: &Roster) -> Self {
        let size_m = median(&roster.radius_m).unwrap_or(0.1);
        let reference_n_s = median(&roster.mass_kg).unwrap_or(1.0).max(f64::MIN_POSITIVE);
        Self { flashes: VecDeque::new(), size_m, reference_n_s, shown: false }
    }

    /// Takes a hit in.
    pub fn add(&mut self, hit: &Event) {
        // Logarithmic: a tick of the click and the hit of the evening are both seen, neither fills the view.
        let strength = (1.0 + hit.impulse_n_s / self.reference_n_s).ln().clamp(0.05, 3.0);
        let radius_m = self.size_m * (0.12 + 0.22 * strength);
        self.flashes.push_back(Flash { time_s: hit.time_s, point: hit.point_m.map(|x| x as f32), radius_m });
        if self.flashes.len() > MAX_FLASHES {
            self.flashes.pop_front();
        }
    }

    /// Forgets everything, and shows that.
    pub fn clear(&mut self, rec: &Recording) -> RecordingStreamResult<()> {
        self.flashes.clear();
        self.shown = false;
        rec.log(HITS, &LineStrips3D::new(Vec::<Vec<[f32; 3]>>::new()))
    }

    /// Logs the flashes of this moment; nothing while there are none.
    pub fn log_state(&mut self, rec: &Recording, state: &Snapshot) -> RecordingStreamResult<()> {
        self.flashes.retain(|flash| state.time_s - flash.time_s < FLASH_S);
        if self.flashes.is_empty() && !self.shown {
            return Ok(());
        }
        self.shown = !self.flashes.is_empty();
        // A hit may be heard of before the state that shows it: its age is then 0, not negative.
        let age = |flash: &Flash| ((state.time_s - flash.time_s) / FLASH_S).clamp(0.0, 1.0);
        let stars = self.flashes.iter().flat_map(|flash| {
            let reach = (flash.radius_m * (1.0 - age(flash)).sqrt()) as f32;
            STROKES.map(|stroke| {
                [-1.0, 1.0]
                    .map(|side| std::array::from_fn(|axis| flash.point[axis] + side * reach * stroke[axis]))
            })
        });
        let color = |flash: &Flash| palette::color(palette::between(YOUNG, OLD, age(flash)));
        let strokes = LineStrips3D::new(stars.map(|ends: [[f32; 3]; 2]| ends.to_vec()))
            .with_radii([Radius::new_ui_points(STROKE_POINTS)])
            .with_colors(self.flashes.iter().flat_map(|flash| [color(flash); STROKES.len()]));
        rec.log(HITS, &strokes)
    }
}

fn median(values: &[f64]) -> Option<f64> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use protocol::event::Other;

    fn hit(time_s: f64, impulse_n_s: f64) -> Event {
        let other = Other::Wall(0);
        Event { epoch: 1, sequence: 0, time_s, ball: "a".into(), other, point_m: [0.0; 3], impulse_n_s }
    }

    #[test]
    fn a_flash_goes_out_and_flashes_are_bounded() {
        let mut world = testing::original();
        let mut view = HitView::of(&world.roster);
        for i in 0..1000 {
            view.add(&hit(1.0 + f64::from(i) * 1e-6, 5.0));
        }
        assert_eq!(view.flashes.len(), MAX_FLASHES);
        let (rec, _storage) = testing::recording();
        world.snapshot.time_s = 1.0 + 2.0 * FLASH_S;
        view.log_state(&rec, &world.snapshot).unwrap();
        assert!(view.flashes.is_empty());
    }

    #[test]
    fn a_harder_hit_flashes_larger_within_bounds() {
        let mut view = HitView::of(&testing::original().roster);
        for impulse in [0.0, 5.0, 50.0, 1e9] {
            view.add(&hit(0.0, impulse));
        }
        let radii: Vec<f64> = view.flashes.iter().map(|f| f.radius_m).collect();
        assert!(radii.is_sorted() && radii[0] > 0.0 && radii[3] < 1.0, "{radii:?}");
    }
}
