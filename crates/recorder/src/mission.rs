//! A mission in closed loop, seen from above in the frame of its map: vehicle, scan, openings, where it heads for and why,
//! and the map as it grows.
//!
//! | entity | what it holds |
//! |---|---|
//! | `/mission/mine` | the true outline, static: the vehicle does not know it |
//! | `/mission/vehicle`, `/mission/trail` | where the vehicle is by its own map, and the way that it came |
//! | `/mission/scan`, `/mission/openings` | the returns coloured by wall, and the edges of the openings |
//! | `/mission/goal`, `/mission/choice` | where it heads for now, and the way chosen last |
//! | `/mission/map/passages`, `/mission/map/ways`, `/mission/map/places` | the map: ways taken blue, new ones red |
//! | `/mission/why`, `/mission/log` | the last decision in words, and all of them |
//! | `/mission/walls`, `/mission/new_ways` | the count of walls, and the number of ways left, over revolutions |

use std::path::Path;

use crosscut_flight::{HereKind, Map, Node, NodeWay};
use crosscut_stage::Frame;
use nalgebra::{Isometry2, Point2};
use rerun::log::ChunkBatcherConfig;
use rerun::sink::LogSink;
use rerun::{
    Arrows3D, AsComponents, LineStrips3D, MediaType, Points3D, Radius, RecordingStream, RecordingStreamBuilder,
    Scalars, TextDocument, TextLog, TextLogLevel,
};

use crate::colors::{EDGE, GREY, OPENING, REPORTED, WORDS, ZEROS, annotation_context, color, series};
use crate::file::RrdFile;
use crate::layout::mission::{self, ENTITIES};
use crate::options::RecorderError;
use crate::schema::{COLORS, CONFIG};
use crate::tracks::Tracks;

/// A way of a place on the map that was taken, and one that was not.
const TAKEN: u32 = 0x0072_B2FF;
const NEW: u32 = 0xD55E_00FF;

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
    rec: RecordingStream,
    file: RrdFile,
    tracks: Tracks,
    trail_m: Vec<Point2<f64>>,
}

impl MissionRecorder {
    /// Opens the file and writes all that holds for the whole mission. `mine_m` is the true outline in segments.
    ///
    /// # Errors
    /// When the file cannot be created, or the environment turns recordings off.
    pub fn create(
        path: &Path,
        name: &str,
        config_toml: &str,
        mine_m: &[[Point2<f64>; 2]],
    ) -> Result<Self, RecorderError> {
        if !rerun::decide_logging_enabled(true) {
            return Err(RecorderError::Disabled);
        }
        let file = RrdFile::create(path)?;
        let sinks: Vec<Box<dyn LogSink>> = vec![Box::new(file.clone())];
        let batches = ChunkBatcherConfig { flush_tick: std::time::Duration::MAX, ..ChunkBatcherConfig::DEFAULT };
        let rec = RecordingStreamBuilder::new("crosscut")
            .recording_name(name)
            .recording_started(0)
            .batcher_config(batches)
            .set_sinks(sinks)?;
        rec.set_log_time_enabled(false);
        rec.set_log_tick_enabled(false);
        rec.log_static(COLORS.path, &annotation_context())?;
        rec.log_static(CONFIG.path, &TextDocument::new(config_toml).with_media_type(MediaType::TEXT))?;
        log_looks(&rec)?;
        let outline = LineStrips3D::new(chains(mine_m)).with_colors([color(EDGE)]);
        rec.log_static(ENTITIES.mine, &outline.with_radii([Radius::new_ui_points(1.0)]))?;
        mission::send(&rec, mine_m.iter().flatten().copied())?;
        Ok(Self { rec, file, tracks: Tracks::default(), trail_m: Vec::new() })
    }

    /// Adds the next revolution.
    ///
    /// # Errors
    /// When a write has failed.
    pub fn add(&mut self, moment: &MissionMoment) -> Result<(), RecorderError> {
        let revolution = &moment.frame.revolution;
        self.rec.set_time_sequence("revolution", revolution.seq.cast_signed());
        self.rec.set_timestamp_nanos_since_epoch("stamp", revolution.stamp_ns.cast_signed());
        if revolution.seq == 0 {
            self.rec.send_recording_start_time(revolution.stamp_ns.cast_signed())?;
        }
        self.log_vehicle(moment)?;
        self.log_seen(moment)?;
        if let Some(decision) = &moment.decision {
            self.log_decision(moment, decision)?;
        }
        if let Some(map) = &moment.map {
            self.log_map(map)?;
        }
        self.file.check()
    }

    /// Ends the file.
    ///
    /// # Errors
    /// When a write has failed.
    pub fn finish(&mut self) -> Result<(), RecorderError> {
        let flushed = self.rec.flush_blocking();
        self.file.check()?;
        flushed.map_err(|error| RecorderError::Viewer(error.to_string()))?;
        self.file.end()
    }

    fn log_vehicle(&mut self, moment: &MissionMoment) -> Result<(), RecorderError> {
        let at_m = Point2::from(moment.vehicle.translation.vector);
        let arrow = Arrows3D::from_vectors([along(moment.vehicle.rotation.angle(), VEHICLE_M)])
            .with_origins([above(at_m, 0.3)]);
        self.rec.log(ENTITIES.vehicle, &arrow)?;
        let is_far = self.trail_m.last().is_none_or(|last_m| (at_m - last_m).norm() > TRAIL_STEP_M);
        if is_far {
            self.trail_m.push(at_m);
        }
        if moment.frame.revolution.seq.is_multiple_of(TRAIL_EVERY) {
            let line = self.trail_m.iter().map(|place_m| above(*place_m, 0.1));
            self.rec.log(ENTITIES.trail, &LineStrips3D::new([line.collect::<Vec<_>>()]))?;
        }
        let goal = LineStrips3D::new([[above(at_m, 0.2), above(moment.goal_m, 0.2)]]);
        Ok(self.rec.log(ENTITIES.goal, &goal)?)
    }

    fn log_seen(&mut self, moment: &MissionMoment) -> Result<(), RecorderError> {
        let (frame, vehicle) = (moment.frame, moment.vehicle);
        let classes = self.tracks.classes_of(frame);
        let placed = |point: &crosscut_stage::Point| above(vehicle * Point2::new(point.x, point.y), 0.0);
        let wall_of = |i: usize| frame.junction.wall_of_return.get(i).copied().flatten();
        let of_returns = (0..frame.revolution.len()).map(|i| classes.of_wall(wall_of(i)));
        let points = Points3D::new(frame.revolution.points_m.iter().map(placed)).with_class_ids(of_returns);
        self.rec.log(ENTITIES.scan, &points)?;
        let edges = frame.junction.openings.iter().map(|opening| opening.edge_m.map(|end_m| placed(&end_m)));
        self.rec.log(ENTITIES.openings, &LineStrips3D::new(edges))?;
        self.rec.log(ENTITIES.walls, &Scalars::single(frame.junction.junctions as f64))?;
        Ok(())
    }

    fn log_decision(&self, moment: &MissionMoment, decision: &MissionDecision) -> Result<(), RecorderError> {
        let at_m = Point2::from(moment.vehicle.translation.vector);
        let arrow = Arrows3D::from_vectors([along(decision.bearing_rad, CHOICE_M)]).with_origins([above(at_m, 0.4)]);
        self.rec.log(ENTITIES.choice, &arrow)?;
        let place = decision.place.map_or_else(|| "No place of the map".to_owned(), |place| format!("Place {place}"));
        let why = decision.why;
        self.rec.log(ENTITIES.log, &TextLog::new(format!("{place}: {why}")).with_level(TextLogLevel::INFO))?;
        let seen = moment.frame.junction.junctions;
        let text = format!("## {place}\n\n{why}\n\nWalls in view: {seen}. The vehicle {}.", moment.doing);
        Ok(self.rec.log(ENTITIES.why, &TextDocument::from_markdown(text))?)
    }

    fn log_map(&self, map: &Map) -> Result<(), RecorderError> {
        let courses = map.passages.iter().map(|of| map.course_m(of).map(|place_m| above(*place_m, 0.5)).collect());
        self.rec.log(ENTITIES.passages, &LineStrips3D::new(courses.collect::<Vec<Vec<[f32; 3]>>>()))?;
        // A dead end has no way to explore.
        let is_taken = |node: &Node, way: &NodeWay| way.taken || node.kind != HereKind::Junction;
        let ways = || map.nodes.iter().flat_map(|node| node.ways.iter().map(move |way| (node, way)));
        let of_way = |(node, way): (&Node, &NodeWay)| {
            let [x, y, _] = along(way.bearing_rad, WAY_M).map(f64::from);
            [above(node.position_m, 0.6), above(node.position_m + nalgebra::Vector2::new(x, y), 0.6)]
        };
        let colors = ways().map(|(node, way)| color(if is_taken(node, way) { TAKEN } else { NEW }));
        self.rec.log(ENTITIES.ways, &LineStrips3D::new(ways().map(of_way)).with_colors(colors))?;
        let labels = (0..map.nodes.len()).map(|number| number.to_string());
        let is_junction = |node: &Node| node.kind == HereKind::Junction;
        let radii = map.nodes.iter().map(|node| Radius::new_ui_points(if is_junction(node) { 7.0 } else { 4.0 }));
        let places = Points3D::new(map.nodes.iter().map(|node| above(node.position_m, 0.7)))
            .with_labels(labels)
            .with_show_labels(true)
            .with_radii(radii);
        self.rec.log(ENTITIES.places, &places.with_colors([color(WORDS)]))?;
        Ok(self.rec.log(ENTITIES.new_ways, &Scalars::single(map.ways_not_taken() as f64))?)
    }
}

/// What never changes: colours and widths.
fn log_looks(rec: &RecordingStream) -> Result<(), RecorderError> {
    let ui = Radius::new_ui_points;
    let lines =
        |rgba: u32, width: f32| LineStrips3D::update_fields().with_radii([ui(width)]).with_colors([color(rgba)]);
    let arrows = |rgba: u32, width: f32| Arrows3D::update_fields().with_radii([ui(width)]).with_colors([color(rgba)]);
    let looks: [(&str, &dyn AsComponents); 9] = [
        (ENTITIES.vehicle, &arrows(REPORTED, 4.0)),
        (ENTITIES.trail, &lines(GREY, 1.0)),
        (ENTITIES.scan, &Points3D::update_fields().with_radii([ui(2.0)])),
        (ENTITIES.openings, &lines(OPENING, 2.0)),
        (ENTITIES.goal, &lines(REPORTED, 1.0)),
        (ENTITIES.choice, &arrows(OPENING, 3.0)),
        (ENTITIES.passages, &lines(ZEROS, 2.0)),
        (ENTITIES.walls, &series("walls in view", REPORTED, 1.5)),
        (ENTITIES.new_ways, &series("ways not taken", NEW, 1.5)),
    ];
    for (entity, look) in looks {
        rec.log_static(entity, look)?;
    }
    Ok(rec.log_static(ENTITIES.ways, &LineStrips3D::update_fields().with_radii([ui(3.0)]))?)
}

/// Segments that continue each other, as lines.
fn chains(segments_m: &[[Point2<f64>; 2]]) -> Vec<Vec<[f32; 3]>> {
    let mut lines: Vec<Vec<[f32; 3]>> = Vec::new();
    let mut last = None;
    for [from_m, to_m] in segments_m {
        match lines.last_mut().filter(|_| last == Some(*from_m)) {
            Some(line) => line.push(above(*to_m, 0.0)),
            None => lines.push(vec![above(*from_m, 0.0), above(*to_m, 0.0)]),
        }
        last = Some(*to_m);
    }
    lines
}

fn above(place_m: Point2<f64>, height_m: f32) -> [f32; 3] {
    [place_m.x as f32, place_m.y as f32, height_m]
}

fn along(bearing_rad: f64, length_m: f64) -> [f32; 3] {
    [(length_m * bearing_rad.cos()) as f32, (length_m * bearing_rad.sin()) as f32, 0.0]
}
