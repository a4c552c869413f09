//! The map of the flight so far: where the vehicle was, the walls that it saw, places and passages, and why visits are
//! taken to be to one place. From above, x to the right, in the frame of the first pose.

use std::collections::BTreeSet;

use crosscut_flight::{Anchored, FlightAnswer, HereKind, Map, Mapper, Node};
use crosscut_stage::{Frame, Point, counted, unit};
use nalgebra::{Isometry2, Point2};
use rerun::{
    Arrows2D, AsComponents, GraphEdges, GraphNodes, LineStrips2D, Points2D, RecordingStream, RecordingStreamResult,
    StateChange, StateConfiguration, TextDocument, TextLog, TextLogLevel,
};

use crate::colors::{GREY, OPENING, REPORTED, WORDS, color};
use crate::rows::Rows;
use crate::schema::{
    FLIGHT_GRAPH, FLIGHT_HERE, FLIGHT_NODES, FLIGHT_PASSAGES, FLIGHT_PATH, FLIGHT_POSE, FLIGHT_SUMMARY, FLIGHT_WALLS,
    FLIGHT_WALLS_NEW, LOG,
};
use crate::tensors::f64_vector;

/// Way and walls are drawn again when the way has grown by this length at least.
const DRAWN_EVERY_M: f64 = 2.0;
/// Way and walls are drawn again when the way has grown by this share of itself at least: what is written then grows with the
/// way, not with its square.
const DRAWN_EVERY_SHARE: f64 = 0.02;
/// Points of the path are this far apart.
const PATH_M: f64 = 0.5;
/// Walls are recorded as the points that lie in other squares of this side than those before.
const CELL_M: f64 = 0.2;
/// Walls are added to the drawing each time the vehicle has moved this far.
const WALLS_EVERY_M: f64 = 0.7;
/// Returns farther than this add little, and are drawn where the heading of the pose is uncertain.
const WALLS_WITHIN_M: f64 = 12.0;
/// All walls are drawn again once this share is new.
const NEW_SHARE: f64 = 0.25;
/// Length of the arrows of ways.
const WAY_M: f64 = 3.0;
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
    path: Vec<Anchored>,
    way_m: f64,
    walls: Vec<Anchored>,
    cells: BTreeSet<[i64; 2]>,
    walls_from: Option<Point2<f64>>,
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
    rec.log_static(FLIGHT_POSE.path, &line(OPENING, 2.0))?;
    rec.log_static(FLIGHT_PATH.path, &line(GREY, 0.7))?;
    rec.log_static(FLIGHT_PASSAGES.path, &line(PASSAGE, 2.0))?;
    let points = Points2D::update_fields().with_colors([color(WORDS)]).with_radii([ui(1.0)]);
    rec.log_static(FLIGHT_WALLS.path, &points)?;
    rec.log_static(FLIGHT_WALLS_NEW.path, &points)
}

impl FlightMap {
    /// Takes the next frame, recorded or not.
    pub(crate) fn add(&mut self, frame: &Frame) {
        self.mapper.add(frame);
        let Some(pose) = FlightAnswer::of(frame).pose else { return };
        let here = self.mapper.anchored(pose);
        let at_m = self.at(&here);
        let since_last_m = self.path.last().map(|last| (self.at(last) - at_m).norm());
        if since_last_m.is_none_or(|since_last_m| since_last_m > PATH_M) {
            self.path.push(here);
            self.way_m += since_last_m.unwrap_or(0.0);
        }
        if self.walls_from.is_none_or(|from| (from - at_m).norm() > WALLS_EVERY_M) {
            self.walls_from = Some(at_m);
            let near = frame.revolution.points_m.iter().map(Point::xy);
            for point_m in near.filter(|point_m| point_m.coords.norm() < WALLS_WITHIN_M) {
                let wall = Anchored { visit: here.visit, pose: here.pose * Isometry2::from(point_m.coords) };
                let at_m = self.at(&wall);
                if self.cells.insert([at_m.x, at_m.y].map(|along_m| (along_m / CELL_M).floor() as i64)) {
                    self.walls.push(wall);
                }
            }
        }
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
        let outline = [[1.2, 0.0], [-0.8, 0.5], [-0.4, 0.0], [-0.8, -0.5], [1.2, 0.0]];
        let vehicle = LineStrips2D::new([outline.map(|[x, y]| drawn(&(pose * Point2::new(x, y))))]);
        rows.log(&FLIGHT_POSE, &[&vehicle as &dyn AsComponents, &exact]);
        if let Some(here) = FlightAnswer::of(frame).steady_here() {
            rows.log(&FLIGHT_HERE, &StateChange::single(here.kind.name()));
        }
        let visits = self.mapper.poses().len();
        let due_m = DRAWN_EVERY_M.max(DRAWN_EVERY_SHARE * self.way_m);
        let is_way_due = self.drawn_path == 0 || self.way_m - self.drawn_way_m > due_m;
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
        log_map(rows, &self.drawn);
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
        (self.drawn_path, self.drawn_way_m) = (self.path.len(), self.way_m);
        let [whole, _] = self.drawn_walls;
        let new = self.walls.len() - whole;
        let is_whole = is_corrected || new as f64 > NEW_SHARE * whole as f64;
        self.drawn_walls = [if is_whole { self.walls.len() } else { whole }, self.walls.len()];
    }

    fn log_way(&self, rows: &mut Rows, with_whole: bool) {
        let path = self.path[..self.drawn_path].iter().map(|place| drawn(&self.at(place))).collect::<Vec<_>>();
        rows.log(&FLIGHT_PATH, &LineStrips2D::new([path]));
        let [whole, all] = self.drawn_walls;
        let places = |walls: &[Anchored]| walls.iter().map(|wall| drawn(&self.at(wall))).collect::<Vec<_>>();
        if with_whole {
            rows.log(&FLIGHT_WALLS, &Points2D::new(places(&self.walls[..whole])));
        }
        rows.log(&FLIGHT_WALLS_NEW, &Points2D::new(places(&self.walls[whole..all])));
    }
}

/// Nodes with their ways, passages, the graph, and all in words.
fn log_map(rows: &mut Rows, map: &Map) {
    let passages = map.passages.iter().map(|passage| map.course_m(passage).map(drawn).collect::<Vec<_>>());
    rows.log(&FLIGHT_PASSAGES, &LineStrips2D::new(passages));
    let ways = || map.nodes.iter().flat_map(|node| node.ways.iter().map(move |way| (node, way)));
    let arrows = Arrows2D::from_vectors(ways().map(|(_, way)| drawn(&(WAY_M * unit(way.bearing_rad)).into())))
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
    rows.log(&FLIGHT_SUMMARY, &TextDocument::from_markdown(summary(map)));
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
        (_, 3) => "tee".to_owned(),
        (_, 4) => "crossing".to_owned(),
        (_, ways) => format!("{ways} ways"),
    }
}

fn summary(map: &Map) -> String {
    let mut lines = vec![format!("# {}\n", map.summary())];
    if !map.nodes.is_empty() {
        lines.push("| node | place | ways not taken | visits |\n|---|---|---|---|".to_owned());
    }
    for (id, node) in map.nodes.iter().enumerate() {
        let not_taken = node.ways.iter().filter(|way| !way.taken);
        let not_taken: Vec<_> = not_taken.map(|way| format!("{:+.0}°", way.bearing_rad.to_degrees())).collect();
        lines.push(format!("| {id} | {} | {} | {} |", kind_of(node), not_taken.join(", "), node.visits.len()));
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
