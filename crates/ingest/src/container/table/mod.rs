//! Tables of ranges, such as CSV: one scan a row, or one return a row ([`list`]). What its columns hold is known by
//! their names ([`layout`]), which `csv.columns` gives where the table does not; where its beams look, settings say
//! where no column does.

mod layout;
mod list;

use std::collections::{BTreeMap, VecDeque};
use std::io::{self, BufReader, Seek as _};
use std::path::Path;

use crosscut_messages::{
    Endian, Header, LaserScan, Message as _, NS_PER_S, Odometry, POINTS_TOPIC, PointCloud2, SCAN_TOPIC, Time,
};
use crosscut_sensor::{CsvGeometry, rescale};
use csv::StringRecord;
use jiff::Timestamp;
use jiff::civil::{DateTime, date};
use jiff::tz::TimeZone;

use self::layout::Layout;
use self::list::{List, Row, Seen};
use super::carmen::odometry;
use super::lines::{Line, LineFormat, next_line};
use super::resting_file::RestingFile;
use super::{ChannelId, Message, Topic};
use crate::order::usual;
use crate::{Found, IngestError};

/// The only channel; of a list of points, its clouds.
const SCANS: ChannelId = 0;
/// What a row of a list that cannot be read is lost of: it is no message.
const ROWS: ChannelId = 1;
const ODOMETRY: ChannelId = 2;
/// This many rows show what the columns hold; less, if they take more than that.
const SAMPLED_ROWS: usize = 64;
const SAMPLED_BYTES: usize = 16 << 20;
/// Of rows that are as short as those of a list, this many bytes do.
const LIST_BYTES: usize = 1 << 19;
const SHORT_BYTES: usize = 160;
/// Lines of words between turns are fewer than rows by this factor.
const LEAST_BETWEEN: usize = 4;
/// Around the numbers of a row, or of a list in a cell.
const BRACKETS: [char; 4] = ['[', ']', '(', ')'];
/// The words that stand for no number, in small letters.
const NO_NUMBER: [&str; 6] = ["", "na", "n/a", "none", "null", "-"];
/// Ranges may be this many more or fewer than the angles of their row state, beside this share of them.
const SPARE_BEAMS: f64 = 2.0;
const SPARE_SHARE: f64 = 0.05;

/// Numbers of beams, and the bearings of the first and the last of them in degrees.
const VIEWS_DEG: [(usize, [f64; 2]); 5] =
    [(360, [0.0, 359.0]), (181, [-90.0, 90.0]), (361, [-90.0, 90.0]), (541, [-135.0, 135.0]), (1081, [-135.0, 135.0])];
/// The logarithm of the factor by which ranges next to each other usually differ at most.
const CLOSED: f64 = 0.1;

/// A table whose columns are known.
pub(super) struct Table {
    settings: CsvGeometry,
    dialect: Dialect,
    layout: Layout,
    list: Option<List>,
    /// Line of the first row.
    first_row: u64,
    /// The [`shape`] of lines that are no rows: of the names, which may come again where files were joined, or of words
    /// between turns.
    between: Option<String>,
}

impl Table {
    /// Looks at the first rows of `file`; `path` names it in errors.
    ///
    /// # Errors
    /// When its rows are no scans, or neither it nor `settings` say where their beams look.
    pub(super) fn look(path: &Path, file: &mut RestingFile, settings: &CsvGeometry) -> Result<Self, IngestError> {
        let mut lines = first_lines(file).map_err(|source| IngestError::cannot_open(path, source))?;
        let between = between(&lines);
        lines.retain(|line| between.as_ref() != Some(&shape(&line.text)));
        let (mut table, rows) = Self::of(lines, settings, between)
            .map_err(|found| IngestError::NotRecording { path: path.to_owned(), found })?;
        // A scan of which the directions are not stated has none.
        let states_directions = |line: &Line| {
            table.scan(line).is_ok_and(|(scan, _)| scan.angle_min.is_finite() && scan.angle_max.is_finite())
        };
        if table.list.is_some() || table.settings.is_known() || rows.iter().any(states_directions) {
            return Ok(table);
        }
        let scans = rows.iter().filter_map(|line| Some(table.scan(line).ok()?.0.ranges)).collect::<Vec<_>>();
        let Some([first_deg, last_deg]) = usual_view_deg(&scans) else {
            return Err(IngestError::NoGeometry { path: path.to_owned(), columns: table.layout.taken });
        };
        (table.settings.first_rad, table.settings.last_rad) = (first_deg.to_radians(), last_deg.to_radians());
        table.layout.taken += &format!(
            "; no directions are stated: taken from {first_deg}° to {last_deg}°, anticlockwise from ahead (csv.first_rad, \
             csv.last_rad)"
        );
        Ok(table)
    }

    /// By its first lines that are not blank; with those of them that are rows.
    fn of(mut lines: Vec<Line>, settings: &CsvGeometry, between: Option<String>) -> Result<(Self, Vec<Line>), Found> {
        let comments = lines.iter().take_while(|line| is_comment(&line.text)).count();
        let comment = lines.drain(..comments).next_back();
        lines.retain(|line| !is_comment(&line.text));
        let [first, rest @ ..] = &lines[..] else { return Err(Found::Text) };
        let dialect = Dialect::of(&rest.first().unwrap_or(first).text);
        let cells_of = |line: &Line| dialect.cells(&line.text).iter().map(str::to_owned).collect::<Vec<_>>();
        let is_no_number = |cell: &String| !cell.is_empty() && dialect.number(cell).is_none();
        // Without names, a time of day counts in the first column alone.
        let is_word = |(at, cell): (usize, &String)| is_no_number(cell) || (at > 0 && layout::is_moment(cell));
        let numbers_of = |line: &Line| dialect.numbers(&dialect.cells(&line.text));
        let next = rest.first().map(numbers_of).unwrap_or_default();
        let header = if layout::are_names(&cells_of(first), &numbers_of(first), &next) {
            Some(lines.remove(0))
        } else {
            // A comment has the names where it has as many words as the row after it has cells.
            let columns = cells_of(first).len();
            comment.filter(|comment| dialect.cells(names_in(&comment.text)).len() == columns)
        };
        let Some(first) = lines.first() else { return Err(Found::Text) };
        let cells = cells_of(first);
        let numbers = cells.iter().filter(|cell| dialect.number(cell).is_some()).count();
        if cells.len() < 2 || 2 * numbers < cells.len() {
            return Err(Found::Text);
        }
        let rows: Vec<Vec<f64>> = lines.iter().map(numbers_of).collect();
        let layout = if !settings.columns.is_empty() {
            Layout::given(&settings.columns, &rows)?
        } else if let Some(header) = &header {
            let names: Vec<_> = dialect.cells(names_in(&header.text)).iter().map(str::to_owned).collect();
            Layout::named(names, &rows)?
        } else if dialect.has_labels {
            Layout::named(labelled(&first.text).map(|(label, _)| label.to_owned()).collect(), &rows)?
        } else {
            let mut words: Vec<bool> = cells.iter().enumerate().map(is_word).collect();
            for line in lines.iter().take(SAMPLED_ROWS) {
                words
                    .iter_mut()
                    .zip(cells_of(line).iter().enumerate())
                    .for_each(|(words, cell)| *words &= is_word(cell));
            }
            Layout::bare(&cells, &words, &rows)?
        };
        let list = layout.of_list.map(|columns| {
            List::of(columns, &rows).ok_or(if columns.are_points { Found::PointTable } else { Found::AngleTable })
        });
        let list = list.transpose()?;
        let between = between.or(header.map(|header| shape(&header.text)));
        let mut settings = settings.clone();
        if let Some([first_rad, last_rad]) = layout.bearings_rad.filter(|_| !settings.is_known()) {
            (settings.first_rad, settings.last_rad) = (first_rad, last_rad);
        }
        let table = Self { settings, dialect, layout, list, first_row: first.number, between };
        if table.layout.is_echo && table.scan(first).is_err() {
            return Err(Found::OtherTable(String::new()));
        }
        Ok((table, lines))
    }

    /// The cells of a row, and whether there are as many as in the first one, which rows whose ranges vary need not have.
    fn row<'a>(&self, row: &'a StringRecord, is_ended: bool) -> Result<(Vec<&'a str>, bool), String> {
        let (layout, columns) = (&self.layout, self.layout.names.len());
        let mut cells: Vec<&str> = row.iter().collect();
        if (cells.len() != columns || layout.is_echo) && cells.last() == Some(&"") {
            cells.pop(); // some writers end every row by a separator
        }
        let is_whole = cells.len() == columns;
        if !(is_whole || layout.varies && is_ended && cells.len() > layout.ranges[0]) {
            return Err(format!("it has {} columns, the first line has {columns}", cells.len()));
        }
        Ok((cells, is_whole))
    }

    /// The scan in a row, and when it was recorded. Angles are NaN where nothing states them.
    fn scan(&self, line: &Line) -> Result<(LaserScan, u64), String> {
        let Self { layout, settings, .. } = self;
        let row = self.dialect.cells(&line.text);
        let (cells, is_whole) = self.row(&row, line.is_ended)?;
        let mut scan = LaserScan { range_max: f32::INFINITY, ..LaserScan::default() };
        (scan.angle_min, scan.angle_max, scan.angle_increment) = (f32::NAN, f32::NAN, f32::NAN);
        for &(column, field) in &layout.fields {
            let wrong = || format!("`{:.20}` in column {} is no number", cells[column], column + 1);
            *field(&mut scan) = self.dialect.number(cells[column]).ok_or_else(wrong)? as f32;
        }
        scan.ranges = match layout.list {
            Some(list) => {
                let list = cells[list].trim_matches(BRACKETS);
                self.ranges(list.split([',', ' ']).map(str::trim).filter(|cell| !cell.is_empty()))?
            }
            None if is_whole && !layout.is_echo => self.ranges(layout.ranges.iter().map(|column| cells[*column]))?,
            None => {
                let numbers = &cells[layout.ranges[0]..];
                self.ranges(numbers[..beams_of(&scan, numbers.len())?].iter().copied())?
            }
        };
        rescale(&mut scan, layout.unit_m);
        let steps = scan.ranges.len().saturating_sub(1);
        if settings.is_known() {
            (scan.angle_min, scan.angle_max) = (settings.first_rad as f32, settings.last_rad as f32);
            scan.angle_increment = ((settings.last_rad - settings.first_rad) / steps.max(1) as f64) as f32;
        } else if scan.angle_max.is_nan() {
            scan.angle_max = scan.angle_min + steps as f32 * scan.angle_increment;
        } else if scan.angle_increment.is_nan() {
            scan.angle_increment = 0.0;
        }
        if settings.range_max_m < f64::INFINITY {
            scan.range_max = settings.range_max_m as f32;
        }
        let time = |time: Option<layout::Time>| time.map(|time| self.time_ns(time, &cells)).transpose();
        // The first row is not at 0, which would be no stamp.
        let by_rate = || ((line.number - self.first_row + 1) as f64 * NS_PER_S / settings.rate_hz).round() as u64;
        let stamp_ns = time(layout.stamp)?.unwrap_or_else(by_rate);
        let frame_id = layout.frame.map_or("laser", |column| cells[column].trim_matches('"')).to_owned();
        scan.header = Header { stamp: Time::from_ns(stamp_ns), frame_id };
        Ok((scan, time(layout.recorded)?.unwrap_or(stamp_ns)))
    }

    /// The turn before the row of a list, if that row begins another.
    fn take_row(&mut self, line: &Line) -> Result<Option<(Seen, Row)>, String> {
        let row = self.dialect.cells(&line.text);
        let (cells, _) = self.row(&row, line.is_ended)?;
        let pose = self.pose(&cells);
        let time = |time: Option<layout::Time>| time.map(|time| self.time_ns(time, &cells)).transpose();
        let times_ns = [time(self.layout.stamp)?, time(self.layout.recorded)?];
        let number = |column: usize| self.dialect.number(cells[column]);
        let Some(list) = &mut self.list else { return Ok(None) };
        let used = [Some(list.columns.first), Some(list.columns.second), list.columns.third, list.columns.turn];
        if let Some(wrong) = used.into_iter().flatten().find(|column| number(*column).is_none()) {
            return Err(format!("`{:.20}` in column {} is no number", cells[wrong], wrong + 1));
        }
        if !number(list.columns.first).is_some_and(|first| list.may_be(first)) {
            return Err(format!("`{:.20}` is no angle", cells[list.columns.first]));
        }
        Ok(list.take(|column| number(column).unwrap_or(f64::NAN), times_ns, pose))
    }

    /// The pose of the vehicle in a row: x, y in metres and yaw in radians.
    fn pose(&self, cells: &[&str]) -> Option<[f64; 3]> {
        let pose = self.layout.pose.as_ref()?;
        let number = |at: usize| Some(self.dialect.number(cells.get(pose.columns[at])?)? * pose.units[at]);
        Some([number(0)?, number(1)?, number(2)?]).filter(|pose| pose.iter().all(|number| number.is_finite()))
    }

    /// The turn of a list that this row is the first of, behind the odometry of that row.
    fn give(&self, (seen, first): (Seen, Row), out: &mut VecDeque<Message>) {
        let turns = self.list.as_ref().map_or(1, |list| list.turns);
        let [stamp_ns, recorded_ns] = first.times_ns;
        let stamp_ns = stamp_ns.unwrap_or_else(|| (turns as f64 * NS_PER_S / self.settings.rate_hz).round() as u64);
        let header = Header { stamp: Time::from_ns(stamp_ns), frame_id: "laser".to_owned() };
        let data = match seen {
            Seen::Scan(mut scan) => {
                scan.range_max = self.settings.range_max_m as f32;
                LaserScan { header, ..scan }.encode(Endian::Little)
            }
            Seen::Cloud(mut cloud) => {
                cloud.header = header;
                PointCloud2::from(&cloud).encode(Endian::Little)
            }
        };
        let log_time_ns = recorded_ns.unwrap_or(stamp_ns);
        out.extend(first.pose.map(|pose| odometry_at(pose, stamp_ns, log_time_ns)));
        out.push_back(Message { channel: SCANS, log_time_ns, data, damage: None });
    }

    fn ranges<'a>(&self, cells: impl Iterator<Item = &'a str>) -> Result<Vec<f32>, String> {
        let range = |cell: &str| self.dialect.number(cell).ok_or_else(|| format!("`{cell:.20}` is no range"));
        cells.map(|cell| Ok(range(cell)? as f32)).collect()
    }

    fn time_ns(&self, layout::Time { column, unit_ns, rest }: layout::Time, cells: &[&str]) -> Result<u64, String> {
        let number = |column: usize| self.dialect.number(cells[column]).filter(|time| *time >= 0.0);
        let of_float = |column: usize| Some(number(column).filter(|time| time.fract() == 0.0)? as u64);
        let whole = |column: usize| cells[column].parse().ok().or_else(|| of_float(column));
        let time_ns = match rest {
            Some(rest) => whole(column)
                .and_then(|time_s: u64| time_s.checked_mul(1_000_000_000))
                .and_then(|time_ns| time_ns.checked_add(whole(rest)?)),
            None => {
                whole(column).filter(|_| unit_ns == 1.0).or_else(|| Some((number(column)? * unit_ns).round() as u64))
            }
        };
        time_ns.ok_or_else(|| format!("`{:.20}` is no time", cells[column]))
    }
}

/// How many of the numbers behind the geometry of a row are ranges: all, or, if its angles leave room for half of them only,
/// that half. The others are intensities.
fn beams_of(scan: &LaserScan, numbers: usize) -> Result<usize, String> {
    let stated = f64::from((scan.angle_max - scan.angle_min) / scan.angle_increment) + 1.0;
    let off = |beams: usize| (beams as f64 - stated).abs();
    let half = numbers / 2;
    let beams = if numbers.is_multiple_of(2) && off(half) < off(numbers) { half } else { numbers };
    let fits = off(beams) <= SPARE_BEAMS + SPARE_SHARE * stated;
    if fits { Ok(beams) } else { Err(format!("{numbers} numbers do not fit {stated:.0} beams, as its angles state")) }
}

impl LineFormat for Table {
    const NAME: &'static str = "table of ranges";
    const LAST_WORD_COUNTS: bool = true;

    fn survey(&mut self, line: &Line) {
        if self.list.is_some() {
            let _ = self.read(line, &mut VecDeque::new()); // errors are counted when the file is read
        }
    }

    fn properties(&self) -> Vec<(&'static str, String)> {
        let columns = format!("{}; between {}", self.layout.taken, self.dialect.name());
        let of_list = self.list.iter().flat_map(|list| [("rows", list.described()), ("turns", list.found())]);
        [("columns", columns)].into_iter().chain(of_list).collect()
    }

    fn channels(&self) -> BTreeMap<ChannelId, Topic> {
        let are_points = self.list.as_ref().is_some_and(|list| list.columns.are_points);
        let [topic, type_name] =
            if are_points { [POINTS_TOPIC, PointCloud2::SCHEMA_NAME] } else { [SCAN_TOPIC, LaserScan::SCHEMA_NAME] };
        let odometry = self.layout.pose.as_ref().map(|_| (ODOMETRY, Topic::in_cdr("/odom", Odometry::SCHEMA_NAME)));
        [(SCANS, Topic::in_cdr(topic, type_name))].into_iter().chain(odometry).collect()
    }

    fn read(&mut self, line: &Line, out: &mut VecDeque<Message>) -> Result<(), (ChannelId, String)> {
        match &mut self.list {
            Some(list) if line.number == self.first_row => list.restart(),
            Some(list) if line.number == Line::END => {
                if let Some(last) = list.turn() {
                    self.give(last, out);
                }
            }
            _ => {}
        }
        let is_row = line.number >= self.first_row && !line.text.trim().is_empty() && !is_comment(&line.text);
        let is_between = |between: &String| line.text.contains(char::is_alphabetic) && shape(&line.text) == *between;
        if !is_row || self.between.as_ref().is_some_and(is_between) {
            return Ok(());
        }
        if self.list.is_some() {
            if let Some(turn) = self.take_row(line).map_err(|cause| (ROWS, cause))? {
                self.give(turn, out);
            }
            return Ok(());
        }
        let (scan, log_time_ns) = self.scan(line).map_err(|cause| (SCANS, cause))?;
        if self.layout.pose.is_some() {
            let pose = self.pose(&self.dialect.cells(&line.text).iter().collect::<Vec<_>>());
            let stamp_ns = scan.header.stamp.to_ns().unwrap_or(log_time_ns);
            out.extend(pose.map(|pose| odometry_at(pose, stamp_ns, log_time_ns)));
        }
        out.push_back(Message { channel: SCANS, log_time_ns, data: scan.encode(Endian::Little), damage: None });
        Ok(())
    }
}

/// The lines that show what a table holds, without blank ones. The file is at its start again afterwards.
fn first_lines(file: &mut RestingFile) -> io::Result<Vec<Line>> {
    let mut input = BufReader::new(&mut *file);
    let (mut lines, mut number, mut bytes) = (Vec::<Line>::new(), 0, 0);
    let is_list = |lines: usize, bytes: usize| bytes < LIST_BYTES.min(SHORT_BYTES * lines);
    while (lines.len() <= SAMPLED_ROWS || is_list(lines.len(), bytes)) && bytes < SAMPLED_BYTES {
        let Some(line) = next_line(&mut input, &mut number)? else { break };
        bytes += line.text.len();
        // Of comments before the first row, the last may have the names.
        if lines.last().is_some_and(|last| is_comment(&last.text)) && is_comment(&line.text) {
            lines.pop();
        }
        if !line.text.trim().is_empty() {
            lines.push(line);
        }
    }
    file.rewind()?;
    Ok(lines)
}

/// The bearings of the first and the last beam in degrees, as lidars with this number of beams have them. Where another lidar may
/// have as many, the last beam of a full turn has to see what is next to the first one, and that of half a turn must not.
fn usual_view_deg(scans: &[Vec<f32>]) -> Option<[f64; 2]> {
    let beams = scans.first()?.len();
    let (_, view_deg) = *VIEWS_DEG.iter().find(|(of, _)| *of == beams)?;
    let factor = |a: f32, b: f32| Some(f64::from((a / b).ln().abs())).filter(|factor| factor.is_finite());
    let at_ends = usual(scans.iter().filter_map(|ranges| factor(*ranges.first()?, *ranges.last()?)));
    let next_to = scans.iter().flat_map(|ranges| ranges.windows(2)).filter_map(|pair| factor(pair[0], pair[1]));
    let closes = || Some(at_ends? <= CLOSED.max(2.0 * usual(next_to)?));
    (view_deg[1] == 135.0 || closes() == Some(view_deg[0] == 0.0)).then_some(view_deg)
}

fn is_comment(line: &str) -> bool {
    line.starts_with(['#', '%'])
}

/// The odometry in a row.
fn odometry_at(pose: [f64; 3], stamp_ns: u64, log_time_ns: u64) -> Message {
    Message { log_time_ns, ..odometry(ODOMETRY, pose, [0.0; 2], stamp_ns) }
}

/// The shape of lines of words that come again and again between rows: that of the first line, unless the line has the names.
fn between(lines: &[Line]) -> Option<String> {
    let mut rows = lines.iter().filter(|line| !is_comment(&line.text));
    let (first, next) = (rows.next()?, rows.next()?);
    let (dialect, between) = (Dialect::of(&next.text), shape(&first.text));
    let [words, below] = [first, next].map(|line| {
        let cells = dialect.cells(&line.text);
        cells.iter().map(|cell| dialect.number(cell).is_none()).collect::<Vec<_>>()
    });
    let again: Vec<_> = rows.clone().filter(|line| shape(&line.text) == between).collect();
    let is_header = words.len() == below.len() && again.iter().all(|line| line.text == first.text);
    // A row may have a word of its own, as a label.
    let is_row = words.len() == below.len() && words.iter().zip(&below).all(|(word, below)| !word || *below);
    let are_words = 2 * words.iter().filter(|word| **word).count() >= words.len() && below.contains(&false);
    let is_between = !again.is_empty() && LEAST_BETWEEN * again.len() < rows.count() && are_words;
    (is_between && !is_header && !is_row).then_some(between)
}

/// A line without its numbers.
fn shape(line: &str) -> String {
    line.chars().filter(|c| !c.is_ascii_digit() && !".+-".contains(*c)).collect()
}

/// The words of a row that stand before a number each, as in `theta: 1.5 Dist: 2.0`, with these numbers.
fn labelled(line: &str) -> impl Iterator<Item = (&str, &str)> {
    let parts = || line.split([':', '=']);
    let pairs = parts().zip(parts().skip(1));
    let pairs = pairs.filter_map(|(before, behind)| Some((words(before).next_back()?, words(behind).next()?)));
    pairs.filter(|(label, number)| label.starts_with(char::is_alphabetic) && number.parse::<f64>().is_ok())
}

fn words(text: &str) -> impl DoubleEndedIterator<Item = &str> {
    text.split(|c: char| c.is_whitespace() || "{}[]()\",;".contains(c)).filter(|word| !word.is_empty())
}

/// The names of a header, which may be a comment. `rostopic echo -p` begins it with `%time`.
fn names_in(header: &str) -> &str {
    header.trim_start_matches(['#', ' '])
}

/// Seconds since 1970 of a date with a time, which are UTC if nothing else is stated, or since midnight of a time of day.
fn seconds_of(cell: &str) -> Option<f64> {
    if !layout::is_moment(cell) {
        return None;
    }
    let of_day = || Some(date(1970, 1, 1).to_datetime(cell.parse().ok()?));
    let any = || cell.parse::<DateTime>().ok().or_else(of_day)?.to_zoned(TimeZone::UTC).ok();
    let moment = cell.parse::<Timestamp>().ok().or_else(|| Some(any()?.timestamp()))?;
    Some(moment.as_nanosecond() as f64 / NS_PER_S)
}

/// How the cells of a table are separated, and how its numbers are written.
#[derive(Clone, Copy)]
struct Dialect {
    /// `None` stands for any blanks.
    separator: Option<u8>,
    /// Each number stands behind its name, and nothing else counts.
    has_labels: bool,
}

impl Dialect {
    /// By a row. A comma may separate cells or be the decimal sign of cells between blanks.
    fn of(row: &str) -> Self {
        let separator = [b';', b'\t'].into_iter().find(|separator| row.trim().contains(char::from(*separator)));
        let has_decimal_commas = || {
            let mut words = row.split_whitespace();
            let blanks = Self { separator: None, has_labels: false };
            let is_number = |word: &str| blanks.number(word).is_some() && !word.ends_with(',');
            words.clone().count() > 1 && words.all(is_number)
        };
        let separator = separator.or_else(|| (row.contains(',') && !has_decimal_commas()).then_some(b','));
        Self { separator, has_labels: labelled(row).count() > 1 }
    }

    /// Its separator in words.
    fn name(self) -> String {
        let by = |separator: u8| format!("`{}`", separator.escape_ascii());
        if self.has_labels { "their names".to_owned() } else { self.separator.map_or("blanks".to_owned(), by) }
    }

    /// The cells of a line, without quotes and blanks around them.
    fn cells(self, line: &str) -> StringRecord {
        if self.has_labels {
            return labelled(line).map(|(_, number)| number).collect();
        }
        // The crate builds a reader for each line, which takes longer than to read a short one.
        if !line.contains('"') {
            return match self.separator {
                Some(separator) => line.split(char::from(separator)).map(str::trim).collect(),
                None => line.split_whitespace().collect(),
            };
        }
        let words = || line.split_whitespace().collect::<Vec<_>>().join(" ");
        let text = if self.separator.is_some() { line.to_owned() } else { words() };
        let mut reader = csv::ReaderBuilder::new();
        reader.has_headers(false).delimiter(self.separator.unwrap_or(b' ')).trim(csv::Trim::All);
        let row = reader.from_reader(text.as_bytes()).records().next();
        row.and_then(Result::ok).unwrap_or_default()
    }

    /// The number in a cell; NaN where it says that there is none; of a date or a time of day its seconds. Where commas do not
    /// separate cells, they may be decimal signs.
    fn number(self, cell: &str) -> Option<f64> {
        let cell = cell.trim_matches(BRACKETS);
        let is_none = || NO_NUMBER.contains(&cell.to_ascii_lowercase().as_str()).then_some(f64::NAN);
        let with_point = || cell.replace(',', ".").parse().ok().filter(|_| self.separator != Some(b','));
        cell.parse().ok().or_else(with_point).or_else(is_none).or_else(|| seconds_of(cell))
    }

    /// The numbers of a row; NaN for other cells.
    fn numbers(self, cells: &StringRecord) -> Vec<f64> {
        cells.iter().map(|cell| self.number(cell).unwrap_or(f64::NAN)).collect()
    }
}
