//! The schema of a recording: every entity, what it holds, and when it is written.
//!
//! Writer, reader, layout, `/about` and tests take paths, dimension names and precision from this one table. It depends
//! on nothing else.

use std::fmt;

/// One entity of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entity {
    /// Its path, which starts with a slash.
    pub path: &'static str,
    /// What it holds.
    pub what: &'static str,
    /// The component that holds its values. All other components are drawings of them, or say how they look.
    pub values: &'static str,
    /// What each dimension of its values counts, the slowest first; empty for a single value.
    pub dims: &'static [&'static str],
    /// Unit of its values; empty where there is none.
    pub unit: &'static str,
    /// How exact its values are.
    pub precision: Precision,
    /// When it is written.
    pub when: When,
}

/// How exact the values of an entity are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// To the last bit.
    Exact,
    /// Rounded to f32.
    F32,
    /// Rounded to f16: three digits, 6e-8 near 0.
    F16,
    /// The absolute value to half a decade; 1e-16 or less is 0.
    HalfDecade,
    /// Words.
    Words,
    /// For the eye.
    Drawing,
}

/// When an entity is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Once, for the whole recording.
    Once,
    /// At the first revolution of each file.
    File,
    /// When it changes, and at the first revolution of each file.
    Change,
    /// At every revolution.
    Revolution,
    /// At every revolution, but not at level `light`.
    Matrices,
    /// At some revolutions: every 300th, and where the count changes; at every one at level `full`.
    Sampled,
    /// When something happens.
    Event,
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Exact => "exact",
            Self::F32 => "f32",
            Self::F16 => "f16",
            Self::HalfDecade => "half a decade",
            Self::Words => "words",
            Self::Drawing => "drawing",
        })
    }
}

impl fmt::Display for When {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Once => "once",
            Self::File => "each file",
            Self::Change => "on change",
            Self::Revolution => "every revolution",
            Self::Matrices => "every revolution, not if light",
            Self::Sampled => "some revolutions",
            Self::Event => "when it happens",
        })
    }
}

impl Entity {
    /// The entity with this path.
    pub fn of(path: &str) -> Option<&'static Self> {
        ENTITIES.iter().find(|entity| entity.path == path)
    }

    /// The first part of its path: a step of the pipeline (`scan` for ingest), or what else it belongs to.
    pub fn area(&self) -> &'static str {
        self.path.split('/').nth(1).unwrap_or_default()
    }
}

/// All entities as a table in Markdown, for readers of a recording.
pub fn markdown_table() -> String {
    let mut table = "| entity | holds | unit | precision | written |\n|---|---|---|---|---|\n".to_owned();
    for Entity { path, what, unit, precision, when, .. } in ENTITIES {
        table.push_str(&format!("| `{path}` | {what} | {unit} | {precision} | {when} |\n"));
    }
    table
}

/// Values in a tensor.
const TENSOR: &str = "Tensor:data";
/// A single number at each revolution.
const SCALAR: &str = "Scalars:scalars";
/// The picture of a matrix.
const PICTURE: &str = "EncodedDepthImage:blob";
/// A text of one revolution, or of the whole recording.
const DOCUMENT: &str = "TextDocument:text";
const LINES_2D: &str = "LineStrips2D:strips";
const LINES_3D: &str = "LineStrips3D:strips";
const POINTS_3D: &str = "Points3D:positions";

macro_rules! entities {
    ($($name:ident: $path:literal, $values:expr, [$($dim:literal),*], $unit:literal, $precision:ident, $when:ident, $what:literal;)*) => {
        $(
            #[doc = concat!("`", $path, "`: ", $what, ".")]
            pub const $name: Entity = Entity {
                path: $path,
                what: $what,
                values: $values,
                dims: &[$($dim),*],
                unit: $unit,
                precision: Precision::$precision,
                when: When::$when,
            };
        )*

        /// Every entity, by step.
        ///
        /// | entity | holds | unit | precision | written |
        /// |---|---|---|---|---|
        $(#[doc = concat!(
            "| `", $path, "` | ", $what, " | ", $unit, " | [", stringify!($precision), "](Precision::",
            stringify!($precision), ") | [", stringify!($when), "](When::", stringify!($when), ") |"
        )])*
        pub const ENTITIES: &[Entity] = &[$($name),*];
    };
}

entities! {
    SCAN_RETURNS: "/scan/returns", POINTS_3D, ["return", "axis"], "m", F32, Revolution,
        "returns in the body frame, coloured by wall";
    SCAN_COUNT: "/scan/count", SCALAR, [], "", Exact, Revolution, "number of returns";
    SCAN_RANGES: "/scan/ranges", TENSOR, ["beam"], "m", Exact, Revolution, "ranges as on the wire, f32";
    SCAN_SEEN: "/scan/seen", TENSOR, ["beam"], "", Exact, Revolution,
        "what each beam saw: 2 a return, 1 nothing in range, 0 unknown";
    SCAN_BEAMS: "/scan/beams", TENSOR, ["beam"], "rad", Exact, Change, "bearing of each beam in the body frame";
    SCAN_BEAMS_WIRE: "/scan/beams/wire", TENSOR, ["angle_min, angle_increment, range_min, range_max"], "rad, m", Exact,
        Change, "beam geometry as on the wire, f32";
    SCAN_SWEEP: "/scan/beams/sweep", TENSOR,
        ["step_rad, range_max_m, full_turn, missing, yaw_rad, upside_down, first_rad, increment_rad"], "rad, m", Exact,
        Change, "how the beams were taken: step, limit, full turn, missing beams; the sensor's yaw, whether it is upside \
        down, its first angle and increment, NaN where there are several sensors";
    SCAN_POINTS: "/scan/returns/exact", TENSOR, ["return", "axis"], "m", Exact, Event,
        "returns in f64, where they do not follow from ranges and `/scan/beams/sweep`";
    SCAN_ENTRIES: "/scan/entries", TENSOR, ["entry"], "", Exact, Event,
        "of a cloud, for each of its points the return whose wall is its label, or -1 or -2 as in the labels";
    SCAN_ODOMETRY: "/scan/odometry", SCALAR, ["x_m, y_m, cos, sin"], "m", Exact, Event,
        "pose by odometry, at each revolution that has one";
    SCAN_NOTES: "/scan/notes", DOCUMENT, [], "", Exact, Change, "what ingest noted, a line each, with the code of the note";
    SCAN_MOUNTING: "/scan/mounting", "Transform3D:quaternion", [], "", F32, Once,
        "how the sensor's frame is turned in the body frame";
    SCAN_WALLS: "/scan/walls", LINES_3D, ["point", "axis"], "m", Drawing, Revolution,
        "lines along the walls within 3 cm of the returns, broken at gaps";
    SCAN_OPENINGS: "/scan/openings", TENSOR, ["opening", "bearing_rad, width_m"], "rad, m", Exact, Revolution,
        "bearing and width of each opening, drawn as arrows and bars; arrows from the sensor are the openings of the steady answer";
    SCAN_CLOUD: "/scan/cloud", POINTS_3D, ["point", "axis"], "m", Exact, Event,
        "all points of a cloud that the affinity takes whole (preset `3d`), in the colours of the ways that they lie in";
    SCAN_CLOUD_TILT: "/scan/cloud/tilt", SCALAR, ["x, y, z, w"], "", Exact, Event,
        "the quaternion that turned a cloud of a tilted lidar level";
    SCAN_WAYS: "/scan/ways", TENSOR, ["way", "x, y, z, clearance_m, p, cut_by_view"], "m", Exact, Event,
        "unit vector, clearance, p of each way on, and whether the view cuts it; drawn as arrows";
    SCAN_SPHERE: "/scan/sphere", TENSOR, ["cell", "x, y, z, range_m, reach_m, way"], "m", F32, Event,
        "of each direction around a cloud: unit vector, the distance of what is seen, how far the vehicle gets (infinite where nothing \
        came back, NaN where the sensor does not look), and its way or -1; drawn unrolled, with what parts ways";
    SCAN_SPHERE_MARKS: "/scan/sphere/marks", "Points2D:positions", ["mark", "axis"], "", Drawing, Event,
        "names of ways on `/scan/sphere`, and pink where two are parted: how far the vehicle gets there, and how far it would have to";
    SCAN_SPHERE_AXES: "/scan/sphere/axes", LINES_2D, ["point", "axis"], "", Drawing, Once,
        "bearings and elevations of `/scan/sphere`";
    SCAN_LINKS: "/scan/links", LINES_3D, ["point", "axis"], "m", Drawing, Revolution,
        "gaps that decide the count: pink the nearest to another count, yellow those of other changes of k";
    SCAN_NUMBERS: "/scan/numbers", POINTS_3D, ["wall", "axis"], "m", Drawing, Revolution,
        "numbers of walls beside them, and a ring around what tips the count";
    SCAN_RINGS: "/scan/rings", LINES_3D, ["point", "axis"], "m", Drawing, Once, "circles to read distances by";
    SCAN_SENSOR: "/scan/sensor", LINES_3D, ["point", "axis"], "m", Drawing, Once, "the sensor as an arrowhead";
    AFFINITY_W: "/affinity/W", PICTURE, ["row", "column"], "", HalfDecade, Matrices,
        "W as a picture of log10 over [-16, 0], a decade a level, by beam, upper triangle, up to 1024 returns";
    AFFINITY_W_EXACT: "/affinity/W/exact", TENSOR, ["return i", "return j, upper triangle"], "", Exact, Sampled,
        "W, with zeros below the diagonal";
    AFFINITY_DEGREES: "/affinity/degrees", TENSOR, ["return"], "", F32, Matrices, "degrees D";
    AFFINITY_LINKS: "/affinity/links", LINES_3D, ["point", "axis"], "m", Drawing, Matrices,
        "edges of a sparse W, yellow below 0.1; of those of weight 1 only each return's to the next";
    AFFINITY_SCALE: "/affinity/scale", LINES_2D, ["point", "axis"], "", Drawing, Once,
        "key to the colours of the pictures of W and L";
    AFFINITY_MARKS: "/affinity/marks", "Points2D:positions", ["edge", "axis"], "", Drawing, Matrices,
        "gaps of `/scan/links` on the picture of W; with their weights where W is sparse";
    AFFINITY_ABSENT: "/affinity/absent", "Points2D:positions", ["point", "axis"], "", Drawing, Change,
        "why there is no picture of W, L and U";
    AFFINITY_GAPS: "/affinity/gaps/values", LINES_2D, ["point", "axis"], "", Drawing, Event,
        "room at each gap that an affinity decides, divided by the room that an opening needs, on a logarithmic scale";
    AFFINITY_GAPS_AXIS: "/affinity/gaps/axis", LINES_2D, ["point", "axis"], "", Drawing, Once,
        "ratios of `/affinity/gaps/values`";
    SPECTRAL_L: "/spectral/L", PICTURE, ["row", "column"], "", HalfDecade, Matrices,
        "L as a picture of log10 of the absolute value, like W";
    SPECTRAL_EIGENVALUES: "/spectral/eigenvalues", "BarChart:values", ["eigenvalue"], "", Exact, Revolution,
        "eigenvalues λ of L, ascending: the 32 smallest, or k + 1";
    SPECTRAL_TOLERANCE: "/spectral/tolerance", SCALAR, [], "", Exact, Revolution, "zero tolerance τ";
    SPECTRAL_K: "/spectral/k", SCALAR, [], "", Exact, Revolution, "k, the number of eigenvalues below τ";
    SPECTRAL_MARGIN: "/spectral/margin", SCALAR, [], "decades", Exact, Revolution, "margin of k; none without returns";
    SPECTRAL_CHART: "/spectral/chart/values", LINES_2D, ["point", "axis"], "", Drawing, Revolution,
        "λ, τ and k on a logarithmic scale";
    SPECTRAL_CHART_AXIS: "/spectral/chart/axis", LINES_2D, ["point", "axis"], "", Drawing, Once,
        "decades of `/spectral/chart/values`";
    SPECTRAL_U: "/spectral/U", TENSOR, ["return", "eigenvector"], "", F16, Matrices,
        "eigenvectors U of the k smallest eigenvalues";
    SPECTRAL_U_PICTURE: "/spectral/U/picture", PICTURE, ["row", "column"], "", Drawing, Matrices,
        "U as a picture by beam, a band for each eigenvector: blue below 0, yellow above, in 15 steps";
    SPECTRAL_U_BARS: "/spectral/U/bars", LINES_2D, ["point", "axis"], "", Drawing, Matrices,
        "walls as bars above `/spectral/U/picture`";
    SPECTRAL_U_EXACT: "/spectral/U/exact", TENSOR, ["return", "eigenvector"], "", Exact, Sampled, "U";
    SPECTRAL_EMBEDDING: "/spectral/embedding", POINTS_3D, ["return", "axis"], "", Drawing, Matrices,
        "the first three columns of U, scaled so that the farthest row lies at 1, in steps of 1/128";
    SPECTRAL_AXES: "/spectral/axes", LINES_3D, ["point", "axis"], "", Drawing, Once, "axes of the embedding";
    KMEANS_LABELS: "/kmeans/labels", TENSOR, ["return"], "", Exact, Revolution,
        "cluster of each return, -1 for none; also drawn as bars beside W";
    KMEANS_CENTROIDS: "/kmeans/centroids", TENSOR, ["cluster", "eigenvector"], "", Exact, Revolution,
        "centres of the clusters among the rows of U; also drawn in the embedding";
    KMEANS_BLOCKS: "/kmeans/blocks", LINES_2D, ["point", "axis"], "", Drawing, Matrices, "walls as frames on W, hatched on a sparse one";
    KMEANS_PROFILE: "/kmeans/profile/lines", LINES_2D, ["point", "axis"], "", Drawing, Revolution,
        "ranges by beam, with the walls above them";
    KMEANS_PROFILE_AXES: "/kmeans/profile/axes", LINES_2D, ["point", "axis"], "", Drawing, Change,
        "ranges and bearings of `/kmeans/profile/lines`";
    KMEANS_PROFILE_NAMES: "/kmeans/profile/names", "Points2D:positions", ["point", "axis"], "", Drawing, Once,
        "name of the row of `/kmeans/profile/lines`";
    REPORT_JUNCTIONS: "/report/junctions", SCALAR, [], "", Exact, Revolution, "number of walls that is reported";
    TRUTH_WALLS: "/truth/walls", SCALAR, [], "", Exact, Event,
        "true number of walls, where the flight has its truth: when it changes, and at every tenth revolution";
    TRUTH_JSON: "/truth/json", DOCUMENT, [], "", Exact, Event, "the truth of each revolution that has one";
    REPORT_CONFIDENCE: "/report/confidence", SCALAR, [], "", Exact, Revolution, "confidence in that number, 0 to 1";
    REPORT_DOUBT: "/report/doubt", "StateChange:state", [], "", Exact, Change,
        "`wrong` where the truth has another count, `unsure` from a low confidence until it has recovered, `wrong, unsure` where both \
        hold, each until 10 revolutions in a row are better; else `none`";
    REPORT_PLACE: "/report/place", "StateChange:state", [], "", Exact, Revolution, "place, such as `tee`";
    REPORT_SUMMARY: "/report/summary", DOCUMENT, [], "", Words, Revolution, "answer with its openings and walls";
    REPORT_WHY: "/report/why", DOCUMENT, [], "", Words, Revolution, "why the count is what it is, with all notes";
    REPORT_LABELS: "/report/labels", TENSOR, ["beam"], "", Exact, Revolution,
        "wall of each beam, -1 no return, -2 a return of no wall";
    REPORT_WALLS: "/report/walls", TENSOR, ["wall", "id, returns, from_rad, to_rad, island, class"], "rad", Exact,
        Revolution, "a row for each wall; its class is its colour";
    REPORT_AXIS: "/report/axis", SCALAR, ["end"], "", Drawing, File, "what plots of counts reach at least";
    FLIGHT_POSE: "/flight/pose", TENSOR, ["x_m, y_m, yaw_rad"], "m, rad", Exact, Event,
        "pose in the map's frame by what is known then, at each revolution that has one; drawn as a disc with its heading";
    FLIGHT_HERE: "/flight/here", "StateChange:state", [], "", Exact, Event,
        "kind of the place by the steady answer, at each revolution where it is known";
    FLIGHT_PATH: "/flight/path", LINES_2D, ["point", "axis"], "m", Drawing, Change, "the way so far, corrected";
    FLIGHT_UNSURE: "/flight/unsure", "Points2D:positions", ["point", "axis"], "m", Drawing, Change,
        "places of the way where the answer was unsure (`/report/doubt`), corrected; only where there are any";
    FLIGHT_WALLS: "/flight/walls", "Points2D:positions", ["point", "axis"], "m", Drawing, Change,
        "walls so far, a point for each square of 0.2 m, corrected; drawn again when many are new";
    FLIGHT_WALLS_NEW: "/flight/walls/new", "Points2D:positions", ["point", "axis"], "m", Drawing, Change,
        "walls that are not in `/flight/walls` yet";
    FLIGHT_SCALE: "/flight/scale", LINES_2D, ["point", "axis"], "m", Drawing, Change, "a bar to read distances by";
    FLIGHT_NODES: "/flight/nodes", "Points2D:positions", ["node", "axis"], "m", F32, Change,
        "junctions and dead ends of the map by number, with y downwards; arrows are their ways";
    FLIGHT_PASSAGES: "/flight/passages", LINES_2D, ["point", "axis"], "m", Drawing, Change, "passages of the map";
    FLIGHT_GRAPH: "/flight/graph", "GraphNodes:node_ids", ["node"], "", Exact, Change,
        "the map as a graph: nodes by number, and a pair of them for each passage";
    FLIGHT_SUMMARY: "/flight/summary", DOCUMENT, [], "", Words, Change,
        "the map in words, and why places are taken to be seen before or not";
    TIMING_INGEST: "/timing/ingest", SCALAR, [], "ms", Exact, Revolution, "time of ingest";
    TIMING_AFFINITY: "/timing/affinity", SCALAR, [], "ms", Exact, Revolution, "time of affinity";
    TIMING_SPECTRAL: "/timing/spectral", SCALAR, [], "ms", Exact, Revolution, "time of spectral";
    TIMING_KMEANS: "/timing/kmeans", SCALAR, [], "ms", Exact, Revolution, "time of kmeans";
    TIMING_REPORT: "/timing/report", SCALAR, [], "ms", Exact, Revolution, "time of report";
    TIMING_FLIGHT: "/timing/flight", SCALAR, [], "ms", Exact, Event, "time of pose, place and map, where they are made";
    TIMING_TOTAL: "/timing/total", SCALAR, ["all stages, from scan to scan"], "ms", Exact, Revolution,
        "time of all stages, and from the scan before; NaN at the first";
    TIMING_SUMMARY: "/timing/summary", DOCUMENT, [], "ms", Words, Event,
        "table of the last 200 revolutions, at every tenth";
    LOG: "/log", "TextLog:text", [], "", Words, Event,
        "revolutions worth a look: a wrong count, another count or place, low confidence or margin; each note when it begins";
    CONFIG: "/config", DOCUMENT, [], "", Exact, Once, "resolved configuration as TOML";
    ABOUT: "/about", DOCUMENT, [], "", Words, Once, "what the recording holds, and how exactly";
    COLORS: "/", "AnnotationContext:context", [], "", Drawing, Once, "names and colours of the walls";
    PART: "/recording/part", TENSOR, ["number, goes_on"], "", Exact, File,
        "which file of a long recording this is, from 1; at its end again with a 1 if another follows";
    EXTENT: "/layout/extent", TENSOR, ["range_m, places, by_gaps, has_truth, ways_m"], "m", Exact, Once, "what the views of the layout reach";
}

/// Times of the steps, in their order.
pub const TIMING: [Entity; 5] = [TIMING_INGEST, TIMING_AFFINITY, TIMING_SPECTRAL, TIMING_KMEANS, TIMING_REPORT];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_path_is_there_once_and_found_by_its_name() {
        let paths: BTreeSet<&str> = ENTITIES.iter().map(|entity| entity.path).collect();
        assert_eq!(paths.len(), ENTITIES.len());
        for entity in ENTITIES {
            assert!(entity.path.starts_with('/') && !entity.what.is_empty(), "{}", entity.path);
            assert_eq!(Entity::of(entity.path), Some(entity));
        }
        assert_eq!([AFFINITY_W.area(), LOG.area(), COLORS.area()], ["affinity", "log", ""]);
        assert_eq!(Entity::of("/affinity/X"), None);
    }
}
