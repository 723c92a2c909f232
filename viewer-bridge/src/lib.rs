//! Ballroom's viewer bridge: ball states from the wire to Rerun.
//!
//! | file | what |
//! |---|---|
//! | [`view`] | all that is shown of an arena; the order in which news become rows |
//! | [`surface`], [`floor_mesh`], [`scene_view`] | what stands still: floor, lines, walls |
//! | [`ball_mesh`], [`ball_view`] | the balls, by level of detail |
//! | [`trail_view`], [`hit_view`] | tracks and flashes |
//! | [`plots`], [`blueprint`], [`palette`] | numbers over time, layout, colours |
//! | [`recording`] | a Rerun stream and its three timelines |
//! | [`slot`], [`logger`] | the latest-only slot, and the thread behind it that owns a stream |
//! | [`live`] | serving viewers: gRPC, the web viewer, the native one |
//! | [`bridge`] | the whole: recordings, and the network that feeds them |
//! | [`process`] | logs, signals, bounded ends |
//! | `demo` | keys, commands and the status line of the main job |

pub mod ball_mesh;
pub mod ball_view;
pub mod blueprint;
pub mod bridge;
#[cfg(feature = "demo")]
pub mod demo;
pub mod floor_mesh;
pub mod hit_view;
pub mod live;
pub mod logger;
pub mod palette;
pub mod plots;
pub mod process;
pub mod recording;
pub mod scene_view;
pub mod slot;
pub mod surface;
#[cfg(test)]
mod testing;
pub mod trail_view;
pub mod view;

/// Rerun's coordinates are f32; at a hundred metres that is still 8 micrometres.
pub(crate) fn single(point: nalgebra::Vector3<f64>) -> [f32; 3] {
    point.map(|x| x as f32).into()
}
