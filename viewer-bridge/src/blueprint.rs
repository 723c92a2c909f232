//! The layout a viewer opens with: the box large at the left, plots and text at the right, live.
//!
//! It is sent as the default, not as the active layout, so that what a user arranged survives a reconnect.

use crate::recording::{Recording, SIM_TIME, TICK, WALL_TIME};
use crate::scene_view::Extent;
use crate::{plots, view};
use nalgebra::Vector3;
use rerun::blueprint::components::{BackgroundKind, Corner2D, PanelState, PlayState};
use rerun::blueprint::datatypes::{TextLogColumn, TextLogColumnKind};
use rerun::blueprint::{
    Blueprint, BlueprintActivation, BlueprintPanel, ContainerLike, Horizontal, SelectionPanel, Spatial3DView,
    TextLogView, TimePanel, TimeSeriesView, Vertical,
};
use rerun::datatypes::{TimeInt, TimeRange, TimeRangeBoundary, VisibleTimeRange};
use rerun::external::re_log_types::BlueprintActivationCommand;
use rerun::external::re_sdk_types::blueprint::archetypes::{
    Background, EyeControls3D, LineGrid3D, PlotLegend, TextLogColumns, VisibleTimeRanges,
};
use rerun::log::{Chunk, LogMsg};
use rerun::{RecordingStreamBuilder, RecordingStreamResult, StoreId};

/// How much of the past the plots show, s.
const PLOT_WINDOW_S: i64 = 30;
/// The same in ticks of the usual rate.
const PLOT_WINDOW_TICKS: i64 = 60 * PLOT_WINDOW_S;

/// Direction from the middle of the box to the eye: from the south-east, well above the walls.
const EYE_DIRECTION: [f64; 3] = [0.42, -0.80, 0.72];
/// Distance of the eye in diagonals of the box: all of it is seen in a view that is a little wider than high.
const EYE_DISTANCE: f64 = 0.87;
/// The eye looks in front of the middle by this part of the diagonal, for what is near takes up more of the view.
const LOOK_NEARER: f64 = 0.075;
const BACKGROUND: [u8; 3] = [20, 24, 32];

/// Sends the default layout for a box of this extent.
pub fn send(rec: &mut Recording, extent: Extent) -> RecordingStreamResult<()> {
    let Some(info) = rec.stream().store_info() else { return Ok(()) };
    let (scratch, storage) = RecordingStreamBuilder::new(info.application_id().clone()).memory()?;
    layout().send(&scratch, BlueprintActivation { make_active: false, make_default: true })?;
    flush(&scratch);
    let Some(mut blueprint) = Materialised::of(storage.take()) else { return Ok(()) };
    blueprint.add_properties(extent)?;
    rec.send_layout(blueprint.messages, blueprint.activation);
    Ok(())
}

fn layout() -> Blueprint {
    let plot =
        |name: &str, path: &str| -> ContainerLike { TimeSeriesView::new(name).with_origin(path).into() };
    let room = Spatial3DView::new("Ballroom").with_origin("world");
    let log = TextLogView::new("Log").with_origin(view::LOG);
    let left = Vertical::new([room.into(), log.into()]).with_row_shares([5.0, 1.0]);
    let server = [plot("Tick time [ms]", plots::TICK_TIME), plot("Speed", plots::SPEED)];
    let right = Vertical::new([
        plot("Energy drift since the start, relative", plots::ENERGY),
        plot("Hits per simulated second", plots::HITS),
        Horizontal::new(server).into(),
        plot("Bridge [states / s]", plots::BRIDGE),
    ]);
    Blueprint::new(Horizontal::new([left.into(), right.into()]).with_column_shares([2.0, 1.0]))
        .with_auto_views(false)
        .with_auto_layout(false)
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Collapsed))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Collapsed))
        .with_time_panel(
            TimePanel::new()
                .with_state(PanelState::Collapsed)
                .with_timeline(WALL_TIME)
                .with_play_state(PlayState::Following),
        )
}

/// A blueprint as messages: the builder has no setters for the eye, the background and plots' time ranges, so
/// these are appended to the same store.
struct Materialised {
    store: StoreId,
    messages: Vec<LogMsg>,
    activation: BlueprintActivationCommand,
    room: String,
    plots: Vec<String>,
    log: Option<String>,
}

impl Materialised {
    /// Sorts the messages of a stream that holds one blueprint; None if it holds none.
    fn of(stream: Vec<LogMsg>) -> Option<Self> {
        let (mut messages, mut activation, mut store, mut room) = (vec![], None, None, None);
        let (mut plots, mut log) = (vec![], None);
        for message in stream {
            match &message {
                LogMsg::BlueprintActivationCommand(command) => {
                    activation = Some(command.clone());
                    continue;
                }
                LogMsg::SetStoreInfo(info) if info.info.store_id.is_blueprint() => {
                    store = Some(info.info.store_id.clone());
                }
                LogMsg::ArrowMsg(id, arrow) if id.is_blueprint() => {
                    let path = Chunk::from_arrow_msg(arrow).ok()?.entity_path().to_string();
                    let is_view = path.starts_with("/view/") && path.matches('/').count() == 2;
                    let text = if is_view { format!("{:?}", arrow.batch) } else { String::new() };
                    if text.contains("\"3D\"") {
                        room = Some(path);
                    } else if text.contains("\"TimeSeries\"") {
                        plots.push(path);
                    } else if text.contains("\"TextLog\"") {
                        log = Some(path);
                    }
                }
                _ => continue,
            }
            messages.push(message);
        }
        Some(Self { store: store?, messages, activation: activation?, room: room?, plots, log })
    }

    fn add_properties(&mut self, extent: Extent) -> RecordingStreamResult<()> {
        let (stream, storage) = RecordingStreamBuilder::from_store_id(&self.store).blueprint().memory()?;
        stream.set_time_sequence("blueprint", 0);
        let direction = Vector3::from(EYE_DIRECTION).normalize();
        let middle = Vector3::from(extent.middle());
        let eye = middle + direction * (EYE_DISTANCE * extent.diagonal_m());
        let target =
            middle + Vector3::new(direction.x, direction.y, 0.0) * (LOOK_NEARER * extent.diagonal_m());
        let eye = EyeControls3D::new()
            .with_position(crate::single(eye))
            .with_look_target(crate::single(target))
            .with_eye_up([0.0, 0.0, 1.0]);
        stream.log(format!("{}/EyeControls3D", self.room), &eye)?;
        stream.log(format!("{}/LineGrid3D", self.room), &LineGrid3D::new().with_visible(false))?;
        let background =
            Background::new(BackgroundKind::SolidColor).with_color(crate::palette::color(BACKGROUND));
        stream.log(format!("{}/Background", self.room), &background)?;
        for plot in &self.plots {
            stream.log(format!("{plot}/VisibleTimeRanges"), &windows())?;
            stream.log(format!("{plot}/PlotLegend"), &PlotLegend::new().with_corner(Corner2D::LeftTop))?;
        }
        if let Some(log) = &self.log {
            stream.log(format!("{log}/TextLogColumns"), &columns())?;
        }
        flush(&stream);
        let added = storage.take().into_iter();
        self.messages.extend(added.filter(|m| matches!(m, LogMsg::ArrowMsg(id, _) if id.is_blueprint())));
        Ok(())
    }
}

/// The last half minute on whichever timeline is shown.
fn windows() -> VisibleTimeRanges {
    let last = |timeline: &str, length: i64| VisibleTimeRange {
        timeline: timeline.into(),
        range: TimeRange {
            start: TimeRangeBoundary::CursorRelative(TimeInt(-length)),
            end: TimeRangeBoundary::CursorRelative(TimeInt(0)),
        },
    };
    let nanos = PLOT_WINDOW_S * 1_000_000_000;
    VisibleTimeRanges::new([last(TICK, PLOT_WINDOW_TICKS), last(SIM_TIME, nanos), last(WALL_TIME, nanos)])
}

/// Time, level and text; all lines come from one entity.
fn columns() -> TextLogColumns {
    let shown = [TextLogColumnKind::LogLevel, TextLogColumnKind::Body];
    TextLogColumns::new()
        .with_text_log_columns(shown.map(|kind| TextLogColumn { visible: true.into(), kind }))
}

/// Memory sinks cannot stall, so a failure is one of encoding; the layout then lacks a part, nothing else.
fn flush(stream: &rerun::RecordingStream) {
    if let Err(fault) = stream.flush_blocking() {
        tracing::warn!("the viewer's layout is incomplete: {fault}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn the_layout_has_an_eye_and_five_plots_and_does_not_replace_a_users_own() {
        let (mut rec, storage) = testing::recording();
        send(&mut rec, Extent { lowest: [-10.0, -10.0, -4.5], highest: [10.0, 10.0, 2.0] }).unwrap();
        rec.stream().flush_blocking().unwrap();
        let (mut paths, mut activations) = (vec![], vec![]);
        for message in storage.take() {
            match message {
                LogMsg::ArrowMsg(store, arrow) if store.is_blueprint() => {
                    paths.push(Chunk::from_arrow_msg(&arrow).unwrap().entity_path().to_string());
                }
                LogMsg::BlueprintActivationCommand(command) => activations.push(command),
                _ => {}
            }
        }
        let count = |end: &str| paths.iter().filter(|path| path.ends_with(end)).count();
        assert_eq!((count("/EyeControls3D"), count("/Background"), count("/VisibleTimeRanges")), (1, 1, 5));
        assert_eq!(count("/TextLogColumns"), 1);
        assert!(activations.len() == 1 && activations[0].make_default && !activations[0].make_active);
    }
}
