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
    /// Farthest row of U from its origin.
    pub(crate) embedding: f64,
}

impl Default for Extent {
    fn default() -> Self {
        Self { range_m: 15.0, places: 360, embedding: 0.15 }
    }
}

impl Extent {
    pub(crate) fn of(frame: &Frame) -> Self {
        let default = Self::default();
        let revolution = &frame.revolution;
        let farthest = (0..revolution.len()).map(|i| revolution.range_m(i)).fold(0.0, f64::max);
        let limit = revolution.sweep.as_ref().map(|s| s.range_max_m).filter(|m| m.is_finite() && *m > 0.0);
        let range_m = limit.map_or(farthest, |limit| if farthest > 0.0 { farthest.min(limit) } else { limit });
        let places = BeamOrder::of(revolution).used;
        let u = &frame.spectrum.u;
        let row_norm = |i: usize| (0..u.ncols().min(3)).map(|j| u[(i, j)].powi(2)).sum::<f64>().sqrt();
        let embedding = (0..u.nrows()).map(row_norm).fold(0.0, f64::max);
        Self {
            range_m: if range_m > 0.0 { range_m } else { default.range_m },
            places: if places > 0 { places } else { default.places },
            embedding: if embedding > 0.0 { embedding } else { default.embedding },
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
    let spectral = Horizontal::new([chart(properties), embedding(extent, properties)]);
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
    let (n, margin) = (extent.places as f64, 0.04 * extent.places as f64);
    let view = properties.with(view, "Background", backdrop());
    properties.with(view, "VisualBounds2D", bounds([-margin, -margin, n + 1.0, n + 1.0]))
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
fn embedding(extent: &Extent, properties: &mut Properties) -> ContainerLike {
    let contents = ["+ /spectral/embedding", "+ /spectral/axes", "+ /kmeans/centroids"];
    let view = Spatial3DView::new("Embedding: rows of U, centroids").with_origin("/").with_contents(contents);
    let reach = extent.embedding as f32;
    let eye = EyeControls3D::new()
        .with_kind(Eye3DKind::Orbital)
        .with_position([1.5 * reach, 1.9 * reach, 1.25 * reach])
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
