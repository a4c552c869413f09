//! The layout that goes with every recording: one revolution, stage by stage, readable at 1400×900.

use crosscut_stage::Frame;
use rerun::blueprint::components::{BackgroundKind, Corner2D, Eye3DKind, PanelState, PlayState};
use rerun::blueprint::{
    Blueprint, BlueprintActivation, BlueprintPanel, ContainerLike, Horizontal, SelectionPanel, Spatial2DView,
    Spatial3DView, StateTimelineView, Tabs, TextDocumentView, TextLogView, TimePanel, TimeSeriesView, Vertical,
};
use rerun::external::re_log_types::BlueprintActivationCommand;
use rerun::external::re_sdk_types::blueprint::archetypes::{
    Background, EyeControls3D, LineGrid3D, PlotLegend, ScalarAxis, TextDocumentFormat, VisualBounds2D,
};
use rerun::log::LogMsg;
use rerun::{AsComponents, RecordingStream, RecordingStreamBuilder, RecordingStreamResult, StoreKind, datatypes};

use crate::beam_order::BeamOrder;
use crate::colors::color;
use crate::spectrum::chart_bounds;

/// How far the views have to reach; taken from the first revolution.
pub(crate) struct Extent {
    /// Farthest distance that the scan shows, metres.
    pub(crate) range_m: f64,
    /// Places along the side of the pictures.
    places: usize,
}

impl Default for Extent {
    fn default() -> Self {
        Self { range_m: 15.0, places: 360 }
    }
}

impl Extent {
    /// The sensor's range, but at most twice as far as its returns lie; the sensor's beams.
    pub(crate) fn of(frame: &Frame) -> Self {
        let (default, revolution) = (Self::default(), &frame.revolution);
        let farthest_m = (0..revolution.len()).map(|i| revolution.range_m(i)).fold(0.0, f64::max);
        let seen_m = if farthest_m > 0.0 { 2.0 * farthest_m } else { default.range_m };
        let limit_m = revolution.sweep.as_ref().map(|sweep| sweep.range_max_m).filter(|limit| *limit > 0.0);
        let places = BeamOrder::of(revolution).used;
        Self {
            range_m: limit_m.unwrap_or(f64::INFINITY).min(seen_m),
            places: if places > 0 { places } else { default.places },
        }
    }
}

/// A view's property: it has no setter of its own and is logged beside the view.
struct Property {
    path: String,
    value: Box<dyn AsComponents>,
}

#[derive(Default)]
struct Properties(Vec<Property>);

impl Properties {
    /// The view, with a property noted down for it.
    fn with(&mut self, view: ContainerLike, name: &str, value: impl AsComponents + 'static) -> ContainerLike {
        if let ContainerLike::View(view) = &view {
            let path = format!("{}/{name}", view.blueprint_path().to_string().trim_start_matches('/'));
            self.0.push(Property { path, value: Box::new(value) });
        }
        view
    }
}

/// Sends the layout with the recording and makes it the active one.
pub(crate) fn send(rec: &RecordingStream, extent: &Extent) -> RecordingStreamResult<()> {
    let mut properties = Properties::default();
    let blueprint = overview(extent, &mut properties);
    let (mut messages, command) = messages_of(&blueprint)?;
    messages.extend(property_messages(&command, properties)?);
    rec.send_blueprint(messages, command);
    Ok(())
}

fn messages_of(blueprint: &Blueprint) -> RecordingStreamResult<(Vec<LogMsg>, BlueprintActivationCommand)> {
    let (scratch, storage) = RecordingStreamBuilder::new("crosscut").send_properties(false).memory()?;
    blueprint.send(&scratch, BlueprintActivation::default())?;
    let mut messages = storage.take();
    messages.retain(|message| message.store_id().kind() == StoreKind::Blueprint);
    let command = messages.iter().rev().find_map(|message| match message {
        LogMsg::BlueprintActivationCommand(command) => Some(command.clone()),
        _ => None,
    });
    let command = command.expect("a blueprint that was sent ends with its activation");
    messages.retain(|message| !matches!(message, LogMsg::BlueprintActivationCommand(_)));
    Ok((messages, command))
}

fn property_messages(
    command: &BlueprintActivationCommand,
    properties: Properties,
) -> RecordingStreamResult<Vec<LogMsg>> {
    let (scratch, storage) =
        RecordingStreamBuilder::from_store_id(&command.blueprint_id).send_properties(false).memory()?;
    scratch.set_time_sequence("blueprint", 0);
    for Property { path, value } in properties.0 {
        scratch.log(path, &*value)?;
    }
    let mut messages = storage.take();
    messages.retain(|message| matches!(message, LogMsg::ArrowMsg(..)));
    Ok(messages)
}

/// One revolution, stage by stage, with the flight below.
fn overview(extent: &Extent, properties: &mut Properties) -> Blueprint {
    let pictures = Horizontal::new([
        picture("W by beam: log10, dark 1e-16, yellow 1", "affinity/W", extent, properties),
        picture("L by beam: log10, dark 1e-16, yellow 1", "spectral/L", extent, properties),
    ]);
    let spectral = Horizontal::new([chart(properties), embedding(properties)]);
    let stages = Vertical::new([pictures.into(), spectral.into()]).with_row_shares([1.15, 1.0]);
    let scene = Vertical::new([scan(extent, properties), words(properties)]).with_row_shares([1.9, 1.0]);
    let revolution = Horizontal::new([scene.into(), stages.into()]).with_column_shares([0.62, 1.0]);
    let flight = Horizontal::new([junctions(properties), places(), timings(properties)]);
    Blueprint::new(Vertical::new([revolution.into(), flight.into()]).with_row_shares([3.3, 1.0]))
        .with_auto_views(false)
        .with_auto_layout(false)
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Collapsed))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Collapsed))
        .with_time_panel(time_panel())
}

/// By revolution; at the newest one until somebody moves it.
fn time_panel() -> TimePanel {
    TimePanel::new()
        .with_state(PanelState::Collapsed)
        .with_timeline("revolution")
        .with_play_state(PlayState::Following)
        .with_fps(10.0)
}

/// The scan from above, x up and y left.
fn scan(extent: &Extent, properties: &mut Properties) -> ContainerLike {
    let view = Spatial3DView::new("Scan [m]: x up, y left").with_origin("/").with_contents(["+ /scan/**"]).into();
    let height = (2.1 * extent.range_m) as f32; // the viewer's field of view is 55° from top to bottom
    let eye = EyeControls3D::new()
        .with_kind(Eye3DKind::Orbital)
        .with_position([0.0, 0.0, height])
        .with_look_target([0.0f32, 0.0, 0.0])
        .with_eye_up([1.0f32, 0.0, 0.0]);
    let view = properties.with(view, "EyeControls3D", eye);
    let view = properties.with(view, "LineGrid3D", LineGrid3D::new().with_visible(false));
    properties.with(view, "Background", backdrop())
}

/// A matrix, with the clusters as bars along its edges.
fn picture(name: &str, entity: &str, extent: &Extent, properties: &mut Properties) -> ContainerLike {
    let contents = [format!("+ /{entity}"), "+ /kmeans/labels".to_owned()];
    let view = Spatial2DView::new(name).with_origin("/").with_contents(contents).into();
    let n = extent.places as f64;
    let view = properties.with(view, "Background", backdrop());
    properties.with(view, "VisualBounds2D", bounds([-0.04 * n, -0.04 * n, 1.02 * n, 1.06 * n]))
}

fn chart(properties: &mut Properties) -> ContainerLike {
    let view = Spatial2DView::new("Eigenvalues of L, zeros blue, τ red")
        .with_origin("/spectral/chart")
        .with_contents(["+ $origin/**"])
        .into();
    let view = properties.with(view, "Background", backdrop());
    properties.with(view, "VisualBounds2D", bounds(chart_bounds()))
}

/// The rows of U, from a corner.
fn embedding(properties: &mut Properties) -> ContainerLike {
    let contents = ["+ /spectral/embedding", "+ /spectral/axes", "+ /kmeans/centroids"];
    let view = Spatial3DView::new("Embedding: rows of U scaled, centroids").with_origin("/").with_contents(contents);
    let eye = EyeControls3D::new()
        .with_kind(Eye3DKind::Orbital)
        .with_position([1.5, 1.9, 1.25])
        .with_look_target([0.0f32, 0.0, 0.0])
        .with_eye_up([0.0f32, 0.0, 1.0]);
    let view = properties.with(view.into(), "EyeControls3D", eye);
    let view = properties.with(view, "LineGrid3D", LineGrid3D::new().with_visible(false));
    properties.with(view, "Background", backdrop())
}

/// The answer in words; behind it the notes, the configuration, and what the recording holds.
fn words(properties: &mut Properties) -> ContainerLike {
    let document = |name: &str, origin: &str| TextDocumentView::new(name).with_origin(origin).into();
    let config = document("Configuration", "/config");
    let config = properties.with(config, "TextDocumentFormat", TextDocumentFormat::new().with_monospace(true));
    let log = TextLogView::new("Notes").with_origin("/log").into();
    Tabs::new([document("Junction and place", "/report/summary"), log, config, document("About", "/about")]).into()
}

fn junctions(properties: &mut Properties) -> ContainerLike {
    let contents = ["+ /report/junctions", "+ /spectral/k"];
    let view = TimeSeriesView::new("Junctions and k over revolutions").with_origin("/").with_contents(contents).into();
    let view = properties.with(view, "PlotLegend", PlotLegend::new().with_corner(Corner2D::LeftTop));
    let range = rerun::components::Range1D::new(0.0, 5.5);
    properties.with(view, "ScalarAxis", ScalarAxis::new().with_range(range))
}

fn places() -> ContainerLike {
    StateTimelineView::new("Place over revolutions").with_origin("/report/place").into()
}

fn timings(properties: &mut Properties) -> ContainerLike {
    let view = TimeSeriesView::new("Time per stage [ms]").with_origin("/timing").into();
    properties.with(view, "PlotLegend", PlotLegend::new().with_corner(Corner2D::LeftTop))
}

/// The same in a dark and in a light viewer, so that the colours always stand out.
fn backdrop() -> Background {
    Background::new(BackgroundKind::SolidColor).with_color(color(0x0D10_11FF))
}

/// Left, top, right and bottom of a 2D view.
fn bounds([left, top, right, bottom]: [f64; 4]) -> VisualBounds2D {
    let range =
        datatypes::Range2D { x_range: datatypes::Range1D([left, right]), y_range: datatypes::Range1D([top, bottom]) };
    VisualBounds2D::new(rerun::blueprint::components::VisualBounds2D(range))
}
