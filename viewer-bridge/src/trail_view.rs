//! Tracks that balls leave on the floor, fading with age.

use crate::chosen::chosen;
use crate::palette;
use crate::recording::Recording;
use nalgebra::Vector3;
use protocol::snapshot::{Roster, Snapshot};
use rerun::{Color, LineStrips3D, Radius, RecordingStreamResult};
use std::collections::VecDeque;

/// Entity of all tracks.
pub const TRAILS: &str = "world/trails";

/// At most so many balls leave tracks: players first, then by name.
pub const MAX_TRAILS: usize = 48;

/// Length of a track, simulated s.
const LENGTH_S: f64 = 3.0;
/// Simulated time between points of a track, s.
const SPACING_S: f64 = 1.0 / 30.0;
/// Points kept for each ball; more than the length needs, so that a late tick loses nothing.
const MAX_POINTS: usize = 128;
/// Wall time between two logs of all tracks, ns.
const LOG_EVERY_NS: u64 = 100_000_000;
/// Parts of a track, each thinner and paler than the one before.
const PARTS: usize = 5;
/// Colour of the newest and of the oldest part lies between the ball's and this.
const PALE: [u8; 3] = [225, 225, 215];

/// A ring of recent points for each ball that leaves a track.
pub struct TrailView {
    balls: Vec<usize>,
    colors: Vec<[u8; 3]>,
    points: Vec<VecDeque<(f64, [f32; 3])>>,
    logged_ns: Option<u64>,
}

impl TrailView {
    /// Chooses whose tracks are drawn.
    pub fn of(roster: &Roster) -> Self {
        let balls = chosen(roster, None, MAX_TRAILS);
        let colors = balls.iter().map(|ball| roster.color_rgb[*ball]).collect();
        let points = vec![VecDeque::with_capacity(MAX_POINTS); balls.len()];
        Self { balls, colors, points, logged_ns: None }
    }

    /// Forgets everything, and shows that.
    pub fn clear(&mut self, rec: &Recording) -> RecordingStreamResult<()> {
        self.points.iter_mut().for_each(VecDeque::clear);
        self.logged_ns = None;
        rec.log(TRAILS, &LineStrips3D::new(Vec::<Vec<[f32; 3]>>::new()))
    }

    /// Takes a state in, and logs all tracks every tenth of a second. `above` gives a point just above the floor
    /// at (u, v), m.
    pub fn log_state(
        &mut self,
        rec: &Recording,
        state: &Snapshot,
        above: impl Fn([f64; 2]) -> Vector3<f64>,
    ) -> RecordingStreamResult<()> {
        for (points, ball) in self.points.iter_mut().zip(&self.balls) {
            // Times are multiples of a tick; half a microsecond absorbs their rounding.
            if points.back().is_none_or(|(time, _)| state.time_s - time >= SPACING_S - 5e-7) {
                points.push_back((state.time_s, crate::single(above(state.uv[*ball]))));
            }
            let old = |(time, _): &(f64, [f32; 3])| state.time_s - time > LENGTH_S;
            while points.len() > MAX_POINTS || points.front().is_some_and(old) {
                points.pop_front();
            }
        }
        if self.logged_ns.is_some_and(|last| state.wall_ns.abs_diff(last) < LOG_EVERY_NS) {
            return Ok(());
        }
        self.logged_ns = Some(state.wall_ns);
        rec.log(TRAILS, &self.strips())
    }

    fn strips(&self) -> LineStrips3D {
        let (mut strips, mut colors, mut radii) = (Vec::new(), Vec::<Color>::new(), Vec::new());
        for (points, color) in self.points.iter().zip(&self.colors) {
            let points: Vec<[f32; 3]> = points.iter().map(|(_, point)| *point).collect();
            for part in 0..PARTS {
                // Parts share an end, so that the track has no gaps; the last part is the newest.
                let [from, to] = [part, part + 1].map(|p| p * points.len().saturating_sub(1) / PARTS);
                if from < to {
                    strips.push(points[from..=to].to_vec());
                    let age = 1.0 - (part + 1) as f64 / PARTS as f64;
                    colors.push(palette::color(palette::between(*color, PALE, 0.75 * age)));
                    radii.push(Radius::new_ui_points((2.6 - 2.0 * age) as f32));
                }
            }
        }
        LineStrips3D::new(strips).with_colors(colors).with_radii(radii)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn a_track_is_bounded_in_time_and_points_at_any_tick_rate() {
        for rate in [10.0, 60.0, 1000.0] {
            let mut world = testing::original();
            let mut view = TrailView::of(&world.roster);
            let (rec, _storage) = testing::recording();
            for tick in 0..(20.0 * rate) as u64 {
                world.snapshot.time_s = tick as f64 / rate;
                view.log_state(&rec, &world.snapshot, |_| Vector3::zeros()).unwrap();
            }
            let points = &view.points[0];
            assert!(points.len() <= MAX_POINTS, "{rate}");
            let span = points.back().unwrap().0 - points.front().unwrap().0;
            assert!(span <= LENGTH_S && span > 0.9 * LENGTH_S, "{rate}: {span}");
        }
    }

    #[test]
    fn players_leave_tracks_whatever_their_place() {
        let mut roster = testing::original().roster;
        roster.names = (0..100).map(|i| i.to_string()).collect();
        roster.player = (0..100).map(|i| i == 99).collect();
        roster.color_rgb = vec![[0; 3]; 100];
        let view = TrailView::of(&roster);
        assert_eq!((view.balls[0], view.balls.len()), (99, MAX_TRAILS));
    }
}
