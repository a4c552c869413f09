//! The views: what each shows, and from which side.

use rerun::blueprint::components::{BackgroundKind, Corner2D, Eye3DKind, LinkAxis, TextLogColumn};
use rerun::blueprint::datatypes;
use rerun::blueprint::{
    ContainerLike, GraphView, Spatial2DView, Spatial3DView, StateTimelineView, TextDocumentView, TextLogView,
    TimeSeriesView,
};
use rerun::components::{self, Range1D};
use rerun::external::re_sdk_types::blueprint::archetypes::{
    Background, EyeControls3D, LineGrid3D, PlotLegend, ScalarAxis, TextDocumentFormat, TextLogColumns, TextLogRows,
    TimeAxis, VisualBounds2D,
};

use super::differs::{DIFFERS, DIFFERS_LOG, DIFFERS_SUMMARY};
use super::extent::{Extent, Side};
use super::properties::Properties;
use crate::eigenvectors::HEIGHT;
use crate::gaps::gaps_bounds;
use crate::profile::profile_bounds;
use crate::scan::step_m;
use crate::schema::{
    AFFINITY_ABSENT, AFFINITY_GAPS, AFFINITY_GAPS_AXIS, AFFINITY_LINKS, AFFINITY_MARKS, AFFINITY_SCALE, CONFIG, Entity,
    FLIGHT_GRAPH, FLIGHT_HERE, FLIGHT_NODES, FLIGHT_PASSAGES, FLIGHT_PATH, FLIGHT_POSE, FLIGHT_SCALE, FLIGHT_UNSURE,
    FLIGHT_WALLS, FLIGHT_WALLS_NEW, KMEANS_BLOCKS, KMEANS_CENTROIDS, KMEANS_LABELS, KMEANS_PROFILE,
    KMEANS_PROFILE_AXES, KMEANS_PROFILE_NAMES, LOG, REPORT_AXIS, REPORT_CONFIDENCE, REPORT_DOUBT, REPORT_JUNCTIONS,
    REPORT_PLACE, REPORT_SUMMARY, REPORT_WHY, SCAN_CLOUD, SCAN_COUNT, SCAN_LINKS, SCAN_NUMBERS, SCAN_OPENINGS,
    SCAN_RETURNS, SCAN_RINGS, SCAN_SENSOR, SCAN_SPHERE, SCAN_SPHERE_AXES, SCAN_SPHERE_MARKS, SCAN_WALLS, SCAN_WAYS,
    SPECTRAL_AXES, SPECTRAL_CHART, SPECTRAL_CHART_AXIS, SPECTRAL_EMBEDDING, SPECTRAL_K, SPECTRAL_MARGIN,
    SPECTRAL_U_BARS, SPECTRAL_U_PICTURE, TIMING, TIMING_FLIGHT, TIMING_TOTAL, TRUTH_WALLS,
};
use crate::spectrum::chart_bounds;
use crate::why::UNSURE;

/// Makes views of one recording.
pub(super) struct Views {
    /// The entity that all entities of the recording stand below: nothing, or a name that starts with `/`.
    root: String,
    /// The beginning of every title where another recording is shown as well.
    title: String,
    extent: Extent,
    properties: Properties,
}

impl Views {
    /// Views of the only recording.
    pub(super) fn new(extent: Extent) -> Self {
        Self { root: String::new(), title: String::new(), extent, properties: Properties::default() }
    }

    /// Views of one of two recordings; of the only one if it has no name.
    pub(super) fn of(side: &Side) -> Self {
        Self {
            root: format!("/{}", side.below),
            title: if side.name.is_empty() { String::new() } else { format!("{}: ", side.name) },
            extent: side.extent,
            properties: Properties::default(),
        }
    }

    /// The name of a view or page, with the name of the recording where there are two.
    pub(super) fn titled(&self, name: &str) -> String {
        format!("{}{name}", self.title)
    }

    pub(super) fn into_properties(self) -> Properties {
        self.properties
    }

    /// Queries for these entities.
    fn entities<const N: usize>(&self, entities: [Entity; N]) -> [String; N] {
        entities.map(|entity| format!("+ {}", self.path(entity)))
    }

    /// Where an entity stands.
    fn path(&self, entity: Entity) -> String {
        format!("{}{}", self.root, entity.path)
    }

    /// The origin of a view of several entities.
    fn origin(&self) -> &str {
        if self.root.is_empty() { "/" } else { &self.root }
    }

    /// The returns coloured by wall, and the edges of W that decide the count.
    pub(super) fn returns(&mut self, name: &str) -> ContainerLike {
        self.above(name, [SCAN_RETURNS, SCAN_NUMBERS, SCAN_LINKS, AFFINITY_LINKS, SCAN_RINGS, SCAN_SENSOR])
    }

    /// Returns, walls and openings.
    pub(super) fn scan(&mut self, name: &str) -> ContainerLike {
        self.above(name, [SCAN_RETURNS, SCAN_WALLS, SCAN_NUMBERS, SCAN_OPENINGS, SCAN_RINGS, SCAN_SENSOR])
    }

    /// Whether ways on of clouds are counted.
    pub(super) fn has_ways(&self) -> bool {
        self.extent.has_ways()
    }

    /// A cloud in space with its ways on, seen from behind and above.
    pub(super) fn cloud(&mut self, name: &str) -> ContainerLike {
        let contents = self.entities([SCAN_CLOUD, SCAN_WAYS, SCAN_SENSOR]);
        let view = Spatial3DView::new(self.titled(name)).with_origin(self.origin()).with_contents(contents);
        let cut = self.extent.ways_m as f32;
        self.seen_from(view, [-3.2 * cut, 1.2 * cut, 3.2 * cut], [0.0, 0.0, 1.0])
    }

    /// The sphere of directions around a cloud, unrolled.
    pub(super) fn sphere(&mut self, name: &str) -> ContainerLike {
        self.flat(name, [SCAN_SPHERE, SCAN_SPHERE_MARKS, SCAN_SPHERE_AXES], [-58.0, -8.0, 385.0, 200.0])
    }

    /// Walls and openings in space, with all entities below `root` except pictures; seen from behind and above.
    pub(super) fn scene(&mut self, name: &str, root: &str, pictures: &[String]) -> ContainerLike {
        let ours = self.entities([SCAN_RETURNS, SCAN_WALLS, SCAN_OPENINGS, SCAN_SENSOR]);
        let flat = pictures.iter().map(|entity| format!("- {entity}"));
        let contents = ours.into_iter().chain([format!("+ /{root}/**")]).chain(flat);
        let view = Spatial3DView::new(self.titled(name)).with_origin(self.origin()).with_contents(contents);
        let reach = self.extent.range_m as f32;
        self.seen_from(view, [-1.1 * reach, 0.0, 1.2 * reach], [0.0, 0.0, 1.0])
    }

    /// A camera's picture.
    pub(super) fn camera(entity: &str) -> ContainerLike {
        Spatial2DView::new(entity).with_origin(entity).into()
    }

    /// The scan from above, x up and y left.
    fn above<const N: usize>(&mut self, name: &str, shown: [Entity; N]) -> ContainerLike {
        let name = self.titled(&format!("{name}, rings {} m", step_m(self.extent.range_m)));
        let view = Spatial3DView::new(name).with_origin(self.origin()).with_contents(self.entities(shown));
        let height = (2.5 * self.extent.range_m) as f32; // the viewer's field of view is 55° from top to bottom
        self.seen_from(view, [0.0, 0.0, height], [1.0, 0.0, 0.0])
    }

    fn seen_from(&mut self, view: Spatial3DView, position: [f32; 3], up: [f32; 3]) -> ContainerLike {
        let eye = EyeControls3D::new()
            .with_kind(Eye3DKind::Orbital)
            .with_position(position)
            .with_look_target([0.0f32, 0.0, 0.0])
            .with_eye_up(up);
        let view = self.properties.with(view, "EyeControls3D", eye);
        let view = self.properties.with(view, "LineGrid3D", LineGrid3D::new().with_visible(false));
        self.properties.with(view, "Background", Background::new(BackgroundKind::SolidColor)) // of the theme
    }

    /// The upper triangle of a matrix, with clusters as bars along its edges and walls as frames around their blocks.
    pub(super) fn picture(&mut self, name: &str, entity: Entity) -> ContainerLike {
        let n = self.extent.places as f64;
        let shown = [entity, AFFINITY_SCALE, AFFINITY_MARKS, AFFINITY_ABSENT, KMEANS_LABELS, KMEANS_BLOCKS];
        self.flat(name, shown, [-0.06 * n, -0.06 * n, 1.03 * n, 1.03 * n])
    }

    pub(super) fn chart(&mut self, name: &str) -> ContainerLike {
        self.flat(name, [SPECTRAL_CHART, SPECTRAL_CHART_AXIS], chart_bounds())
    }

    /// Whether the affinity decides gap by gap.
    pub(super) fn by_gaps(&self) -> bool {
        self.extent.by_gaps
    }

    /// Whether the flight has its truth.
    pub(super) fn has_truth(&self) -> bool {
        self.extent.has_truth
    }

    /// The room at each gap beside the room that an opening needs.
    pub(super) fn gaps(&mut self, name: &str) -> ContainerLike {
        self.flat(name, [AFFINITY_GAPS, AFFINITY_GAPS_AXIS], gaps_bounds())
    }

    /// U as a picture, a band for each eigenvector, below a bar of the walls.
    pub(super) fn eigenvectors(&mut self, name: &str) -> ContainerLike {
        let n = self.extent.places as f64;
        let shown = [SPECTRAL_U_PICTURE, SPECTRAL_U_BARS, AFFINITY_ABSENT];
        self.flat(name, shown, [-0.12 * n, -0.08 * n, 1.03 * n, (HEIGHT + 0.05) * n])
    }

    /// The range of each beam, its wall and its cluster.
    pub(super) fn labels(&mut self, name: &str) -> ContainerLike {
        self.flat(name, [KMEANS_PROFILE, KMEANS_PROFILE_AXES, KMEANS_PROFILE_NAMES], profile_bounds())
    }

    fn flat<const N: usize>(&mut self, name: &str, shown: [Entity; N], visible: [f64; 4]) -> ContainerLike {
        let view = Spatial2DView::new(self.titled(name)).with_origin(self.origin());
        let view = view.with_contents(self.entities(shown));
        self.properties.with(view, "VisualBounds2D", bounds(visible))
    }

    /// The rows of U, from a corner.
    pub(super) fn embedding(&mut self) -> ContainerLike {
        let view = self.rows_of_u("3D");
        self.seen_from(view, [2.0, 2.5, 1.65], [0.0, 0.0, 1.0])
    }

    /// The first two columns of U.
    pub(super) fn embedding_plane(&mut self) -> ContainerLike {
        let view = self.rows_of_u("2D");
        self.seen_from(view, [0.0, 0.0, 2.6], [0.0, 1.0, 0.0])
    }

    fn rows_of_u(&self, name: &str) -> Spatial3DView {
        let contents = self.entities([SPECTRAL_EMBEDDING, SPECTRAL_AXES, KMEANS_CENTROIDS]);
        Spatial3DView::new(self.titled(name)).with_origin(self.origin()).with_contents(contents)
    }

    pub(super) fn answer(&self) -> ContainerLike {
        self.document("Answer", REPORT_SUMMARY)
    }

    pub(super) fn why(&self, name: &str) -> ContainerLike {
        self.document(name, REPORT_WHY)
    }

    pub(super) fn config(&mut self) -> ContainerLike {
        let view = self.document("Config", CONFIG);
        self.properties.with(view, "TextDocumentFormat", TextDocumentFormat::new().with_monospace(true))
    }

    /// A text.
    pub(super) fn document(&self, name: &str, entity: Entity) -> ContainerLike {
        TextDocumentView::new(self.titled(name)).with_origin(self.path(entity)).into()
    }

    /// Revolutions worth a look; a click selects one. Notes are left out.
    pub(super) fn worth(&mut self, name: &str) -> ContainerLike {
        let view = self.log(name);
        self.only(view, &["CRITICAL", "ERROR", "WARN", UNSURE])
    }

    /// Revolutions with a row of these levels in the log; a click selects one. The level is not shown.
    pub(super) fn listed(&mut self, name: &str, levels: &[&str]) -> ContainerLike {
        let view = self.log_of(name, &[datatypes::TextLogColumnKind::Body]);
        self.only(view, levels)
    }

    fn only(&mut self, view: ContainerLike, levels: &[&str]) -> ContainerLike {
        let shown = levels.iter().map(|level| components::TextLogLevel::from(*level));
        self.properties.with(view, "TextLogRows", TextLogRows::new().with_filter_by_log_level(shown))
    }

    /// Revolutions worth a look and notes; a click selects one.
    pub(super) fn log(&mut self, name: &str) -> ContainerLike {
        self.log_of(name, &[datatypes::TextLogColumnKind::LogLevel, datatypes::TextLogColumnKind::Body])
    }

    fn log_of(&mut self, name: &str, kinds: &[datatypes::TextLogColumnKind]) -> ContainerLike {
        self.log_at(self.titled(name), &self.path(LOG), kinds)
    }

    fn log_at(&mut self, title: String, entity: &str, kinds: &[datatypes::TextLogColumnKind]) -> ContainerLike {
        let view = TextLogView::new(title).with_origin(entity);
        let columns =
            kinds.iter().map(|kind| TextLogColumn(datatypes::TextLogColumn { visible: true.into(), kind: *kind }));
        self.properties.with(view, "TextLogColumns", TextLogColumns::new().with_text_log_columns(columns))
    }

    /// The walls that were counted, with the truth where the flight has one.
    pub(super) fn walls(&mut self) -> ContainerLike {
        let truth = if self.has_truth() { ", truth green" } else { "" };
        self.lines(&format!("Walls counted: orange{truth}"), [REPORT_JUNCTIONS, TRUTH_WALLS, REPORT_AXIS])
    }

    /// k, which also counts what is too small to be a wall: in a cluttered place many times the walls.
    pub(super) fn zeros(&mut self) -> ContainerLike {
        self.lines("k: blue, walls orange", [REPORT_JUNCTIONS, SPECTRAL_K, REPORT_AXIS])
    }

    pub(super) fn margin(&mut self) -> ContainerLike {
        self.lines("Margin of k [decades]", [SPECTRAL_MARGIN])
    }

    pub(super) fn confidence(&mut self) -> ContainerLike {
        let view = self.lines("Confidence [0 to 1]", [REPORT_CONFIDENCE]);
        self.properties.with(view, "ScalarAxis", ScalarAxis::new().with_range(Range1D::new(0.0, 1.05)))
    }

    pub(super) fn places(&mut self) -> ContainerLike {
        let contents = self.entities([REPORT_DOUBT, REPORT_PLACE]);
        self.strip(self.titled("Place and doubt: click to go there"), contents)
    }

    /// Strips of states over the whole flight.
    fn strip<const N: usize>(&mut self, title: String, contents: [String; N]) -> ContainerLike {
        let view = StateTimelineView::new(title).with_origin("/").with_contents(contents);
        self.properties.with(view, "TimeAxis", TimeAxis::new().with_link(LinkAxis::LinkToGlobal))
    }

    /// The way, walls, places and passages so far, from above.
    pub(super) fn flight_map(&self) -> ContainerLike {
        let contents = self.entities([
            FLIGHT_WALLS,
            FLIGHT_WALLS_NEW,
            FLIGHT_PATH,
            FLIGHT_UNSURE,
            FLIGHT_PASSAGES,
            FLIGHT_NODES,
            FLIGHT_SCALE,
            FLIGHT_POSE,
        ]);
        let view = Spatial2DView::new(self.titled("Map so far: vehicle violet, ways not taken pink, unsure yellow"));
        view.with_origin(self.origin()).with_contents(contents).into()
    }

    pub(super) fn flight_graph(&self) -> ContainerLike {
        let contents = self.entities([FLIGHT_GRAPH]);
        GraphView::new(self.titled("Junctions and dead ends")).with_origin(self.origin()).with_contents(contents).into()
    }

    /// Lines of two flights in one plot.
    pub(super) fn lines_of_both(&mut self, name: &str, entity: &str) -> ContainerLike {
        let view = TimeSeriesView::new(name).with_origin(entity);
        let view = self.properties.with(view, "TimeAxis", whole_flight());
        self.properties.with(view, "PlotLegend", PlotLegend::new().with_visible(false))
    }

    /// Where this flight and another differ, and the places of both.
    pub(super) fn strip_of_both(&mut self, other: &Self) -> ContainerLike {
        let contents = [
            format!("+ {DIFFERS}"),
            format!("+ {}", self.path(REPORT_PLACE)),
            format!("+ {}", other.path(REPORT_PLACE)),
        ];
        self.strip("Where they differ (walls left | right), places: click to go there".to_owned(), contents)
    }

    /// The revolutions from which on two flights differ.
    pub(super) fn differences(&mut self) -> ContainerLike {
        self.log_at("Where they differ: click one".to_owned(), DIFFERS_LOG, &[datatypes::TextLogColumnKind::Body])
    }

    /// How two flights differ, in words.
    pub(super) fn differences_in_words(&self) -> ContainerLike {
        TextDocumentView::new("What differs").with_origin(DIFFERS_SUMMARY).into()
    }

    pub(super) fn flight_places(&mut self) -> ContainerLike {
        let contents = self.entities([REPORT_DOUBT, FLIGHT_HERE, REPORT_PLACE]);
        self.strip(self.titled("Doubt, and place: steady, and of each scan; click to go there"), contents)
    }

    pub(super) fn timings(&mut self) -> ContainerLike {
        let [ingest, affinity, spectral, kmeans, report] = TIMING;
        let shown = [ingest, affinity, spectral, kmeans, report, TIMING_FLIGHT];
        let view = self.plot("Time per stage [ms] over revolutions", shown);
        self.properties.with(view, "PlotLegend", PlotLegend::new().with_corner(Corner2D::LeftTop))
    }

    pub(super) fn total(&mut self) -> ContainerLike {
        self.lines("All stages together (orange), from scan to scan (grey) [ms]", [TIMING_TOTAL])
    }

    pub(super) fn returns_count(&mut self) -> ContainerLike {
        self.lines("Returns in a revolution", [SCAN_COUNT])
    }

    /// A plot of one or two lines, which its title names. It has no legend, which would hide a part of them.
    fn lines<const N: usize>(&mut self, name: &str, shown: [Entity; N]) -> ContainerLike {
        let view = self.plot(name, shown);
        self.properties.with(view, "PlotLegend", PlotLegend::new().with_visible(false))
    }

    fn plot<const N: usize>(&mut self, name: &str, shown: [Entity; N]) -> ContainerLike {
        let view = TimeSeriesView::new(self.titled(name)).with_origin(self.origin());
        let view = view.with_contents(self.entities(shown));
        self.properties.with(view, "TimeAxis", whole_flight())
    }
}

/// The time axis of a plot of the whole flight. A plot that is linked shows a part of a long flight.
fn whole_flight() -> TimeAxis {
    TimeAxis::new().with_link(LinkAxis::Independent).with_view_range(rerun::datatypes::TimeRange::EVERYTHING)
}

/// The bounds of a 2D view: left, top, right and bottom.
fn bounds([left, top, right, bottom]: [f64; 4]) -> VisualBounds2D {
    let range = rerun::datatypes::Range2D {
        x_range: rerun::datatypes::Range1D([left, right]),
        y_range: rerun::datatypes::Range1D([top, bottom]),
    };
    VisualBounds2D::new(rerun::blueprint::components::VisualBounds2D(range))
}
