//! Ballroom's viewer bridge: ball states from the wire to Rerun.
//!
//! | file | what |
//! |---|---|
//! | [`view`] | all that is shown of an arena; the order in which news become rows |
//! | [`drawn`] | one scene with its balls, put together from the parts below |
//! | [`surface`], [`floor_mesh`], [`scene_view`], [`net_view`] | what stands still: floor, lines, walls, control net |
//! | [`ball_mesh`], [`ball_view`] | the balls, by level of detail |
//! | [`chosen`], [`overlay_view`] | contacts, velocities, reactions, names; whose |
//! | [`trail_view`], [`hit_view`] | tracks and flashes |
//! | [`mechanics`] | energy in parts and the floor's reaction, from a state |
//! | [`plots`], [`energy_plots`], [`palette`] | numbers over time, colours |
//! | [`named_view`], [`blueprint`], [`materialised`] | eyes with names, the layout, and the layout as messages |
//! | [`recording`] | a Rerun stream and its three timelines |
//! | [`slot`], [`logger`] | the latest-only slot, and the thread behind it that owns a stream |
//! | [`hub`] | what viewers are sent: one bounded ring, each viewer at its own pace |
//! | [`watch`], [`push`] | the door for viewers that come, and the way to one elsewhere |
//! | [`live`] | where viewers find it: ports, the web viewer, the native one |
//! | [`bridge`] | the whole: recordings, and the network that feeds them |
//! | [`process`] | logs, signals, bounded ends |
//! | `demo` | keys, commands and the status line of the main job |

pub mod ball_mesh;
pub mod ball_view;
pub mod blueprint;
pub mod bridge;
pub mod chosen;
#[cfg(feature = "demo")]
pub mod demo;
pub mod drawn;
pub mod energy_plots;
pub mod floor_mesh;
pub mod hit_view;
pub mod hub;
pub mod live;
pub mod logger;
pub mod materialised;
pub mod mechanics;
pub mod named_view;
pub mod net_view;
pub mod overlay_view;
pub mod palette;
pub mod plots;
pub mod process;
pub mod push;
pub mod recording;
pub mod scene_view;
pub mod slot;
pub mod surface;
#[cfg(test)]
mod testing;
pub mod trail_view;
pub mod view;
pub mod watch;

/// Rerun's coordinates are f32; at a hundred metres that is still 8 micrometres.
pub(crate) fn single(point: nalgebra::Vector3<f64>) -> [f32; 3] {
    point.map(|x| x as f32).into()
}
