//! The floor's control net: the points that shape it, and the lines between neighbours.

use crate::palette;
use crate::recording::Recording;
use crate::scene_view::Extent;
use crate::surface::Surface;
use rerun::{LineStrips3D, Points3D, Radius, RecordingStreamResult};

/// Entity of the lines of the net.
pub const NET: &str = "world/net";
/// Entity of its points.
pub const NET_POINTS: &str = "world/net/points";

/// Logs the control net for all time.
pub fn log(rec: &Recording, surface: &Surface) -> RecordingStreamResult<()> {
    let rows: Vec<Vec<[f32; 3]>> =
        surface.net().iter().map(|row| row.iter().copied().map(crate::single).collect()).collect();
    let columns = (0..rows[0].len()).map(|j| rows.iter().map(|row| row[j]).collect());
    let lines = LineStrips3D::new(rows.iter().cloned().chain(columns))
        .with_radii([Radius::new_ui_points(0.5)])
        .with_colors([palette::color(palette::NET)]);
    rec.log_static(NET, &lines)?;
    let points = Points3D::new(rows.into_iter().flatten())
        .with_radii([Radius::new_ui_points(3.0)])
        .with_colors([palette::color(palette::NET)]);
    rec.log_static(NET_POINTS, &points)
}

/// The box that holds the net, m.
pub fn extent(surface: &Surface) -> Extent {
    let points = || surface.net().iter().flatten();
    let each = |pick: fn(f64, f64) -> f64, from: f64| {
        std::array::from_fn(|axis| points().map(|point| point[axis]).fold(from, pick))
    };
    Extent { lowest: each(f64::min, f64::INFINITY), highest: each(f64::max, f64::NEG_INFINITY) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn the_net_of_the_original_reaches_from_its_lowest_to_its_highest_control_point() {
        let surface = Surface::of(&testing::original().scene.floor).unwrap();
        let extent = extent(&surface);
        assert_eq!((extent.lowest, extent.highest), ([-10.0, -10.0, -70.0], [10.0, 10.0, 40.0]));
    }

    #[test]
    fn the_net_is_logged_with_a_line_along_each_row_and_column() {
        let (rec, storage) = testing::recording();
        let surface = Surface::of(&testing::original().scene.floor).unwrap();
        log(&rec, &surface).unwrap();
        rec.stream().flush_blocking().unwrap();
        let lengths = |path: &str, component: rerun::ComponentIdentifier| {
            testing::chunks(storage.take().into_iter(), path)
                .map(|chunk| chunk.component_batch_raw(component, 0).unwrap().unwrap().len())
                .collect::<Vec<_>>()
        };
        assert_eq!(lengths(NET, LineStrips3D::descriptor_strips().component), [22]);
    }
}
