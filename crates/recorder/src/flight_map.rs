//! The map of the flight so far: where the vehicle was, the walls that it saw, places and passages, and why visits are
//! taken to be to one place. From above, x to the right, in the frame of the first pose.

use crosscut_flight::{Anchored, FlightAnswer, HereKind, Map, MapDrawing, Mapper, NoPlace, Node};
use crosscut_stage::{Frame, counted, junction_of, unit};
use nalgebra::Point2;
use rerun::{
    Arrows2D, AsComponents, GraphEdges, GraphNodes, LineStrips2D, Points2D, RecordingStream, RecordingStreamResult,
    StateChange, StateConfiguration, TextDocument, TextLog, TextLogLevel,
};

use crate::colors::{GREY, OPENING, REPORTED, UNSURE, VEHICLE, WORDS, color};
use crate::rows::Rows;
use crate::scan::step_m;
use crate::schema::{
    FLIGHT_GRAPH, FLIGHT_HERE, FLIGHT_NODES, FLIGHT_PASSAGES, FLIGHT_PATH, FLIGHT_POSE, FLIGHT_SCALE, FLIGHT_SUMMARY,
    FLIGHT_UNSURE, FLIGHT_WALLS, FLIGHT_WALLS_NEW, LOG,
};
use crate::tensors::f64_vector;
use crate::words::words;

/// Way and walls are drawn again when the way has grown by this length at least.
const DRAWN_EVERY_M: f64 = 2.0;
/// Way and walls are drawn again when the way has grown by this share of itself at least: what is written then grows with the
/// way, not with its square.
const DRAWN_EVERY_SHARE: f64 = 0.02;
/// All walls are drawn again once this share is new.
const NEW_SHARE: f64 = 0.25;
/// Length of the line from the vehicle's disc to where it heads.
const AHEAD_M: f64 = 1.0;
/// Length of the arrows of ways, if they are no longer than this share of the whole way.
const WAY_M: f64 = 3.0;
const WAY_SHARE: f64 = 0.25;
/// A graph view is laid out in points of the screen; this many are a metre.
const GRAPH_PER_M: f64 = 8.0;
/// The summary shows this many of the last merges and refusals.
const SHOWN_REASONS: usize = 8;

/// A passage, and a way that was taken.
const PASSAGE: u32 = 0x56B4_E9FF;
/// Names and colours of places.
const HERE: [(&str, u32); 4] =
    [("junction", REPORTED), ("passage", PASSAGE), ("dead_end", GREY), ("chamber", 0x009E_73FF)];

/// Follows the map, and keeps what is drawn of the way.
#[derive(Default)]
pub(crate) struct FlightMap {
    mapper: Mapper,
    no_place: NoPlace,
    seen: MapDrawing,
    /// What was drawn last: the map, the number of places of the path, and of the walls, those in `/flight/walls` and all.
    drawn: Map,
    drawn_path: usize,
    drawn_walls: [usize; 2],
    drawn_way_m: f64,
    /// Visits, merges and refusals that have been drawn and logged.
    told: [usize; 3],
}

/// Names, colours and sizes.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let ui = rerun::Radius::new_ui_points;
    let (names, colors): (Vec<_>, Vec<_>) = HERE.into_iter().unzip();
    let here = StateConfiguration::new()
        .with_labels(names.iter().map(|name| name.replace('_', " ")))
        .with_values(names)
        .with_colors(colors.into_iter().map(color));
    rec.log_static(FLIGHT_HERE.path, &here)?;
    let line = |rgba, radius| LineStrips2D::update_fields().with_colors([color(rgba)]).with_radii([ui(radius)]);
    let disc = Points2D::update_fields().with_radii([ui(5.0)]).with_colors([color(VEHICLE)]);
    rec.log_static(FLIGHT_POSE.path, &[&line(VEHICLE, 2.0) as &dyn AsComponents, &disc])?;
    rec.log_static(FLIGHT_SCALE.path, &line(WORDS, 1.5))?;
    rec.log_static(FLIGHT_PATH.path, &line(GREY, 0.7))?;
    rec.log_static(FLIGHT_PASSAGES.path, &line(PASSAGE, 2.0))?;
    let beads = Points2D::update_fields().with_colors([color(UNSURE)]).with_radii([ui(3.0)]);
    rec.log_static(FLIGHT_UNSURE.path, &beads)?;
    let points = Points2D::update_fields().with_colors([color(WORDS)]).with_radii([ui(1.5)]);
    rec.log_static(FLIGHT_WALLS.path, &points)?;
    rec.log_static(FLIGHT_WALLS_NEW.path, &points)
}

impl FlightMap {
    /// Takes the next frame, recorded or not.
    pub(crate) fn add(&mut self, frame: &Frame) {
        self.mapper.add(frame);
        self.no_place.add(frame);
        self.seen.add(frame, &self.mapper);
    }

    /// Where something lies by what is known now.
    fn at(&self, anchored: &Anchored) -> Point2<f64> {
        Point2::from(self.mapper.placed(anchored).translation.vector)
    }

    /// Logs the pose and the place of a frame that was added, and the map if it has changed. In a new file, `again`, what was
    /// drawn last is repeated.
    pub(crate) fn log(&mut self, rows: &mut Rows, frame: &Frame, again: bool) {
        let Some(tracked) = FlightAnswer::of(frame).pose else { return };
        let pose = self.mapper.placed(&self.mapper.anchored(tracked));
        let yaw_rad = pose.rotation.angle();
        let exact = f64_vector(vec![pose.translation.x, pose.translation.y, yaw_rad], FLIGHT_POSE.dims);
        // A disc has the same size on the screen at every scale.
        let [at, ahead] = [0.0, AHEAD_M].map(|x| drawn(&(pose * Point2::new(x, 0.0))));
        let vehicle = LineStrips2D::new([[at, ahead]]);
        let disc = Points2D::new([at]);
        rows.log_tensor(&FLIGHT_POSE, exact, &[&vehicle, &disc]);
        if let Some(here) = FlightAnswer::of(frame).steady_here() {
            rows.log(&FLIGHT_HERE, &StateChange::single(here.kind.name()));
        }
        let visits = self.mapper.poses().len();
        let due_m = DRAWN_EVERY_M.max(DRAWN_EVERY_SHARE * self.seen.way_m());
        let is_way_due = self.drawn_path == 0 || self.seen.way_m() - self.drawn_way_m > due_m;
        let mut is_corrected = false;
        if is_way_due || visits != self.told[0] {
            let map = self.mapper.map();
            self.log_reasons(rows, &map);
            is_corrected = map.merges.len() != self.told[1];
            self.told = [visits, map.merges.len(), map.refusals.len()];
            self.drawn = map;
        } else if !again {
            return;
        }
        let whole_before = self.drawn_walls[0];
        if is_way_due || is_corrected {
            self.add_drawn(is_corrected);
        }
        if is_way_due || is_corrected || again {
            self.log_way(rows, again || is_corrected || self.drawn_walls[0] != whole_before);
        }
        let arrow_m = WAY_M.min(WAY_SHARE * self.seen.way_m());
        log_map(rows, &self.drawn, arrow_m, self.no_place.reason(&self.drawn), self.unsure_share());
    }

    /// Of the way that is drawn, the places where the answer was unsure.
    fn unsure(&self) -> impl Iterator<Item = &Anchored> {
        let path = &self.seen.path()[..self.drawn_path];
        self.seen.unsure_at().iter().filter_map(|at| path.get(*at))
    }

    fn unsure_share(&self) -> f64 {
        self.unsure().count() as f64 / self.drawn_path.max(1) as f64
    }

    /// Merges and refusals that are new.
    fn log_reasons(&self, rows: &mut Rows, map: &Map) {
        let merges =
            map.merges.iter().skip(self.told[1]).map(|merge| format!("node {} again: {}", merge.node, merge.why));
        for reason in merges.chain(map.refusals.iter().skip(self.told[2]).map(|refusal| refusal.why.clone())) {
            rows.log(&LOG, &TextLog::new(format!("map: {reason}")).with_level(TextLogLevel::INFO));
        }
    }

    /// Adds what is new to what is drawn; all of it again if the drift was corrected.
    fn add_drawn(&mut self, is_corrected: bool) {
        (self.drawn_path, self.drawn_way_m) = (self.seen.path().len(), self.seen.way_m());
        let [whole, _] = self.drawn_walls;
        let new = self.seen.walls().len() - whole;
        let is_whole = is_corrected || new as f64 > NEW_SHARE * whole as f64;
        self.drawn_walls = [if is_whole { self.seen.walls().len() } else { whole }, self.seen.walls().len()];
    }

    fn log_way(&self, rows: &mut Rows, with_whole: bool) {
        let mut left = self.drawn_path;
        let stretches = self.seen.stretches().map(|stretch| {
            let path = stretch.iter().take(left).map(|place| drawn(&self.at(place))).collect::<Vec<_>>();
            left -= path.len();
            path
        });
        rows.log(&FLIGHT_PATH, &LineStrips2D::new(stretches.filter(|path| !path.is_empty())));
        let unsure = self.unsure().map(|place| drawn(&self.at(place))).collect::<Vec<_>>();
        if !unsure.is_empty() {
            rows.log(&FLIGHT_UNSURE, &Points2D::new(unsure));
        }
        let [whole, all] = self.drawn_walls;
        let places = |walls: &[Anchored]| walls.iter().map(|wall| drawn(&self.at(wall))).collect::<Vec<_>>();
        if with_whole {
            rows.log(&FLIGHT_WALLS, &Points2D::new(places(&self.seen.walls()[..whole])));
        }
        rows.log(&FLIGHT_WALLS_NEW, &Points2D::new(places(&self.seen.walls()[whole..all])));
        log_scale(rows, places(&self.seen.walls()[..all]));
    }
}

/// A bar of a round length below the walls, and the length.
fn log_scale(rows: &mut Rows, walls: Vec<[f32; 2]>) {
    let Some(&first) = walls.first() else { return };
    let ends = walls
        .iter()
        .fold([first; 2], |[low, high], [x, y]| [[low[0].min(*x), low[1].min(*y)], [high[0].max(*x), high[1].max(*y)]]);
    let [[left, top], [right, bottom]] = ends;
    let length_m = step_m(f64::from(right - left));
    // The viewer writes the length below the bar, where it would be cut off at the edge of the view.
    let y = bottom - 0.05 * (bottom - top);
    let bar = LineStrips2D::new([[[left, y], [left + length_m as f32, y]]]);
    let name = words([([left + 0.5 * length_m as f32, y], format!("{length_m} m"))]);
    rows.log(&FLIGHT_SCALE, &[&bar as &dyn AsComponents, &name]);
}

/// Nodes with their ways, passages, the graph, and all in words.
fn log_map(rows: &mut Rows, map: &Map, arrow_m: f64, no_place: Option<String>, unsure_share: f64) {
    let passages = map.passages.iter().map(|passage| map.course_m(passage).map(drawn).collect::<Vec<_>>());
    rows.log(&FLIGHT_PASSAGES, &LineStrips2D::new(passages));
    let ways = || map.nodes.iter().flat_map(|node| node.ways.iter().map(move |way| (node, way)));
    let arrows = Arrows2D::from_vectors(ways().map(|(_, way)| drawn(&(arrow_m * unit(way.bearing_rad)).into())))
        .with_origins(ways().map(|(node, _)| drawn(&node.position_m)))
        .with_colors(ways().map(|(_, way)| color(if way.taken { PASSAGE } else { OPENING })));
    let numbers = (0..map.nodes.len()).map(|id| id.to_string());
    let nodes = Points2D::new(map.nodes.iter().map(|node| drawn(&node.position_m)))
        .with_labels(numbers.clone())
        .with_show_labels(true)
        .with_radii([rerun::Radius::new_ui_points(5.0)])
        .with_colors(map.nodes.iter().map(|node| color(color_of(node))));
    rows.log(&FLIGHT_NODES, &[&arrows as &dyn AsComponents, &nodes]);
    let graph = GraphNodes::new(numbers)
        .with_positions(map.nodes.iter().map(|node| drawn(&node.position_m).map(|along| along * GRAPH_PER_M as f32)))
        .with_labels(map.nodes.iter().enumerate().map(|(id, node)| format!("{id}: {}", kind_of(node))))
        .with_colors(map.nodes.iter().map(|node| color(color_of(node))));
    let edges = map.passages.iter().map(|passage| (passage.from.to_string(), passage.to.to_string()));
    let edges = GraphEdges::new(edges).with_undirected_edges();
    rows.log(&FLIGHT_GRAPH, &[&graph as &dyn AsComponents, &edges]);
    rows.log(&FLIGHT_SUMMARY, &TextDocument::from_markdown(summary(map, no_place, unsure_share)));
}

/// In a view whose y axis points down.
fn drawn(place_m: &Point2<f64>) -> [f32; 2] {
    [place_m.x as f32, -place_m.y as f32]
}

fn color_of(node: &Node) -> u32 {
    if node.kind == HereKind::Junction { REPORTED } else { GREY }
}

fn kind_of(node: &Node) -> String {
    match (node.kind, node.ways.len()) {
        (HereKind::DeadEnd, _) => "dead end".to_owned(),
        (_, ways) => junction_of(ways),
    }
}

fn summary(map: &Map, no_place: Option<String>, unsure_share: f64) -> String {
    let is_lost = map.stretches_from_ns.len() > 1;
    let mut lines = vec![no_place.map_or_else(|| format!("## {}\n", map.summary()), |reason| format!("## {reason}\n"))];
    if unsure_share > 0.0 {
        lines.push(format!("Unsure on {:.0} % of the way: *yellow* on the map.\n", (100.0 * unsure_share).max(1.0)));
    }
    if !map.nodes.is_empty() {
        let stretch = if is_lost { [" stretch |", "---|"] } else { [""; 2] };
        lines
            .push(format!("| node | place | ways not taken | visits |{}\n|---|---|---|---|{}", stretch[0], stretch[1]));
    }
    for (id, node) in map.nodes.iter().enumerate() {
        let not_taken = node.ways.iter().filter(|way| !way.taken);
        let not_taken: Vec<_> = not_taken.map(|way| format!("{:+.0}°", way.bearing_rad.to_degrees())).collect();
        let stretch = if is_lost { format!(" {} |", map.stretch_of(node) + 1) } else { String::new() };
        let visits = node.visits.len();
        lines.push(format!("| {id} | {} | {} | {visits} |{stretch}", kind_of(node), not_taken.join(", ")));
    }
    let merges = map.merges.iter().map(|merge| (merge.at_ns, format!("node {} again: {}", merge.node, merge.why)));
    let refusals = map.refusals.iter().map(|refusal| (refusal.at_ns, refusal.why.clone()));
    let mut reasons: Vec<_> = merges.chain(refusals).collect();
    reasons.sort();
    if !reasons.is_empty() {
        let all = counted(reasons.len() as u64, "decision");
        lines.push(format!("\nThe last of {all} whether a place was seen before:\n"));
    }
    lines.extend(reasons.iter().rev().take(SHOWN_REASONS).map(|(_, why)| format!("- {why}")));
    lines.join("\n")
}
