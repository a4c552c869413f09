//! The page of a mission: the mine from above, what the vehicle decided and why, and the counts over time.

use nalgebra::Point2;
use rerun::blueprint::components::{BackgroundKind, Eye3DKind, LinkAxis, TextLogColumn};
use rerun::blueprint::datatypes::{self, TextLogColumnKind};
use rerun::blueprint::{
    ContainerLike, Horizontal, Spatial3DView, Tabs, TextDocumentView, TextLogView, TimeSeriesView, Vertical,
};
use rerun::datatypes::TimeRange;
use rerun::external::re_sdk_types::blueprint::archetypes::{
    Background, EyeControls3D, LineGrid3D, PlotLegend, TextLogColumns, TimeAxis,
};

use super::properties::Properties;

/// The entities of a mission.
pub(crate) mod entities {
    pub(crate) const MINE: &str = "/mission/mine";
    pub(crate) const SCALE: &str = "/mission/scale";
    pub(crate) const OUTCOME: &str = "/mission/outcome";
    pub(crate) const VEHICLE: &str = "/mission/vehicle";
    pub(crate) const TRAIL: &str = "/mission/trail";
    pub(crate) const SCAN: &str = "/mission/scan";
    pub(crate) const OPENINGS: &str = "/mission/openings";
    pub(crate) const GOAL: &str = "/mission/goal";
    pub(crate) const CHOICE: &str = "/mission/choice";
    pub(crate) const PASSAGES: &str = "/mission/map/passages";
    pub(crate) const WAYS: &str = "/mission/map/ways";
    pub(crate) const PLACES: &str = "/mission/map/places";
    pub(crate) const WHY: &str = "/mission/why";
    pub(crate) const LOG: &str = "/mission/log";
    pub(crate) const WALLS: &str = "/mission/walls";
    pub(crate) const NEW_WAYS: &str = "/mission/new_ways";
}

/// The page for a mine in a rectangle between these corners.
pub(super) fn page(properties: &mut Properties, [low, high]: [Point2<f64>; 2]) -> ContainerLike {
    let above = from_above(properties, low, high);
    let outcome = TextDocumentView::new("What became of it").with_origin(entities::OUTCOME);
    let why = TextDocumentView::new("The last decision").with_origin(entities::WHY);
    let column = |kind| TextLogColumn(datatypes::TextLogColumn { visible: true.into(), kind });
    let columns = TextLogColumns::new().with_text_log_columns([column(TextLogColumnKind::Body)]);
    let log = TextLogView::new("Decisions: click one; the page Stages shows its scan").with_origin(entities::LOG);
    let log = properties.with(log, "TextLogColumns", columns);
    let left = plot(properties, "Ways on the map not taken", entities::NEW_WAYS);
    let walls = plot(properties, "Walls in view", entities::WALLS);
    let plots = Tabs::new([left, walls]);
    let words = Vertical::new([outcome.into(), why.into(), log, plots.into()]).with_row_shares([0.85, 0.85, 1.4, 0.9]);
    Horizontal::new([above, words.into()]).with_column_shares([1.5, 1.0]).with_name("Mission").into()
}

fn from_above(properties: &mut Properties, low: Point2<f64>, high: Point2<f64>) -> ContainerLike {
    let middle = nalgebra::center(&low, &high);
    let size = high - low;
    // The viewer's field of view is 55° from top to bottom; the view is about as wide as high.
    let height = (1.1 * size.y.max(size.x)) as f32;
    let name = "The mine from above: ways taken blue, not taken pink; vehicle violet; true walls grey";
    let view = Spatial3DView::new(name).with_origin("/mission").with_contents(["+ /mission/**"]);
    let eye = EyeControls3D::new()
        .with_kind(Eye3DKind::Orbital)
        .with_position([middle.x as f32, middle.y as f32, height])
        .with_look_target([middle.x as f32, middle.y as f32, 0.0])
        .with_eye_up([0.0f32, 1.0, 0.0]);
    let view = properties.with(view, "EyeControls3D", eye);
    let view = properties.with(view, "LineGrid3D", LineGrid3D::new().with_visible(false));
    properties.with(view, "Background", Background::new(BackgroundKind::SolidColor))
}

/// A plot over the whole mission.
fn plot(properties: &mut Properties, name: &str, entity: &str) -> ContainerLike {
    let view = TimeSeriesView::new(name).with_origin(entity);
    let view = properties.with(
        view,
        "TimeAxis",
        TimeAxis::new().with_link(LinkAxis::Independent).with_view_range(TimeRange::EVERYTHING),
    );
    properties.with(view, "PlotLegend", PlotLegend::new().with_visible(false))
}
