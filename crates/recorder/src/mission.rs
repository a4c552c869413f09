//! A mission in closed loop, seen from above in the frame of its map: vehicle, scan, openings, where it heads for and why,
//! and the map as it grows. All stages of each revolution are recorded beside it, as those of a flight.
//!
//! | entity | what it holds |
//! |---|---|
//! | `/mission/mine` | the true outline, static: the vehicle does not know it |
//! | `/mission/vehicle`, `/mission/trail` | where the vehicle is by its own map, and the way that it came |
//! | `/mission/scan`, `/mission/openings` | the returns coloured by wall, and the edges of the openings |
//! | `/mission/goal`, `/mission/choice` | where it heads for now, and the way chosen last |
//! | `/mission/map/passages`, `/mission/map/ways`, `/mission/map/places` | the map: ways taken blue, the others pink |
//! | `/mission/scale` | a bar to read distances by, static |
//! | `/mission/outcome` | what became of the mission, static; written at its end |
//! | `/mission/why`, `/mission/log` | the last decision in words, and all of them |
//! | `/mission/walls`, `/mission/new_ways` | the count of walls, and the number of ways left, over revolutions |

use crosscut_flight::{HereKind, Map, Node, NodeWay};
use crosscut_stage::{Frame, Observer as _, ObserverError, counted};
use nalgebra::{Isometry2, Point2};
use rerun::{Arrows3D, LineStrips3D, Points3D, Radius, Scalars, TextDocument, TextLog, TextLogLevel};

use crate::colors::{LABEL, REPORTED, color};
use crate::layout::mission::entities;
use crate::mine::{Mine, NEW, above};
use crate::options::{RecorderError, RecorderOptions};
use crate::recorder::Recorder;
use crate::rows::Rows;
use crate::tracks::{Classes, Tracks};

/// A way of a place on the map that was taken, as on the page of the map.
const TAKEN: u32 = 0x0072_B2FF;

/// The trail is written anew after this many revolutions.
const TRAIL_EVERY: u64 = 10;

/// Places of the trail are this far apart, m.
const TRAIL_STEP_M: f64 = 0.3;

/// Length of the vehicle's arrow, of the arrow along a chosen way, and of a way on the map, m.
const VEHICLE_M: f64 = 1.6;
const CHOICE_M: f64 = 5.0;
const WAY_M: f64 = 2.5;

/// One revolution of a mission. Positions are in the frame of the map.
#[derive(Debug)]
pub struct MissionMoment<'a> {
    /// All that is known of the revolution.
    pub frame: &'a Frame,
    /// The vehicle.
    pub vehicle: Isometry2<f64>,
    /// Where it heads for.
    pub goal_m: Point2<f64>,
    /// What it is doing, in a word.
    pub doing: &'a str,
    /// The decision that was taken at this revolution.
    pub decision: Option<MissionDecision<'a>>,
    /// The map, at revolutions at which it is to be drawn anew.
    pub map: Option<Map>,
}

/// A decision of the planner.
#[derive(Clone, Copy, Debug)]
pub struct MissionDecision<'a> {
    /// The place on the map, if it has one here.
    pub place: Option<usize>,
    /// The direction that was chosen.
    pub bearing_rad: f64,
    /// Why.
    pub why: &'a str,
}

/// Records a mission for the Rerun viewer.
pub struct MissionRecorder {
    recorder: Recorder,
    tracks: Tracks,
    trail_m: Vec<Point2<f64>>,
}

impl MissionRecorder {
    /// Opens the file and writes all that holds for the whole mission. `mine_m` is the true outline in segments.
    ///
    /// # Errors
    /// As [`Recorder::new`].
    pub fn new(options: RecorderOptions, mine_m: &[[Point2<f64>; 2]]) -> Result<Self, RecorderError> {
        let recorder = Recorder::of_mission(options, Mine::new(mine_m))?;
        Ok(Self { recorder, tracks: Tracks::default(), trail_m: Vec::new() })
    }

    /// Adds the next revolution: the mission as a whole, the stages as the scope of the recording states.
    ///
    /// # Errors
    /// When a write has failed.
    pub fn add(&mut self, moment: &MissionMoment) -> Result<(), ObserverError> {
        self.recorder.observe(moment.frame)?;
        let rows = self.recorder.rows();
        rows.set_time(moment.frame.revolution.seq, moment.frame.revolution.stamp_ns);
        log_vehicle(rows, moment, &mut self.trail_m);
        log_seen(rows, moment, &self.tracks.classes_of(moment.frame));
        if let Some(decision) = &moment.decision {
            log_decision(rows, moment, decision);
        }
        if let Some(map) = &moment.map {
            log_map(rows, map);
        }
        Ok(())
    }

    /// Ends the file, with what became of the mission as Markdown.
    ///
    /// # Errors
    /// When a write has failed.
    pub fn finish(&mut self, outcome: &str) -> Result<(), ObserverError> {
        let logged = self.recorder.log_static_text(entities::OUTCOME, outcome);
        self.recorder.finish()?;
        logged
    }
}

fn log_vehicle(rows: &mut Rows, moment: &MissionMoment, trail_m: &mut Vec<Point2<f64>>) {
    let at_m = Point2::from(moment.vehicle.translation.vector);
    let arrow =
        Arrows3D::from_vectors([along(moment.vehicle.rotation.angle(), VEHICLE_M)]).with_origins([above(at_m, 0.3)]);
    rows.log_at(entities::VEHICLE, &arrow);
    let is_far = trail_m.last().is_none_or(|last_m| (at_m - last_m).norm() > TRAIL_STEP_M);
    if is_far {
        trail_m.push(at_m);
    }
    if moment.frame.revolution.seq.is_multiple_of(TRAIL_EVERY) {
        let line = trail_m.iter().map(|place_m| above(*place_m, 0.1));
        rows.log_at(entities::TRAIL, &LineStrips3D::new([line.collect::<Vec<_>>()]));
    }
    let goal = LineStrips3D::new([[above(at_m, 0.2), above(moment.goal_m, 0.2)]]);
    rows.log_at(entities::GOAL, &goal);
}

fn log_seen(rows: &mut Rows, moment: &MissionMoment, classes: &Classes) {
    let (frame, vehicle) = (moment.frame, moment.vehicle);
    let placed = |point: &crosscut_stage::Point| above(vehicle * Point2::new(point.x, point.y), 0.0);
    let wall_of = |i: usize| frame.junction.wall_of_return.get(i).copied().flatten();
    let of_returns = (0..frame.revolution.len()).map(|i| classes.of_wall(wall_of(i)));
    let points = Points3D::new(frame.revolution.points_m.iter().map(placed)).with_class_ids(of_returns);
    rows.log_at(entities::SCAN, &points);
    let edges = frame.junction.openings.iter().map(|opening| opening.edge_m.map(|end_m| placed(&end_m)));
    rows.log_at(entities::OPENINGS, &LineStrips3D::new(edges));
    rows.log_at(entities::WALLS, &Scalars::single(frame.junction.junctions as f64));
}

fn log_decision(rows: &mut Rows, moment: &MissionMoment, decision: &MissionDecision) {
    let at_m = Point2::from(moment.vehicle.translation.vector);
    let arrow = Arrows3D::from_vectors([along(decision.bearing_rad, CHOICE_M)]).with_origins([above(at_m, 0.4)]);
    rows.log_at(entities::CHOICE, &arrow);
    let place = decision.place.map_or_else(|| "No place of the map".to_owned(), |place| format!("Place {place}"));
    let why = decision.why;
    rows.log_at(entities::LOG, &TextLog::new(format!("{place}: {why}")).with_level(TextLogLevel::INFO));
    let (seen, seq) = (moment.frame.junction.junctions as u64, moment.frame.revolution.seq);
    let text = format!(
        "**{place}, revolution {seq}: {why}.**\n\n{} in view; the vehicle {}. Why {seen}: page *Stages*, at revolution {seq}.",
        counted(seen, "wall"),
        moment.doing
    );
    rows.log_at(entities::WHY, &TextDocument::from_markdown(text));
}

fn log_map(rows: &mut Rows, map: &Map) {
    let courses = map.passages.iter().map(|of| map.course_m(of).map(|place_m| above(*place_m, 0.5)).collect());
    rows.log_at(entities::PASSAGES, &LineStrips3D::new(courses.collect::<Vec<Vec<[f32; 3]>>>()));
    // A dead end has no way to explore.
    let is_taken = |node: &Node, way: &NodeWay| way.taken || node.kind != HereKind::Junction;
    let ways = || map.nodes.iter().flat_map(|node| node.ways.iter().map(move |way| (node, way)));
    let of_way = |(node, way): (&Node, &NodeWay)| {
        let [x, y, _] = along(way.bearing_rad, WAY_M).map(f64::from);
        [above(node.position_m, 0.6), above(node.position_m + nalgebra::Vector2::new(x, y), 0.6)]
    };
    let colors = ways().map(|(node, way)| color(if is_taken(node, way) { TAKEN } else { NEW }));
    rows.log_at(entities::WAYS, &LineStrips3D::new(ways().map(of_way)).with_colors(colors));
    let labels = (0..map.nodes.len()).map(|number| number.to_string());
    let is_junction = |node: &Node| node.kind == HereKind::Junction;
    let radii = map.nodes.iter().map(|node| Radius::new_ui_points(if is_junction(node) { 7.0 } else { 4.0 }));
    let places = Points3D::new(map.nodes.iter().map(|node| above(node.position_m, 0.7)))
        .with_labels(labels)
        .with_show_labels(true)
        .with_radii(radii)
        .with_colors(map.nodes.iter().map(|node| color(if is_junction(node) { REPORTED } else { LABEL })));
    rows.log_at(entities::PLACES, &places);
    rows.log_at(entities::NEW_WAYS, &Scalars::single(map.ways_not_taken() as f64));
}

fn along(bearing_rad: f64, length_m: f64) -> [f32; 3] {
    [(length_m * bearing_rad.cos()) as f32, (length_m * bearing_rad.sin()) as f32, 0.0]
}
