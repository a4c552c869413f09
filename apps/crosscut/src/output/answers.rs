//! The results as an MCAP: scans, answers and a drawing of them, for Foxglove and other tools.

use std::collections::BTreeMap;
use std::io::{self, Write};

use crosscut_messages::{
    CDR_ENCODING, Endian, Header, JSON_ENCODING, JSON_SCHEMA_ENCODING, LaserScan, Message, PROTOBUF_ENCODING,
    SCAN_TOPIC, SCENE_SCHEMA_NAME, SCHEMA_ENCODING, Scene, SceneArrow, SceneLine, SceneText, Time,
};
use crosscut_report::{RESULTS_SCHEMA_NAME, RESULTS_SCHEMA_TEXT, ResultsLine};
use crosscut_sensor::Sensor;
use crosscut_stage::{Frame, Point, counted};
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions};

use crosscut_evaluate::panel::wall_rgb;

/// Topics of the answers.
const RESULTS_TOPIC: &str = "/crosscut/results";
const SCENE_TOPIC: &str = "/crosscut/scene";

/// Colour of openings.
const OPENING: [f64; 3] = [0.95, 0.9, 0.25];
/// A wall is drawn through if its next return is not farther away than this, m.
const WALL_STEP_M: f64 = 2.0;
const ARROW_M: f64 = 3.0;
/// A chunk ends after this time: a program that is killed loses the last chunk.
const CHUNK_NS: u64 = 1_000_000_000;

/// An MCAP that is being written. It begins with the first scan.
pub(crate) struct AnswersFile<W: Write> {
    out: Option<W>,
    mcap: Option<mcap::Writer<NoSeek<W>>>,
    sensor: Sensor,
    channels: BTreeMap<&'static str, (u16, u32)>,
    /// Stamp of the first scan in the chunk that is not on disk yet.
    chunk_from_ns: Option<u64>,
}

impl<W: Write> AnswersFile<W> {
    pub(crate) fn new(out: W, sensor: Sensor) -> Self {
        Self { out: Some(out), mcap: None, sensor, channels: BTreeMap::new(), chunk_from_ns: None }
    }

    /// Writes the scan of a finished frame and its answer, at the stamp of the scan.
    pub(crate) fn take(&mut self, frame: &Frame) -> io::Result<()> {
        let stamp_ns = frame.revolution.stamp_ns;
        self.write(SCAN_TOPIC, stamp_ns, &scan(frame).encode(Endian::Little))?;
        let mut line = Vec::new();
        ResultsLine::of(frame).write(&mut line)?;
        self.write(RESULTS_TOPIC, stamp_ns, &line)?;
        self.write(SCENE_TOPIC, stamp_ns, &scene(frame, &self.sensor).encode())?;
        let from_ns = *self.chunk_from_ns.get_or_insert(stamp_ns);
        match &mut self.mcap {
            Some(mcap) if stamp_ns.abs_diff(from_ns) >= CHUNK_NS => {
                self.chunk_from_ns = None;
                mcap.flush().map_err(as_io)
            }
            _ => Ok(()),
        }
    }

    /// Writes what is left, and the index.
    pub(crate) fn finish(&mut self) -> io::Result<()> {
        self.mcap.as_mut().map_or(Ok(()), |mcap| mcap.finish().map(|_| ()).map_err(as_io))
    }

    fn write(&mut self, topic: &'static str, log_time: u64, data: &[u8]) -> io::Result<()> {
        if let Some(out) = self.out.take() {
            let options = WriteOptions::new().profile("ros2").library("crosscut").disable_seeking(true);
            self.mcap = Some(options.create(NoSeek::new(out)).map_err(as_io)?);
        }
        let mcap = self.mcap.as_mut().ok_or_else(|| io::Error::other("the MCAP could not be begun"))?;
        if !self.channels.contains_key(topic) {
            let (name, schema_encoding, text, encoding) = match topic {
                SCAN_TOPIC => {
                    (LaserScan::SCHEMA_NAME, SCHEMA_ENCODING, LaserScan::SCHEMA_TEXT.as_bytes(), CDR_ENCODING)
                }
                SCENE_TOPIC => (SCENE_SCHEMA_NAME, PROTOBUF_ENCODING, Scene::schema(), PROTOBUF_ENCODING),
                _ => (RESULTS_SCHEMA_NAME, JSON_SCHEMA_ENCODING, RESULTS_SCHEMA_TEXT.as_bytes(), JSON_ENCODING),
            };
            let schema = mcap.add_schema(name, schema_encoding, text).map_err(as_io)?;
            let channel = mcap.add_channel(schema, topic, encoding, &BTreeMap::new()).map_err(as_io)?;
            self.channels.insert(topic, (channel, 0));
        }
        let (channel_id, sequence) = self.channels.get_mut(topic).expect("it has just been added");
        let header = MessageHeader { channel_id: *channel_id, sequence: *sequence, log_time, publish_time: log_time };
        *sequence = sequence.wrapping_add(1);
        mcap.write_to_known_channel(&header, data).map_err(as_io)
    }
}

/// The walls of a finished frame as lines and its openings as arrows, in the sensor's frame.
pub fn scene(frame: &Frame, sensor: &Sensor) -> Scene {
    let (revolution, junction) = (&frame.revolution, &frame.junction);
    let place_m = |point_m: Point| -> [f64; 3] { sensor.in_sensor_frame(point_m).into() };
    let mut lines: Vec<SceneLine> = Vec::new();
    for wall in &junction.walls {
        let colour = wall_rgb(wall.id).map(|part| f64::from(part) / 255.0);
        let of_wall = revolution.points_m.iter().zip(&junction.wall_of_return);
        let points = of_wall.filter(|(_, of)| **of == Some(wall.id)).map(|(point_m, _)| *point_m);
        let mut last: Option<Point> = None;
        for point_m in points {
            let goes_on = last.is_some_and(|last| (point_m - last).norm() <= WALL_STEP_M);
            match lines.last_mut().filter(|_| goes_on) {
                Some(line) => line.points_m.push(place_m(point_m)),
                None => lines.push(SceneLine { points_m: vec![place_m(point_m)], colour }),
            }
            last = Some(point_m);
        }
    }
    lines.retain(|line| line.points_m.len() > 1);
    let origin = Point::origin();
    let mut texts = vec![SceneText {
        at_m: place_m(origin),
        text: format!("{}, {}", counted(junction.junctions as u64, "wall"), junction.place),
    }];
    let mut arrows = Vec::new();
    for opening in &junction.openings {
        let (sin, cos) = opening.bearing_rad.sin_cos();
        let tip_m = place_m(Point::new(ARROW_M * cos, ARROW_M * sin, 0.0));
        arrows.push(SceneArrow {
            from_m: place_m(origin),
            bearing_rad: tip_m[1].atan2(tip_m[0]),
            length_m: ARROW_M,
            colour: OPENING,
        });
        texts.push(SceneText { at_m: tip_m, text: format!("{:.1} m wide", opening.width_m) });
    }
    Scene { stamp_ns: revolution.stamp_ns, frame_id: revolution.frame_id.clone(), lines, arrows, texts }
}

/// The scan as it was recorded; of a cloud, what a level vehicle sees of it.
fn scan(frame: &Frame) -> LaserScan {
    let Some(sweep) = &frame.revolution.sweep else { return LaserScan::default() };
    let [angle_min, angle_increment, range_min, range_max] = sweep.wire_geometry;
    LaserScan {
        header: header(frame),
        angle_min,
        angle_max: angle_min + angle_increment * sweep.ranges_m.len().saturating_sub(1) as f32,
        angle_increment,
        range_min,
        range_max,
        ranges: sweep.ranges_m.clone(),
        ..LaserScan::default()
    }
}

fn header(frame: &Frame) -> Header {
    Header { stamp: Time::from_ns(frame.revolution.stamp_ns), frame_id: frame.revolution.frame_id.clone() }
}

fn as_io(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}
