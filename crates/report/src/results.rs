//! The line of results: one JSON object per scan message.

use std::io::{self, Write};

use crosscut_flight::{FlightAnswer, Here, SteadyOpening};
use crosscut_stage::{Frame, Known, KnownGaps, Wall, Way};
use serde::{Deserialize, Serialize};

/// The name of [`RESULTS_SCHEMA_TEXT`].
pub const RESULTS_SCHEMA_NAME: &str = "crosscut.Results";
/// The definition of a line as JSON Schema. More fields may follow.
pub const RESULTS_SCHEMA_TEXT: &str = include_str!("results.schema.json");

/// At most this many eigenvalues stand in a line.
pub const MAX_EIGENVALUES: usize = 16;

/// What one revolution becomes in the results. No clock times: the same scan gives the same line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResultsLine {
    /// The message's index in its topic.
    pub seq: u64,
    /// The sensor's stamp.
    pub stamp_ns: u64,
    /// Number of returns, n.
    pub returns: usize,
    /// What is reported: the number of walls, islands left out.
    pub junctions: usize,
    /// The number of zero eigenvalues.
    pub k: usize,
    /// Decades by which the zero tolerance could be moved before `k` changes; null if no eigenvalue is known but exact
    /// zeros, as from `components`, or at n = 0.
    pub margin: Option<f64>,
    /// 0 to 1; null where nothing was calibrated for the affinity.
    pub confidence: Option<f64>,
    /// `closed`, `dead_end`, `corridor`, `bend`, `tee`, `cross`, `junction_5`..., `partial_view`.
    pub place: String,
    /// The smallest eigenvalues, ascending; at most [`MAX_EIGENVALUES`], so with as many zeros the next is not there.
    pub eigenvalues: Vec<f64>,
    /// Walls, by id.
    pub walls: Vec<WallLine>,
    /// Openings, by bearing ascending.
    pub openings: Vec<OpeningLine>,
    /// How the gaps are known.
    #[serde(default)]
    pub gaps: KnownGaps,
    /// The widths of the vehicle, about the configured one, for which the count stays the same, metres; null of affinities for
    /// which the vehicle has no width.
    #[serde(default)]
    pub holds_for_width_m: Option<[f64; 2]>,
    /// The ways on in three dimensions, by bearing ascending; left out of affinities whose rows are returns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ways: Option<Vec<WayLine>>,
    /// How many of them a flyer can take: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ways_flyer: Option<usize>,
    /// How many of them a vehicle on the ground can take: those that are no shafts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ways_ground: Option<usize>,
    /// The lowest and the highest elevation that the sensor looks at: of ways beyond them, nothing is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ways_view_rad: Option<[f64; 2]>,
    /// The place that the vehicle is in; null for a cloud, where no wall is in view, and for a
    /// limited view that has not seen enough around it.
    #[serde(default)]
    pub here: Option<HereLine>,
    /// The answer over the last revolutions; null without a flight.
    #[serde(default)]
    pub steady: Option<SteadyLine>,
    /// Where the scan was taken; null where that is not known.
    #[serde(default)]
    pub pose: Option<PoseLine>,
    /// Per beam, in message order: wall id, [`Frame::NO_RETURN`] or [`Frame::NO_WALL`]. Per point for a cloud.
    pub labels: Vec<i32>,
    /// What was dropped, repaired or fallen back to.
    pub notes: Vec<String>,
}

/// A wall in the results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WallLine {
    /// Its number, returns and directions.
    #[serde(flatten)]
    pub wall: Wall,
    /// How far its nearest return is from the sensor, and in which direction; null where a line does not say.
    #[serde(default)]
    pub nearest_m: Option<f64>,
    /// As above.
    #[serde(default)]
    pub nearest_rad: Option<f64>,
}

impl WallLine {
    /// The walls of a finished frame.
    fn all_of(frame: &Frame) -> Vec<Self> {
        let (revolution, junction) = (&frame.revolution, &frame.junction);
        let mut nearest: Vec<Option<(f64, usize)>> = vec![None; junction.walls.len()];
        for (i, wall) in junction.wall_of_return.iter().enumerate().take(revolution.len()) {
            let Some(nearest) = wall.and_then(|wall| nearest.get_mut(wall as usize)) else { continue };
            let range_m = revolution.range_m(i);
            if nearest.is_none_or(|(least_m, _)| range_m < least_m) {
                *nearest = Some((range_m, i));
            }
        }
        let line = |(wall, nearest): (&Wall, Option<(f64, usize)>)| Self {
            wall: wall.clone(),
            nearest_m: nearest.map(|(range_m, _)| range_m),
            nearest_rad: nearest.map(|(_, i)| revolution.bearing_rad(i)),
        };
        junction.walls.iter().zip(nearest).map(line).collect()
    }
}

/// An opening in the results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OpeningLine {
    /// Direction towards the branch.
    pub bearing_rad: f64,
    /// Clear width across the branch.
    pub width_m: f64,
    /// How far its nearer end is from the sensor.
    #[serde(default)]
    pub range_m: f64,
    /// The odds that a vehicle can pass, as a probability; null where too little is seen to say.
    #[serde(default)]
    pub p: Option<f64>,
    /// The walls on its clockwise and anticlockwise side.
    pub walls: [u32; 2],
    /// `seen_through` or `no_return`.
    pub evidence: String,
    /// How it is known: `seen` or `judged`.
    #[serde(default = "judged")]
    pub known: String,
    /// The end of a limited view cuts it: bearing and width are those of the part in view.
    #[serde(default)]
    pub cut_by_view: bool,
}

/// A way on in three dimensions, in the results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WayLine {
    /// Towards it, in the body frame: a unit vector.
    pub direction: [f64; 3],
    /// Its bearing.
    pub bearing_rad: f64,
    /// Its elevation, up is positive.
    pub elevation_rad: f64,
    /// How steep it is, up is positive: the elevation of the line along its middle.
    pub slope_rad: f64,
    /// Diameter of the largest ball that passes.
    pub clearance_m: f64,
    /// `level`, `ramp_up`, `ramp_down`, `shaft_up` or `shaft_down`.
    pub kind: String,
    /// The odds that it is one, as a probability.
    pub p: f64,
    /// `seen_through` or `no_return`.
    pub evidence: String,
    /// It goes on beyond what the sensor looks at: direction and clearance are those of the part in view.
    pub cut_by_view: bool,
}

impl WayLine {
    fn of(way: &Way) -> Self {
        Self {
            direction: way.direction.into(),
            bearing_rad: way.bearing_rad(),
            elevation_rad: way.elevation_rad(),
            slope_rad: way.slope_rad,
            clearance_m: way.clearance_m,
            kind: way.kind().to_string(),
            p: way.p,
            evidence: way.evidence.to_string(),
            cut_by_view: way.cut_by_view,
        }
    }
}

/// What is read where a line does not say how an opening is known.
fn judged() -> String {
    Known::Judged.to_string()
}

/// The place that the vehicle is in, in the results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HereLine {
    /// `junction`, `passage`, `dead_end` or `chamber`.
    pub kind: String,
    /// By bearing ascending: the index of the opening that a way of the place leads to, or null where no opening lies behind its
    /// mouth.
    pub ways: Vec<Option<usize>>,
    /// 0 to 1.
    pub confidence: f64,
}

/// The answer over the last revolutions, in the results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SteadyLine {
    /// The number of walls, islands left out.
    pub junctions: usize,
    /// The place; its ways are indices of the openings below.
    pub here: Option<HereLine>,
    /// Openings that are followed, by bearing ascending.
    pub openings: Vec<SteadyOpening>,
}

/// A pose in the frame of the flight's first one, in the results.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseLine {
    /// Forward of the first pose.
    pub x_m: f64,
    /// To the left of the first pose.
    pub y_m: f64,
    /// Anticlockwise from the first pose, in (-π, π].
    pub yaw_rad: f64,
    /// Standard deviation of the position in the direction in which it is known least, metres; null where it is not known.
    pub sd_m: Option<f64>,
}

impl HereLine {
    fn of(here: &Here) -> Self {
        let ways = here.ways.iter().map(|way| way.opening).collect();
        Self { kind: here.kind.name().to_owned(), ways, confidence: here.confidence }
    }
}

impl ResultsLine {
    /// The line of a finished frame.
    pub fn of(frame: &Frame) -> Self {
        let (spectrum, junction, flown) = (&frame.spectrum, &frame.junction, FlightAnswer::of(frame));
        Self {
            seq: frame.revolution.seq,
            stamp_ns: frame.revolution.stamp_ns,
            returns: frame.revolution.len(),
            junctions: junction.junctions,
            k: spectrum.k,
            margin: spectrum.margin_decades,
            confidence: junction.confidence,
            place: junction.place.to_string(),
            eigenvalues: spectrum.eigenvalues.iter().copied().take(MAX_EIGENVALUES).collect(),
            walls: WallLine::all_of(frame),
            openings: junction
                .openings
                .iter()
                .map(|o| OpeningLine {
                    bearing_rad: o.bearing_rad,
                    width_m: o.width_m,
                    range_m: o.range_m(),
                    p: o.p,
                    walls: o.walls,
                    evidence: o.evidence.to_string(),
                    known: o.known.to_string(),
                    cut_by_view: o.is_cut_by_view(),
                })
                .collect(),
            gaps: junction.gaps,
            holds_for_width_m: frame.affinity.holds_for_width_m,
            ways: junction.ways.as_ref().map(|ways| ways.iter().map(WayLine::of).collect()),
            ways_flyer: junction.ways.as_ref().map(Vec::len),
            ways_ground: junction.ways.as_ref().map(|ways| ways.iter().filter(|way| way.is_for_ground()).count()),
            ways_view_rad: frame.affinity.dual.as_ref().map(|dual| dual.view_rad),
            here: flown.here.as_ref().map(HereLine::of),
            steady: flown.steady.as_ref().map(|steady| SteadyLine {
                junctions: steady.junctions,
                here: steady.here.as_ref().map(HereLine::of),
                openings: steady.openings.clone(),
            }),
            pose: flown.pose.map(|pose| PoseLine {
                x_m: pose.translation.x,
                y_m: pose.translation.y,
                yaw_rad: pose.rotation.angle(),
                sd_m: flown.doubt.and_then(|doubt| doubt.from_start_sd_m(pose.translation.vector.into())),
            }),
            labels: frame.labels(),
            notes: frame.notes.iter().map(str::to_owned).collect(),
        }
    }

    /// Writes the line as JSON, with its line end.
    ///
    /// # Errors
    /// When `out` cannot be written.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        serde_json::to_writer(&mut *out, self)?;
        out.write_all(b"\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_revolution_has_a_line_with_every_field_of_the_contract() {
        let mut out = Vec::new();
        ResultsLine::of(&Frame::default()).write(&mut out).expect("memory");
        assert_eq!(
            String::from_utf8(out).expect("text"),
            concat!(
                r#"{"seq":0,"stamp_ns":0,"returns":0,"junctions":0,"k":0,"margin":null,"confidence":null,"#,
                r#""place":"partial_view","eigenvalues":[],"walls":[],"openings":[],"gaps":{"seen":0,"proved":0,"judged":0},"holds_for_width_m":null,"here":null,"steady":null,"pose":null,"labels":[],"notes":[]}"#,
                "\n"
            )
        );
    }

    #[test]
    fn a_line_reads_back_bit_for_bit() {
        let mut frame = Frame::default();
        frame.spectrum.eigenvalues = vec![-1.2345678901234567e-16, 0.1 + 0.2, 2.0];
        let line = ResultsLine::of(&frame);
        let mut text = Vec::new();
        line.write(&mut text).expect("memory");
        assert_eq!(serde_json::from_slice::<ResultsLine>(&text).expect("JSON"), line);
    }

    #[test]
    fn the_schema_names_the_fields_of_a_line() {
        let here = || HereLine { kind: "junction".to_owned(), ways: vec![None], confidence: 1.0 };
        let mut line = ResultsLine::of(&Frame::default());
        let wall = Wall { id: 0, returns: 1, bearing_rad: [0.0; 2], island: false };
        line.walls.push(WallLine { wall, nearest_m: None, nearest_rad: None });
        line.openings.push(OpeningLine {
            bearing_rad: 0.0,
            width_m: 1.0,
            range_m: 1.0,
            p: Some(0.5),
            walls: [0; 2],
            evidence: "seen_through".to_owned(),
            known: judged(),
            cut_by_view: false,
        });
        let way = Way {
            direction: nalgebra::Vector3::x(),
            slope_rad: 0.0,
            clearance_m: 1.0,
            p: 0.5,
            evidence: crosscut_stage::Evidence::NoReturn,
            cut_by_view: false,
            is_wide: false,
        };
        line.ways = Some(vec![WayLine::of(&way)]);
        (line.ways_flyer, line.ways_ground, line.ways_view_rad) = (Some(1), Some(1), Some([0.0; 2]));
        line.here = Some(here());
        let opening = SteadyOpening { track: 0, bearing_rad: 0.0, width_m: 1.0, p: Some(0.5), seen_ns: Some(1) };
        line.steady = Some(SteadyLine { junctions: 1, here: Some(here()), openings: vec![opening] });
        line.pose = Some(PoseLine { x_m: 0.0, y_m: 0.0, yaw_rad: 0.0, sd_m: None });
        let line = serde_json::to_value(line).expect("JSON");
        let schema: serde_json::Value = serde_json::from_str(RESULTS_SCHEMA_TEXT).expect("JSON");
        assert_same_fields(&line, &schema, &schema["$defs"]);
    }

    /// Fails unless objects have the properties that the schema names, and no others.
    fn assert_same_fields(value: &serde_json::Value, schema: &serde_json::Value, defs: &serde_json::Value) {
        let schema = schema["oneOf"].as_array().map_or(schema, |either| &either[1]);
        let schema = if schema["$ref"].is_string() { &defs["here"] } else { schema };
        if let Some(items) = value.as_array() {
            items.iter().for_each(|item| assert_same_fields(item, &schema["items"], defs));
        }
        if let Some(fields) = value.as_object() {
            let named = schema["properties"].as_object().expect("properties");
            let [mut has, mut named_fields] = [fields, named].map(|object| object.keys().collect::<Vec<_>>());
            has.sort();
            named_fields.sort();
            assert_eq!(has, named_fields);
            fields.iter().for_each(|(name, field)| assert_same_fields(field, &named[name], defs));
        }
    }
}
