//! The layout a viewer opens with: the named views large at the left, plots and text at the right, live.
//!
//! It is the default and not the active layout while the scene stays, so that what a user arranged survives a
//! reconnect; another scene needs other eyes and becomes active.

use crate::materialised::{Materialised, Part};
use crate::named_view::{NamedView, Sights};
use crate::recording::{Recording, SIM_TIME, TICK, WALL_TIME};
use crate::{energy_plots, plots, view};
use rerun::blueprint::components::{BackgroundKind, Corner2D, PanelState, PlayState};
use rerun::blueprint::datatypes::{TextLogColumn, TextLogColumnKind};
use rerun::blueprint::{
    Blueprint, BlueprintActivation, BlueprintPanel, ContainerLike, Horizontal, SelectionPanel, Spatial3DView,
    Tabs, TextLogView, TimePanel, TimeSeriesView, Vertical,
};
use rerun::datatypes::{TimeInt, TimeRange, TimeRangeBoundary, VisibleTimeRange};
use rerun::external::re_sdk_types::blueprint::archetypes::{
    Background, ContainerBlueprint, EntityBehavior, LineGrid3D, PlotLegend, TextLogColumns, VisibleTimeRanges,
};
use rerun::{AsComponents, RecordingStreamResult};

/// How much of the past the plots show, s.
const PLOT_WINDOW_S: i64 = 30;
/// The same in ticks of the usual rate.
const PLOT_WINDOW_TICKS: i64 = 60 * PLOT_WINDOW_S;
const BACKGROUND: [u8; 3] = [20, 24, 32];
/// Name of the tabs that hold the named views.
const VIEWS: &str = "Views";

/// Sends the layout for these sights, which opens with the `first` view. `replace` a layout that is in use.
pub fn send(
    rec: &mut Recording,
    sights: &Sights,
    first: &NamedView,
    replace: bool,
) -> RecordingStreamResult<()> {
    let Some(info) = rec.stream().store_info() else { return Ok(()) };
    let activation = BlueprintActivation { make_active: replace, make_default: true };
    let application = info.application_id().clone();
    let Some(mut layout) = Materialised::of(application, &layout(sights), activation)? else {
        return Ok(());
    };
    add_properties(&mut layout, sights, first)?;
    let (messages, activation) = layout.into_messages();
    rec.send_layout(messages, activation);
    Ok(())
}

fn layout(sights: &Sights) -> Blueprint {
    let view = |view: NamedView| -> ContainerLike {
        Spatial3DView::new(view.title(sights)).with_origin("world").into()
    };
    let views = Tabs::new(NamedView::all(sights).map(view)).with_name(VIEWS);
    let log = TextLogView::new("Log").with_origin(view::LOG);
    let left = Vertical::new([views.into(), log.into()]).with_row_shares([5.0, 1.0]);
    Blueprint::new(Horizontal::new([left.into(), figures().into()]).with_column_shares([2.0, 1.0]))
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

/// Plots on three tabs: the arena, its balls, and what serves them.
fn figures() -> Tabs {
    let plot =
        |name: &str, path: &str| -> ContainerLike { TimeSeriesView::new(name).with_origin(path).into() };
    let arena = Vertical::new([
        plot("Energy drift since the start, relative", plots::ENERGY),
        plot("Energy [J]", energy_plots::PARTS),
        plot("Hits per simulated second", plots::HITS),
    ]);
    let balls = Vertical::new([
        plot("Kinetic energy [J]", energy_plots::KINETIC),
        plot("Energy of spin [J]", energy_plots::SPIN),
        plot("Potential energy [J]", energy_plots::POTENTIAL),
        plot("Reaction of the floor [N]", energy_plots::REACTION),
    ]);
    let server = Vertical::new([
        plot("Tick time [ms]", plots::TICK_TIME),
        plot("Speed", plots::SPEED),
        plot("Error, log10 m", plots::ERROR),
        plot("Bridge [states / s]", plots::BRIDGE),
    ]);
    Tabs::new([
        arena.with_name("Arena").into(),
        balls.with_name("Balls").into(),
        server.with_name("Server").into(),
    ])
}

fn add_properties(
    layout: &mut Materialised,
    sights: &Sights,
    first: &NamedView,
) -> RecordingStreamResult<()> {
    let parts = layout.parts().to_vec();
    let part = |title: &str| parts.iter().find(|part| part.title == title);
    let background =
        Background::new(BackgroundKind::SolidColor).with_color(crate::palette::color(BACKGROUND));
    let grid = LineGrid3D::new().with_visible(false);
    let hidden = EntityBehavior::new().with_visible(false);
    let (windows, legend, columns) = (windows(), PlotLegend::new().with_corner(Corner2D::LeftTop), columns());
    for view in NamedView::all(sights) {
        let Some(Part { path, .. }) = part(&view.title(sights)) else { continue };
        let eye = view.eye(sights);
        let mut properties: Vec<(String, &dyn AsComponents)> = vec![
            (format!("{path}/EyeControls3D"), &eye),
            (format!("{path}/LineGrid3D"), &grid),
            (format!("{path}/Background"), &background),
        ];
        properties.extend(view.hidden().iter().map(|entity| -> (String, &dyn AsComponents) {
            (format!("{path}/ViewContents/overrides/{entity}/visualizers"), &hidden)
        }));
        layout.add(&properties)?;
        if let Some(tabs) = part(VIEWS).filter(|_| view.same_tab(first)) {
            let active = ContainerBlueprint::update_fields().with_active_tab(path.as_str());
            layout.add(&[(tabs.path.clone(), &active)])?;
        }
    }
    for Part { path, class, .. } in &parts {
        match class.as_str() {
            "TimeSeries" => layout.add(&[
                (format!("{path}/VisibleTimeRanges"), &windows),
                (format!("{path}/PlotLegend"), &legend),
            ])?,
            "TextLog" => layout.add(&[(format!("{path}/TextLogColumns"), &columns)])?,
            _ => {}
        }
    }
    Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::named_view::Followed;
    use crate::scene_view::Extent;
    use crate::testing;
    use rerun::log::{Chunk, LogMsg};

    fn sights() -> Sights {
        let extent =
            |low: f64, high: f64| Extent { lowest: [-10.0, -10.0, low], highest: [10.0, 10.0, high] };
        let followed = Followed { name: "player".into(), center_m: [0.0, 5.0, 1.0], radius_m: 1.0 };
        Sights { room: extent(-4.5, 2.0), net: extent(-70.0, 40.0), followed: Some(followed) }
    }

    fn sent(replace: bool) -> (Vec<Chunk>, rerun::external::re_log_types::BlueprintActivationCommand) {
        let (mut rec, storage) = testing::recording();
        send(&mut rec, &sights(), &NamedView::Top, replace).unwrap();
        rec.stream().flush_blocking().unwrap();
        let (mut chunks, mut activations) = (vec![], vec![]);
        for message in storage.take() {
            match message {
                LogMsg::ArrowMsg(store, arrow) if store.is_blueprint() => {
                    chunks.push(Chunk::from_arrow_msg(&arrow).unwrap());
                }
                LogMsg::BlueprintActivationCommand(command) => activations.push(command),
                _ => {}
            }
        }
        assert_eq!(activations.len(), 1);
        (chunks, activations.remove(0))
    }

    #[test]
    fn every_view_has_an_eye_and_hides_its_details_and_every_plot_its_window() {
        let (chunks, _) = sent(false);
        let paths: Vec<String> = chunks.iter().map(|chunk| chunk.entity_path().to_string()).collect();
        let count = |end: &str| paths.iter().filter(|path| path.ends_with(end)).count();
        assert_eq!((count("/EyeControls3D"), count("/Background"), count("/TextLogColumns")), (6, 6, 1));
        assert_eq!(count("/VisibleTimeRanges"), 11);
        assert_eq!(
            (count("/overrides/world/net/visualizers"), count("/overrides/world/overlays/visualizers")),
            (5, 5)
        );
    }

    #[test]
    fn the_wanted_view_is_the_active_tab() {
        let (chunks, _) = sent(false);
        let text = |chunk: &Chunk, descriptor: rerun::ComponentDescriptor| {
            let first = chunk.iter_slices::<String>(descriptor.component).flatten().next();
            first.map(|text| text.to_string())
        };
        let tab = ContainerBlueprint::descriptor_active_tab;
        let active: Vec<String> = chunks.iter().filter_map(|chunk| text(chunk, tab())).collect();
        let title =
            rerun::external::re_sdk_types::blueprint::archetypes::ViewBlueprint::descriptor_display_name;
        let named = |path: &str| {
            let view = chunks.iter().find(|chunk| chunk.entity_path().to_string() == path).unwrap();
            text(view, title())
        };
        assert_eq!(active.len(), 1);
        assert_eq!(named(&active[0]).as_deref(), Some("Top"));
    }

    #[test]
    fn a_layout_replaces_a_users_own_only_when_asked_to() {
        for replace in [false, true] {
            let (_, activation) = sent(replace);
            assert!(activation.make_default && activation.make_active == replace);
        }
    }
}
