//! What the columns of a table hold, by their names: `field.ranges12`, `ranges_12`, `/scan/ranges[12]`, `r12 (mm)`.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use std::ops::RangeInclusive;

use crosscut_messages::{LaserScan, NS_PER_S};

use super::list::{Columns, LARGEST_RAD, List, UNITS_M};
use crate::Found;
use crate::order::usual;

/// The part of a scan that a column of numbers states.
type Field = fn(&mut LaserScan) -> &mut f32;

/// What a column holds.
#[derive(Clone, Copy)]
enum Part {
    /// When the scan was taken.
    Stamp,
    /// When it was recorded.
    Recorded,
    /// The whole seconds of a time, and the nanoseconds after them.
    Seconds,
    Nanoseconds,
    Frame,
    Field(Field),
    Ranges,
    Angle,
    Coordinate,
    /// The number of the turn that a row of a list is of.
    Turn,
    Other,
}

/// The names that columns have in the tables of `rostopic echo -p`, of MATLAB and of scripts, in small letters and without
/// parents, units and numbers; `angule` is written by the frame grabber of RPLIDAR.
const NAMES: &[(Part, &[&str])] = &[
    (Part::Stamp, &["stamp", "timestamp", "time_stamp"]),
    (Part::Recorded, &["time", "t", "log_time", "rosbagtimestamp", "datetime", "date"]),
    (Part::Seconds, &["sec", "secs", "seconds"]),
    (Part::Nanoseconds, &["nsec", "nsecs", "nanosec", "nanosecs"]),
    (Part::Frame, &["frame_id", "frame"]),
    (Part::Field(|scan| &mut scan.angle_min), &["angle_min", "anglemin", "start_angle"]),
    (Part::Field(|scan| &mut scan.angle_max), &["angle_max", "anglemax", "end_angle"]),
    (Part::Field(|scan| &mut scan.angle_increment), &["angle_increment", "angleincrement"]),
    (Part::Field(|scan| &mut scan.time_increment), &["time_increment"]),
    (Part::Field(|scan| &mut scan.scan_time), &["scan_time"]),
    (Part::Field(|scan| &mut scan.range_min), &["range_min", "rangemin"]),
    (Part::Field(|scan| &mut scan.range_max), &["range_max", "rangemax"]),
    (
        Part::Ranges,
        &["ranges", "range", "r", "d", "dist", "distance", "distances", "beam", "laser", "rho", "radius", "depth", ""],
    ),
    (Part::Angle, &["angle", "angles", "angule", "theta", "bearing", "azimuth", "phi", "deg", "degree", "degrees"]),
    (Part::Coordinate, &["x", "y", "z"]),
    (
        Part::Turn,
        &["scan", "scan_id", "scan_no", "scan_number", "turn", "rev", "revolution", "rotation", "sweep", "seq"],
    ),
];

/// The columns of `ros2 topic echo --csv`, as `csv.columns` gives names: `*` is as many numbers as there are. Behind the ranges
/// there may be as many intensities.
const ECHO: &str = "stamp.sec,stamp.nanosec,frame_id,angle_min,angle_max,angle_increment,time_increment,scan_time,range_min,\
                    range_max,r*";
/// Units in names: of angles in radians, of times in nanoseconds.
const UNITS_RAD: [(&str, f64); 5] =
    [("deg", PI / 180.0), ("degree", PI / 180.0), ("degrees", PI / 180.0), ("rad", 1.0), ("radians", 1.0)];
const UNITS_NS: [(&str, f64); 4] = [("ns", 1.0), ("us", 1e3), ("ms", 1e6), ("s", NS_PER_S)];

/// What stands before the names of a pose.
const VEHICLES: [&str; 6] = ["robot", "pose", "odom", "vehicle", "pos", "base"];

/// Rows with fewer cells and no names are points, or pairs of angles and distances.
const LEAST_BARE_RANGES: usize = 8;
/// Words stand in one of the first columns, this many, or in the last: behind, they were what a beam says.
const LEAST_TAIL: usize = 3;
/// This many rows show that a column counts up, as no beam does.
const LEAST_COUNTING: usize = 5;
/// Numbers of a time since 1970, in seconds (from 2001 on) to nanoseconds. No range is as large in any unit.
const EPOCHS: RangeInclusive<f64> = 1e9..=4e18;
/// Whole numbers behind whole seconds are nanoseconds if some lie between these: as ranges they were kilometres in every unit.
const NANOSECONDS: RangeInclusive<f64> = 1e7..=NS_PER_S;
/// The steps of bearings are equal to within this share.
const EVEN: f64 = 0.05;
/// Bearings beyond those in radians are in degrees up to this.
const LARGEST_DEG: f64 = 361.0;

/// A scan is taken this many ns after the one before at the most: a column by which it takes longer counts another
/// unit.
const LONGEST_NS: f64 = 30.0 * NS_PER_S;
/// The row of a list is taken at most this many ns after the one before. A lidar takes points faster than one in the second time:
/// places that are farther apart are a way.
const LONGEST_ROW_NS: f64 = 0.1 * NS_PER_S;
const SLOW_NS: f64 = 0.005 * NS_PER_S;
/// Times that leap by more are not believed where another column tells the time.
const LEAP_NS: f64 = 24.0 * 3600.0 * NS_PER_S;
/// Of this many steps, one may lead back or leap.
const STEPS_A_LEAP: usize = 4;

/// A column with a time.
#[derive(Clone, Copy)]
pub(super) struct Time {
    pub(super) column: usize,
    /// Its unit in nanoseconds.
    pub(super) unit_ns: f64,
    /// The column of the nanoseconds after whole seconds.
    pub(super) rest: Option<usize>,
}

impl Time {
    /// From row to row.
    fn steps_ns(&self, rows: &[Vec<f64>]) -> Vec<f64> {
        let rest = |row: &Vec<f64>| self.rest.and_then(|rest| row.get(rest).copied()).unwrap_or(0.0);
        let times_ns = cells_of(rows, self.column).zip(rows).map(|(time, row)| time * self.unit_ns + rest(row));
        times_ns.clone().zip(times_ns.skip(1)).map(|(before, after)| after - before).collect()
    }
}

/// The cells of a column; NaN for those that are not there.
fn cells_of(rows: &[Vec<f64>], column: usize) -> impl DoubleEndedIterator<Item = f64> + Clone {
    rows.iter().map(move |row| row.get(column).copied().unwrap_or(f64::NAN))
}

/// What the columns hold.
#[derive(Default)]
pub(super) struct Layout {
    pub(super) names: Vec<String>,
    /// Columns with ranges, in the order of the beams.
    pub(super) ranges: Vec<usize>,
    /// The one column whose cells are lists of ranges in brackets, in place of `ranges`.
    pub(super) list: Option<usize>,
    /// Rows state their angles, and end in ranges with as many intensities or none: they may have another number of both.
    pub(super) varies: bool,
    /// A row of `ros2 topic echo --csv`, of which the names do not tell ranges from intensities.
    pub(super) is_echo: bool,
    pub(super) stamp: Option<Time>,
    pub(super) recorded: Option<Time>,
    pub(super) frame: Option<usize>,
    pub(super) fields: Vec<(usize, Field)>,
    /// Bearings of the first and the last range in radians, where the names of the columns are bearings.
    pub(super) bearings_rad: Option<[f64; 2]>,
    /// Metres in the unit of the ranges.
    pub(super) unit_m: f64,
    /// Of a table with a return a row, in place of ranges.
    pub(super) of_list: Option<Columns>,
    pub(super) pose: Option<Pose>,
    /// What was taken for what, in words.
    pub(super) taken: String,
}

/// The columns of x, y and yaw of the vehicle, with metres and radians in their units.
pub(super) struct Pose {
    pub(super) columns: [usize; 3],
    pub(super) units: [f64; 3],
}

impl Layout {
    /// Of a table whose columns have these names; `rows` are its first ones.
    ///
    /// # Errors
    /// When none of them are ranges: what the table is.
    pub(super) fn named(names: Vec<String>, rows: &[Vec<f64>]) -> Result<Self, Found> {
        let parsed: Vec<Name> = names.iter().map(|name| Name::of(name)).collect();
        let mut layout = Self { names, unit_m: 1.0, ..Self::default() };
        let are_of_rostopic = layout.names.iter().any(|name| name == "%time");
        layout.find_singles(&parsed, are_of_rostopic, rows);
        if !layout.find_ranges(&parsed, rows) && !layout.find_list(&parsed, rows) {
            let count = |is: fn(&Part) -> bool| parsed.iter().filter(|name| is(&name.part)).count();
            return Err(if count(|part| matches!(part, Part::Coordinate)) > 1 && layout.frame.is_none() {
                Found::PointTable
            } else {
                Found::OtherTable(listed(layout.names.iter()))
            });
        }
        layout.pose = layout.find_pose(&parsed, rows);
        layout.taken = layout.described();
        Ok(layout)
    }

    /// Of a table whose columns have the names in `pattern`, between commas; a `*` in a name stands for the numbers from 0 on that
    /// the other names leave.
    ///
    /// # Errors
    /// When none of them are ranges.
    pub(super) fn given(pattern: &str, rows: &[Vec<f64>]) -> Result<Self, Found> {
        Self::named(expanded(pattern, rows.first().map_or(0, Vec::len)), rows)
    }

    /// Of a table without names, of which this is the first row; `words` are the columns without any number.
    ///
    /// # Errors
    /// When its rows are no scans.
    pub(super) fn bare(cells: &[String], words: &[bool], rows: &[Vec<f64>]) -> Result<Self, Found> {
        if is_echo(cells) {
            let is_shortened = |cell: &String| cell == "..." || cell.starts_with("<sequence type");
            if cells.iter().any(is_shortened) {
                return Err(Found::ShortenedEcho);
            }
            let layout = Self::given(ECHO, rows).map_err(|_| Found::OtherTable(String::new()))?;
            return Ok(Self {
                is_echo: true,
                taken: "the fields of a LaserScan, as `ros2 topic echo --csv` writes them".to_owned(),
                ..layout
            });
        }
        // A label in words, or nothing, where every row ends in a separator.
        let has_no_number = |row: &Vec<f64>| row.len() == cells.len() && row.last().is_some_and(|cell| cell.is_nan());
        let ends_in_none = rows.len() > 1 && rows.iter().all(has_no_number);
        let (last, is_words) = (cells.len() - 1, |column: usize| words.get(column) == Some(&true));
        let is_left = |column: usize| (column < LEAST_TAIL || column == last) && is_words(column);
        let is_kept = |column: &usize| !(is_left(*column) || *column == last && ends_in_none);
        let kept: Vec<usize> = (0..cells.len()).filter(is_kept).collect();
        let of_kept =
            |row: &Vec<f64>| kept.iter().map(|column| row.get(*column).copied().unwrap_or(f64::NAN)).collect();
        let numbers: Vec<Vec<f64>> = rows.iter().map(of_kept).collect();
        let pattern = if kept.len() >= LEAST_BARE_RANGES {
            (if is_moment(&cells[kept[0]]) { "time,r*" } else { bare_pattern(&numbers) }).to_owned()
        } else {
            let found = if kept.len() == 2 { Found::AngleTable } else { Found::PointTable };
            let is_time = |column: usize| {
                is_moment(&cells[kept[column]]) || numbers.iter().all(|row| EPOCHS.contains(&row[column]))
            };
            List::guess(&numbers, is_time).ok_or(found)?.join(",")
        };
        let mut names = expanded(&pattern, kept.len()).into_iter();
        let names = (0..cells.len()).map(|column| if is_kept(&column) { names.next() } else { None });
        let mut layout = Self::named(names.map(|name| name.unwrap_or_else(|| "-".to_owned())).collect(), rows)?;
        let ranges =
            if layout.ranges.is_empty() { String::new() } else { format!(" with {} ranges", layout.ranges.len()) };
        layout.taken = format!("without names, taken as `{pattern}`{ranges}");
        for column in (0..cells.len()).filter(|column| !is_kept(column) && !cells[*column].is_empty()) {
            layout.taken += &format!("; column {} (words) is not used", column + 1);
        }
        Ok(layout)
    }

    /// The columns that stand alone: times, the frame and the geometry. A time whose first cell is no number is none.
    fn find_singles(&mut self, names: &[Name], are_of_rostopic: bool, rows: &[Vec<f64>]) {
        let of = |column: usize| cells_of(rows, column);
        let (mut seconds, mut nanoseconds, mut stamp, mut recorded) = (None, None, None, None);
        for (column, name) in names.iter().enumerate().filter(|(_, name)| name.number.is_none()) {
            // A unit that is not stated is 0, and found below.
            let unit_ns = if are_of_rostopic { 1.0 } else { name.unit_of(&UNITS_NS).unwrap_or(0.0) };
            let time =
                || Some(Time { column, unit_ns, rest: None }).filter(|_| !of(column).next().is_none_or(f64::is_nan));
            match name.part {
                Part::Stamp => stamp = stamp.or_else(time),
                Part::Recorded => recorded = recorded.or_else(time),
                Part::Seconds => {
                    seconds = seconds.or_else(|| Some(Time { unit_ns: NS_PER_S, ..time()? }));
                }
                Part::Nanoseconds => nanoseconds = nanoseconds.or(Some(column)),
                Part::Frame => self.frame = self.frame.or(Some(column)),
                Part::Field(field) => self.fields.push((column, field)),
                _ => {}
            }
        }
        match (seconds, nanoseconds) {
            (Some(seconds), Some(_)) => stamp = Some(Time { rest: nanoseconds, ..seconds }),
            (Some(_), None) => recorded = recorded.or(seconds),
            _ => {}
        }
        // A unit that another column states decides; rows of a list are of no use for that.
        let stated = [stamp, recorded].into_iter().flatten().find(|time| time.unit_ns > 0.0);
        let known_ns = stated.and_then(|time| Some(of(time.column).next()? * time.unit_ns));
        for time in [&mut stamp, &mut recorded].into_iter().flatten().filter(|time| time.unit_ns == 0.0) {
            let is_list = names.len() < LEAST_BARE_RANGES && names.iter().any(|name| matches!(name.part, Part::Angle));
            time.unit_ns = unit_ns(of(time.column), known_ns, if is_list { LONGEST_ROW_NS } else { LONGEST_NS });
        }
        let moves = |time: &Time| {
            let steps_ns = time.steps_ns(rows);
            let odd = steps_ns.iter().filter(|step_ns| **step_ns < 0.0 || **step_ns > LEAP_NS).count();
            steps_ns.len() < 2
                || (steps_ns.iter().any(|step_ns| *step_ns > 0.0) && STEPS_A_LEAP * odd <= steps_ns.len())
        };
        let counts = || {
            let is_even = |column: usize| rows.windows(2).all(|pair| pair[1].get(column) > pair[0].get(column));
            (0..names.len()).any(|column| matches!(names[column].part, Part::Turn | Part::Other) && is_even(column))
        };
        let is_zero = |time: &Time| of(time.column).all(|value| value == 0.0);
        let moving = [stamp, recorded].into_iter().flatten().find(moves);
        self.stamp = moving.or_else(|| stamp.or(recorded).filter(|time| !is_zero(time) && !counts()));
        self.recorded = recorded.filter(moves).or(self.stamp);
    }

    /// The ranges are the columns of a name for ranges and a number, of which there are most with one name; or those that are
    /// named by bearings; or a list in one cell.
    fn find_ranges(&mut self, names: &[Name], rows: &[Vec<f64>]) -> bool {
        let of_numbers = self.names.iter().enumerate().filter_map(|(i, name)| Some((i, name.parse::<f64>().ok()?)));
        let (columns, bearings): (Vec<usize>, Vec<f64>) = of_numbers.unzip();
        self.bearings_rad = bearings_rad(&bearings);
        let mut groups: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (column, name) in names.iter().enumerate().filter(|(_, name)| matches!(name.part, Part::Ranges)) {
            match name.number {
                Some(_) => groups.entry(&name.stem).or_default().push(column),
                None if name.stem == "ranges" && cells_of(rows, column).all(f64::is_nan) => {
                    self.list = self.list.or(Some(column));
                }
                None => {}
            }
        }
        let group = groups.into_values().filter(|group| group.len() > 1).max_by_key(Vec::len);
        match (self.bearings_rad, group) {
            (Some(_), _) => self.ranges = columns,
            (None, Some(group)) => self.ranges = group,
            (None, None) => return self.list.is_some(),
        }
        if self.bearings_rad.is_none() {
            self.ranges.sort_by_key(|column| names[*column].number);
        }
        self.list = None;
        let (first, last) = (self.ranges[0], self.ranges[self.ranges.len() - 1]);
        let behind = &names[last.max(first) + 1..];
        self.varies = self.ranges.is_sorted()
            && last - first + 1 == self.ranges.len()
            && behind.iter().all(|name| name.number.is_some())
            && [0, self.ranges.len()].contains(&behind.len())
            && !self.fields.is_empty();
        self.unit_m = names[first].unit_of(&UNITS_M).unwrap_or(self.unit_m);
        true
    }

    /// A list has an angle and a distance in each row, or x and y.
    fn find_list(&mut self, names: &[Name], rows: &[Vec<f64>]) -> bool {
        let at = |is: &dyn Fn(&Name) -> bool| names.iter().position(|name| is(name) && !name.stem.is_empty());
        let angle = at(&|name| matches!(name.part, Part::Angle));
        let distance = at(&|name| matches!(name.part, Part::Ranges) && name.number.is_none());
        let [x, y, z] =
            ["x", "y", "z"].map(|axis| at(&|name| matches!(name.part, Part::Coordinate) && name.stem == axis));
        let numbers = |column: &usize| rows.iter().all(|row| row.get(*column).is_some_and(|number| number.is_finite()));
        let turn = at(&|name| matches!(name.part, Part::Turn)).or(self.frame).filter(numbers);
        let columns = match (angle.zip(distance), x.zip(y)) {
            (Some((first, second)), _) => {
                let (unit_rad, unit_m) = (names[first].unit_of(&UNITS_RAD), names[second].unit_of(&UNITS_M));
                Columns { first, second, turn, unit_rad, unit_m, ..Columns::default() }
            }
            (None, Some((first, second))) if angle.is_none() && (self.frame.is_none() || self.frame == turn) => {
                let unit_m = names[first].unit_of(&UNITS_M);
                Columns { first, second, third: z, are_points: true, turn, unit_m, ..Columns::default() }
            }
            _ => return false,
        };
        // Places that come as slowly as those of a vehicle are its way.
        let is_slow = |time: Time| usual(time.steps_ns(rows)).is_some_and(|step_ns| step_ns >= SLOW_NS);
        let is_way = columns.are_points && turn.is_none() && self.stamp.is_some_and(is_slow);
        self.of_list = Some(columns).filter(|_| !is_way);
        self.frame = self.frame.filter(|frame| Some(*frame) != turn);
        self.of_list.is_some()
    }

    /// The pose of the vehicle, beside what the scan is: x, y and an angle, with names such as `robot_x` or alone. In a list, an
    /// angle alone may be that of the row in another unit.
    fn find_pose(&self, names: &[Name], rows: &[Vec<f64>]) -> Option<Pose> {
        let used = self.used();
        let at = |alone: &[&str], of_vehicle: &[&str]| {
            let is = |column: &usize| {
                let stem = names[*column].stem.as_str();
                let is_of_vehicle = |(of, what)| VEHICLES.contains(&of) && of_vehicle.contains(&what);
                names[*column].number.is_none()
                    && (alone.contains(&stem) || stem.split_once('_').is_some_and(is_of_vehicle))
            };
            (0..names.len()).filter(is).find(|column| !used.contains(column))
        };
        let angles = ["yaw", "heading", "theta", "th", "phi", "angle"];
        let alone = if self.of_list.is_some() { &angles[..2] } else { &angles[..] };
        let columns = [at(&["x"], &["x"])?, at(&["y"], &["y"])?, at(alone, &angles)?];
        let [x, y, yaw] = columns;
        let largest = cells_of(rows, yaw).fold(0.0, |largest: f64, angle| largest.max(angle.abs()));
        let by_size = if largest > LARGEST_RAD { PI / 180.0 } else { 1.0 };
        let metres = |column: usize| names[column].unit_of(&UNITS_M).unwrap_or(1.0);
        Some(Pose { columns, units: [metres(x), metres(y), names[yaw].unit_of(&UNITS_RAD).unwrap_or(by_size)] })
    }

    /// The columns that the scan is made of, without times.
    fn used(&self) -> Vec<usize> {
        let mut used: Vec<usize> = self.ranges.iter().copied().chain(self.list).chain(self.frame).collect();
        used.extend(self.fields.iter().map(|(column, _)| column));
        let of_list = self.of_list.map(|list| [Some(list.first), Some(list.second), list.third, list.turn]);
        used.extend(of_list.into_iter().flatten().flatten());
        used
    }

    /// What was taken for what.
    fn described(&self) -> String {
        let name = |column: usize| &self.names[column];
        let mut used = self.used();
        let mut taken = match (self.list, &self.ranges[..]) {
            _ if self.of_list.is_some() => format!("{} in each row", listed(used.iter().map(|column| name(*column)))),
            (None, [first, .., last]) => {
                format!("`{}` to `{}` are the {} ranges", name(*first), name(*last), self.ranges.len())
            }
            (list, _) => format!("`{}` has the ranges", name(list.unwrap_or(0))),
        };
        for (what, time) in [("stamp", self.stamp), ("time of recording", self.recorded)] {
            let Some(time) = time.filter(|time| !used.contains(&time.column)) else { continue };
            let columns = || [Some(time.column), time.rest].into_iter().flatten();
            let unit = UNITS_NS.iter().find(|(_, ns)| *ns == time.unit_ns && time.rest.is_none());
            let unit = unit.map(|(unit, _)| format!(" in {unit}")).unwrap_or_default();
            taken += &format!(", {what} by {}{unit}", listed(columns().map(name)));
            used.extend(columns());
        }
        if let Some(pose) = &self.pose {
            taken += &format!(", {} are the odometry", listed(pose.columns.iter().map(|column| name(*column))));
            used.extend(pose.columns);
        }
        if !self.fields.is_empty() {
            taken += &format!(", {} state the geometry", listed(self.fields.iter().map(|(column, _)| name(*column))));
        }
        let used: BTreeSet<usize> = used.into_iter().collect();
        let is_left = |(column, name): &(usize, &String)| !name.is_empty() && !used.contains(column);
        let left = self.names.iter().enumerate().filter(is_left).map(|(_, name)| name);
        if left.clone().next().is_some() {
            taken += &format!("; not used: {}", listed(left));
        }
        taken
    }
}

/// The name of a column, taken apart.
struct Name {
    part: Part,
    /// Its last part, in small letters, without its unit and its number.
    stem: String,
    /// The number at its end.
    number: Option<u64>,
    unit: String,
}

impl Name {
    /// What its unit is, of these.
    fn unit_of(&self, units: &[(&str, f64)]) -> Option<f64> {
        units.iter().find(|(unit, _)| *unit == self.unit).map(|(_, value)| *value)
    }

    fn of(text: &str) -> Self {
        let mut rest = text.trim().to_lowercase();
        let (mut number, mut unit) = (None, String::new());
        let is_unit = |word: &str| UNITS_M.iter().chain(&UNITS_NS).chain(&UNITS_RAD).any(|(unit, _)| *unit == word);
        loop {
            rest.truncate(rest.trim_end_matches(|c: char| !c.is_alphanumeric()).len());
            let word_at = rest.trim_end_matches(char::is_alphanumeric).len();
            let number_at = rest.trim_end_matches(|c: char| c.is_ascii_digit()).len();
            if word_at > 0 && is_unit(&rest[word_at..]) {
                unit = rest.split_off(word_at);
            } else if number.is_none() && number_at < rest.len() {
                number = rest.split_off(number_at).parse().ok();
            } else {
                break;
            }
        }
        // A unit alone names what has that unit.
        let is_of = |units: &[(&str, f64)]| units.iter().any(|(unit, _)| *unit == rest);
        if unit.is_empty() && number.is_none() && (is_of(&UNITS_M) || is_of(&UNITS_RAD)) {
            let stem = if is_of(&UNITS_M) { "range" } else { "angle" };
            unit = std::mem::replace(&mut rest, stem.to_owned());
        }
        // Scripts join the names of a stamp by `_`, as in `header_stamp_sec`.
        let of_stamp = || rest.rsplit_once('_').filter(|(of, rest)| of.ends_with("stamp") && rest.contains("sec"));
        let (parent, stem) = rest.rsplit_once(['.', '/', ':']).or_else(of_stamp).unwrap_or(("", &rest));
        let stem: String = stem.trim_start_matches(|c: char| !c.is_alphanumeric()).replace(' ', "_");
        let known = NAMES.iter().find(|(_, names)| names.contains(&stem.as_str()));
        let is_in_time = parent.is_empty() || parent.contains("stamp") || parent.contains("time");
        let part = match known.map_or(Part::Other, |(part, _)| *part) {
            Part::Seconds | Part::Nanoseconds if !is_in_time => Part::Other,
            Part::Other if ["range", "dist"].iter().any(|start| stem.starts_with(start)) => Part::Ranges,
            part => part,
        };
        Self { part, stem, number, unit }
    }
}

/// Whether the cells of a first line are the names of columns: words where the line after it has numbers, or numbers that count
/// up or are evenly spaced, as no ranges are.
pub(super) fn are_names(cells: &[String], numbers: &[f64], next: &[f64]) -> bool {
    let is_word =
        |cell: &str| cell.starts_with(|c: char| c.is_alphabetic() || "_%".contains(c)) && cell.parse::<f64>().is_err();
    // Of a writer that gives every row a number, the first name is empty.
    let from = usize::from(cells.first().is_some_and(String::is_empty));
    let counts_from =
        |start: usize| cells[from..].iter().zip(start..).all(|(cell, number)| *cell == number.to_string());
    let counts = cells.len() >= LEAST_BARE_RANGES && (counts_from(0) || counts_from(1));
    counts
        || bearings_rad(&numbers[from..]).is_some()
        || cells.iter().zip(next).any(|(cell, below)| is_word(cell) && !below.is_nan())
}

/// Bearings of the first and the last beam in radians, if these are the bearings of beams: evenly spaced numbers that are no
/// count.
fn bearings_rad(bearings: &[f64]) -> Option<[f64; 2]> {
    let (&[first, .., last], true) = (bearings, bearings.len() >= LEAST_BARE_RANGES) else { return None };
    let (span, step) = ((last - first).abs(), (last - first) / (bearings.len() - 1) as f64);
    let is_even = bearings.windows(2).all(|pair| ((pair[1] - pair[0]) / step - 1.0).abs() <= EVEN);
    let is_count = first.fract() == 0.0 && first >= 0.0 && step == 1.0;
    let to_rad = if span <= LARGEST_RAD && first.abs() <= LARGEST_RAD { 1.0 } else { 1f64.to_radians() };
    let is_turn = step != 0.0 && first.abs() <= LARGEST_DEG && span <= LARGEST_DEG;
    (is_even && is_turn && !is_count).then_some([first * to_rad, last * to_rad])
}

/// Nanoseconds in the unit of times without a stated one: that by which they are nearest to a time that is known; else
/// they lie in this century or are in seconds, unless a scan would take too long by that.
fn unit_ns(mut times: impl Iterator<Item = f64> + Clone, known_ns: Option<f64>, longest_ns: f64) -> f64 {
    let steps = times.clone().zip(times.clone().skip(1)).map(|(before, after)| after - before);
    let step = usual(steps.filter(|step| *step > 0.0)).unwrap_or(0.0);
    let first = times.next().unwrap_or(f64::NAN);
    if let Some(known_ns) = known_ns.filter(|known_ns| *known_ns > 0.0) {
        let off = |unit_ns: f64| (first * unit_ns / known_ns).ln().abs();
        return UNITS_NS.map(|(_, ns)| ns).into_iter().min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(NS_PER_S);
    }
    let by_size = [(1e17, 1.0), (1e14, 1e3), (1e11, 1e6)].iter().find(|(from, _)| first >= *from);
    let smaller = UNITS_NS.iter().rev().map(|(_, ns)| *ns);
    let by_size = by_size.map_or(NS_PER_S, |(_, unit)| *unit);
    let fits = |unit_ns: &f64| *unit_ns <= by_size && step * unit_ns <= longest_ns;
    smaller.into_iter().find(fits).unwrap_or(by_size)
}

/// Names of this many columns, as a pattern gives them: a `*` in a name stands for the numbers from 0 on that the
/// others leave.
fn expanded(pattern: &str, columns: usize) -> Vec<String> {
    let names: Vec<&str> = pattern.split(',').map(str::trim).collect();
    let left = (columns + 1).saturating_sub(names.len());
    let many = |name: &str| if name.contains('*') { left } else { 1 };
    let numbered = names.iter().flat_map(|name| (0..many(name)).map(|number| name.replace('*', &number.to_string())));
    numbered.collect()
}

/// Whether a cell is a date with a time, or a time of day, and no number.
pub(super) fn is_moment(cell: &str) -> bool {
    cell.contains(':') && cell.starts_with(|c: char| c.is_ascii_digit())
}

/// Whether a row begins with the header of a message.
fn is_echo(cells: &[String]) -> bool {
    let [sec, nanosec, frame, _, ..] = cells else { return false };
    let is_stamp = sec.parse::<i32>().is_ok() && nanosec.parse::<u32>().is_ok_and(|nanosec| nanosec < 1_000_000_000);
    is_stamp && frame.parse::<f64>().is_err()
}

/// The columns of rows without names, as `csv.columns` gives names: ranges alone, or behind a time, its seconds and nanoseconds, or
/// the number of the row.
fn bare_pattern(rows: &[Vec<f64>]) -> &'static str {
    let column = |column: usize| cells_of(rows, column);
    let are_epochs = |of: usize| column(of).all(|number| EPOCHS.contains(&number));
    let rises = |of: usize| column(of).is_sorted() && column(of).next() < column(of).next_back();
    let is_whole = |of: usize| column(of).all(|number| number.fract() == 0.0);
    let [first, second] = [0, 1].map(|row: usize| rows.get(row).map_or(f64::NAN, |row| row[0]));
    if are_epochs(0) && !are_epochs(2) {
        let has_nanoseconds = is_whole(1) && column(1).any(|number| NANOSECONDS.contains(&number));
        return if is_whole(0) && has_nanoseconds { "sec,nsec,r*" } else { "time,r*" };
    }
    if rows.len() < LEAST_COUNTING || ![0.0, 1.0].contains(&first) || !rises(0) || rises(1) {
        return "r*";
    }
    let counts = second - first == 1.0 && column(0).zip(column(0).skip(1)).all(|(a, b)| b - a == 1.0);
    if counts { "row,r*" } else { "time,r*" }
}

/// The first of these names.
fn listed<'a>(names: impl Iterator<Item = &'a String> + Clone) -> String {
    const LISTED: usize = 6;
    let first: Vec<_> = names.clone().take(LISTED).map(|name| format!("`{name:.30}`")).collect();
    let more = names.count().saturating_sub(LISTED);
    first.join(", ") + &if more > 0 { format!(" and {more} more") } else { String::new() }
}
