//! Tables of ranges, such as CSV: one scan a row. What its columns hold is found by their names and by the first rows; where
//! the table does not say where its beams look, settings do.

mod columns;
mod dialect;
mod echo;
mod names;

use std::collections::{BTreeMap, VecDeque};
use std::io::{self, BufReader, Seek as _};
use std::path::Path;

use crosscut_messages::{CDR_ENCODING, Endian, Header, LaserScan, Message as _, SCAN_TOPIC, SCHEMA_ENCODING, Time};
use crosscut_sensor::{CsvGeometry, rescale};

use self::columns::{Columns, TimeColumn};
pub(crate) use self::dialect::Dialect;
use self::names::{Geometry, NS_PER_S};
use super::lines::{Line, LineFormat, next_line};
use super::resting_file::RestingFile;
use super::{ChannelId, Message, Topic};
use crate::{Found, IngestError};

/// The only channel.
const SCANS: ChannelId = 0;

/// This many rows show what the columns hold; less, if they take more than that.
const SAMPLED_ROWS: usize = 64;
const SAMPLED_BYTES: usize = 16 << 20;

/// A table whose columns are known.
pub(super) struct Table {
    settings: CsvGeometry,
    dialect: Dialect,
    rows: Rows,
    /// Line of the first row, and the line with the names, which may come again where files were joined.
    first_row: u64,
    header: Option<String>,
}

/// What rows are.
enum Rows {
    /// Ranges in columns.
    Columns(Box<Columns>),
    /// Messages as `ros2 topic echo --csv` writes them.
    Echo,
}

/// The first lines of a table.
#[derive(Default)]
struct Sample {
    /// The last line before the first row that may have the names.
    header: Option<String>,
    rows: Vec<String>,
    first_row: u64,
}

impl Table {
    /// Looks at the first rows of `file`; `path` names it in errors.
    ///
    /// # Errors
    /// When its rows are no scans, or neither it nor `settings` say where their beams look.
    pub(super) fn look(path: &Path, file: &mut RestingFile, settings: CsvGeometry) -> Result<Self, IngestError> {
        let sample = Sample::of(file).map_err(|source| IngestError::cannot_open(path, source))?;
        let Some(table) = Self::of(sample, settings) else {
            return Err(IngestError::NotRecording { path: path.to_owned(), found: Found::OtherTable(String::new()) });
        };
        let table = table.map_err(|found| IngestError::NotRecording { path: path.to_owned(), found })?;
        let states_geometry = match &table.rows {
            Rows::Columns(columns) => {
                let Columns { geometry, bearings_rad, .. } = &**columns;
                let states = |part| geometry.contains_key(&part);
                let has_step = states(Geometry::AngleIncrement) || states(Geometry::AngleMax);
                bearings_rad.is_some() || states(Geometry::AngleMin) && has_step
            }
            Rows::Echo => true,
        };
        if settings.is_known() || states_geometry {
            Ok(table)
        } else {
            Err(IngestError::NoGeometry { path: path.to_owned(), columns: table.taken() })
        }
    }

    /// `None` if there is no line.
    fn of(sample: Sample, settings: CsvGeometry) -> Option<Result<Self, Found>> {
        let Sample { header, rows, first_row } = sample;
        let (first, is_names) = match (&header, rows.first()) {
            (_, Some(row)) => (row.clone(), false),
            (Some(header), None) => (header.clone(), true),
            (None, None) => return None,
        };
        let dialect = Dialect::of(header.as_deref().filter(|header| header.contains([';', '\t'])).unwrap_or(&first));
        let cells = dialect.cells(&first);
        // A comment is a header where it has as many words as the row after it has cells.
        let names = header.as_deref().map(|header| (is_comment(header), dialect.cells(names_in(header))));
        let names =
            names.filter(|(is_comment, names)| !is_comment || names.len() == cells.len()).map(|(_, names)| names);
        let numbers: Vec<_> = rows.iter().map(|row| columns::numbers(dialect, &dialect.cells(row))).collect();
        let columns = match names {
            Some(names) => Columns::named(&names, &numbers).map(Box::new).map(Rows::Columns),
            None if is_names => Columns::named(&cells, &[]).map(Box::new).map(Rows::Columns),
            None if !echo::has_header(dialect, &cells) => {
                Columns::bare(cells.len(), &numbers).map(Box::new).map(Rows::Columns)
            }
            None if echo::is_shortened(&cells) => Err(Found::ShortenedEcho),
            None if echo::is_scan(dialect, &cells) => Ok(Rows::Echo),
            None => Err(Found::OtherTable(String::new())),
        };
        Some(columns.map(|rows| Self { settings, dialect, rows, first_row, header }))
    }

    /// What the columns were taken for.
    fn taken(&self) -> String {
        match &self.rows {
            Rows::Columns(columns) => format!("{}; between {}", columns.taken, self.dialect.name()),
            Rows::Echo => "the fields of a LaserScan, as `ros2 topic echo --csv` writes them".to_owned(),
        }
    }

    /// The scan in a row, and when it was recorded.
    fn scan(&self, line: &Line) -> Result<(LaserScan, u64), String> {
        let cells = self.dialect.cells(&line.text);
        let (mut scan, recorded_ns) = match &self.rows {
            Rows::Echo => (echo::scan(self.dialect, &cells)?, None),
            Rows::Columns(columns) => self.scan_of(columns, &cells, line)?,
        };
        self.overrule(&mut scan);
        let stamp_ns = scan.header.stamp.to_ns().unwrap_or(0);
        Ok((scan, recorded_ns.unwrap_or(stamp_ns)))
    }

    fn scan_of(&self, columns: &Columns, cells: &[&str], line: &Line) -> Result<(LaserScan, Option<u64>), String> {
        let cells = cells.strip_suffix(&[""]).filter(|cells| cells.len() == columns.count).unwrap_or(cells);
        let has_other_count = || columns.may_vary && line.is_ended && cells.len() > columns.ranges[0];
        if cells.len() != columns.count && !has_other_count() {
            return Err(format!("it has {} columns, the first line has {}", cells.len(), columns.count));
        }
        let mut scan = LaserScan::default();
        self.read_ranges(columns, cells, &mut scan.ranges)?;
        let time = |time: Option<TimeColumn>| time.map(|time| self.time_ns(time, cells)).transpose();
        // The first row is not at 0, which would be no stamp.
        let by_rate = || ((line.number - self.first_row + 1) as f64 * NS_PER_S / self.settings.rate_hz).round() as u64;
        let stamp_ns = time(columns.stamp)?.unwrap_or_else(by_rate);
        let frame_id = columns.frame.map_or("laser", |column| cells[column]).to_owned();
        scan.header = Header { stamp: Time::from_ns(stamp_ns), frame_id };
        scan.range_max = f32::INFINITY;
        if let Some([first_rad, last_rad]) = columns.bearings_rad {
            (scan.angle_min, scan.angle_max) = (first_rad as f32, last_rad as f32);
            scan.angle_increment = ((last_rad - first_rad) / scan.ranges.len().saturating_sub(1).max(1) as f64) as f32;
        }
        for (part, &column) in &columns.geometry {
            let number = self.dialect.number(cells[column]);
            let number =
                number.ok_or_else(|| format!("`{:.20}` in column {} is no number", cells[column], column + 1))?;
            *match part {
                Geometry::AngleMin => &mut scan.angle_min,
                Geometry::AngleMax => &mut scan.angle_max,
                Geometry::AngleIncrement => &mut scan.angle_increment,
                Geometry::TimeIncrement => &mut scan.time_increment,
                Geometry::ScanTime => &mut scan.scan_time,
                Geometry::RangeMin => &mut scan.range_min,
                Geometry::RangeMax => &mut scan.range_max,
            } = number as f32;
        }
        if !columns.geometry.contains_key(&Geometry::AngleMax) && columns.bearings_rad.is_none() {
            scan.angle_max = scan.angle_min + scan.ranges.len().saturating_sub(1) as f32 * scan.angle_increment;
        }
        Ok((scan, time(columns.recorded)?))
    }

    /// Brings ranges to metres, and replaces what the settings state.
    fn overrule(&self, scan: &mut LaserScan) {
        let by_name = match &self.rows {
            Rows::Columns(columns) => columns.unit_m,
            Rows::Echo => None,
        };
        rescale(scan, self.settings.unit_m.or(by_name).unwrap_or(1.0));
        let CsvGeometry { first_rad, last_rad, range_max_m, .. } = self.settings;
        if self.settings.is_known() {
            let steps = scan.ranges.len().saturating_sub(1).max(1) as f64;
            (scan.angle_min, scan.angle_max) = (first_rad as f32, last_rad as f32);
            scan.angle_increment = ((last_rad - first_rad) / steps) as f32;
        }
        if range_max_m < f64::INFINITY {
            scan.range_max = range_max_m as f32;
        }
    }

    fn read_ranges(&self, columns: &Columns, cells: &[&str], ranges: &mut Vec<f32>) -> Result<(), String> {
        let mut add = |cell: &str| {
            let range = self.dialect.number(cell).ok_or_else(|| format!("`{cell:.20}` is no range"))?;
            ranges.push(range as f32);
            Ok::<_, String>(())
        };
        if let Some(list) = columns.list {
            let list = cells[list].trim_matches(|c| "[]()".contains(c));
            return list.split([',', ' ']).map(str::trim).filter(|cell| !cell.is_empty()).try_for_each(add);
        }
        let has_intensities = columns.count > columns.ranges.len() + columns.ranges[0];
        match cells.len() - columns.ranges[0] {
            left if cells.len() != columns.count => {
                if has_intensities && left % 2 == 1 {
                    return Err(format!("{left} numbers are no ranges with as many intensities"));
                }
                let beams = if has_intensities { left / 2 } else { left };
                cells[columns.ranges[0]..][..beams].iter().try_for_each(|cell| add(cell))
            }
            _ => columns.ranges.iter().try_for_each(|&column| add(cells[column])),
        }
    }

    fn time_ns(&self, time: TimeColumn, cells: &[&str]) -> Result<u64, String> {
        let wrong = |column: usize| format!("`{:.20}` is no time", cells[column]);
        let of_float =
            |column: usize| self.dialect.number(cells[column]).filter(|time| *time >= 0.0 && time.fract() == 0.0);
        let whole = |column: usize| cells[column].parse::<u64>().ok().or_else(|| Some(of_float(column)? as u64));
        match time {
            TimeColumn::One { column, unit_ns } => {
                let exact = whole(column).filter(|_| unit_ns == 1.0);
                let number = || self.dialect.number(cells[column]).filter(|time| *time >= 0.0);
                exact.or_else(|| Some((number()? * unit_ns).round() as u64)).ok_or_else(|| wrong(column))
            }
            TimeColumn::Two { seconds, nanoseconds } => {
                let [whole_s, rest_ns] = [seconds, nanoseconds].map(whole);
                let whole_ns = whole_s.and_then(|whole_s| whole_s.checked_mul(1_000_000_000));
                whole_ns.and_then(|whole_ns| whole_ns.checked_add(rest_ns?)).ok_or_else(|| wrong(seconds))
            }
        }
    }
}

impl Sample {
    fn of(file: &mut RestingFile) -> io::Result<Self> {
        let mut input = BufReader::new(&mut *file);
        let (mut lines, mut comment, mut number, mut bytes) = (Vec::<Line>::new(), None, 0, 0);
        while lines.len() <= SAMPLED_ROWS && bytes < SAMPLED_BYTES {
            let Some(line) = next_line(&mut input, &mut number)? else { break };
            bytes += line.text.len();
            match is_comment(&line.text) {
                _ if line.text.trim().is_empty() => {}
                true if lines.is_empty() => comment = Some(line.text),
                true => {}
                false => lines.push(line),
            }
        }
        file.rewind()?;
        Ok(Self::of_lines(comment, lines))
    }

    /// Names are on the first line, or in a comment before it.
    fn of_lines(comment: Option<String>, mut lines: Vec<Line>) -> Self {
        let next = lines.get(1).map(|line| line.text.as_str());
        let has_names = lines.first().is_some_and(|line| is_header(&line.text, next));
        let header = if has_names { Some(lines.remove(0).text) } else { comment };
        let first_row = lines.first().map_or(u64::MAX, |line| line.number);
        Self { header, first_row, rows: lines.into_iter().map(|line| line.text).collect() }
    }
}

/// Whether a first line has the names of columns: words where the line after it has numbers, or numbers that count up or
/// are evenly spaced, as no ranges are.
fn is_header(line: &str, next: Option<&str>) -> bool {
    let dialect = Dialect::of(line);
    let cells = dialect.cells(line);
    let is_word =
        |cell: &&str| dialect.number(cell).is_none() && cell.starts_with(|c: char| c.is_alphabetic() || c == '_');
    let has_names = match next {
        Some(next) => {
            let dialect = Dialect::of(next);
            let are_numbers = dialect.cells(next).into_iter().map(|cell| dialect.number(cell).is_some());
            cells.iter().zip(are_numbers).any(|(cell, is_number)| is_word(cell) && is_number)
        }
        None => 2 * cells.iter().filter(|cell| is_word(cell)).count() > cells.len(),
    };
    // Of a writer that gives every row a number, the first name is empty.
    let rest = if cells.first().is_some_and(|cell| cell.is_empty()) { &cells[1..] } else { &cells[..] };
    has_names || columns::count_up(rest) || columns::bearings_rad(&columns::numbers(dialect, rest)).is_some()
}

fn is_comment(line: &str) -> bool {
    line.starts_with(['#', '%'])
}

/// The names of a header, which may be a comment. `rostopic echo -p` begins it with `%time`.
fn names_in(header: &str) -> &str {
    header.trim_start_matches(['#', ' '])
}

impl LineFormat for Table {
    const NAME: &'static str = "table of ranges";
    const LAST_WORD_COUNTS: bool = true;

    fn survey(&mut self, _: &Line) {}

    fn properties(&self) -> Vec<(&'static str, String)> {
        vec![("columns", self.taken())]
    }

    fn channels(&self) -> BTreeMap<ChannelId, Topic> {
        let [name, type_name, encoding, schema_encoding] =
            [SCAN_TOPIC, LaserScan::SCHEMA_NAME, CDR_ENCODING, SCHEMA_ENCODING].map(str::to_owned);
        [(SCANS, Topic { name, type_name, encoding, schema_encoding })].into()
    }

    fn read(&self, line: &Line, out: &mut VecDeque<Message>) -> Result<(), (ChannelId, String)> {
        let is_row = line.number >= self.first_row && !line.text.trim().is_empty() && !is_comment(&line.text);
        if !is_row || self.header.as_ref() == Some(&line.text) {
            return Ok(());
        }
        let (scan, log_time_ns) = self.scan(line).map_err(|cause| (SCANS, cause))?;
        out.push_back(Message { channel: SCANS, log_time_ns, data: scan.encode(Endian::Little), damage: None });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines of a file, the last with its end.
    fn lines(text: &str) -> Vec<Line> {
        text.lines().zip(1..).map(|(text, number)| Line { number, text: text.to_owned(), is_ended: true }).collect()
    }

    fn table(text: &str) -> Result<Table, Found> {
        let settings = CsvGeometry { range_max_m: 50.0, rate_hz: 4.0, ..CsvGeometry::default() };
        let (comments, rows): (Vec<Line>, Vec<Line>) =
            lines(text).into_iter().filter(|line| !line.text.is_empty()).partition(|line| is_comment(&line.text));
        Table::of(Sample::of_lines(comments.into_iter().last().map(|line| line.text), rows), settings).expect("a line")
    }

    fn scans(text: &str) -> Vec<LaserScan> {
        let table = table(text).unwrap_or_else(|found| panic!("{found}: {text}"));
        let mut out = VecDeque::new();
        for line in lines(text) {
            table.read(&line, &mut out).expect("a row");
        }
        out.iter().map(|message| LaserScan::decode(&message.data).expect("a scan")).collect()
    }

    /// This many cells, each made of its number.
    fn cells(count: usize, separator: &str, cell: impl Fn(usize) -> String) -> String {
        (0..count).map(cell).collect::<Vec<_>>().join(separator)
    }

    fn ranges(count: usize, separator: &str) -> String {
        cells(count, separator, |i| format!("{}.5", i % 3 + 1))
    }

    const FIRST: [f32; 3] = [1.5, 2.5, 3.5];

    #[test]
    fn rows_of_bare_ranges_are_a_scan_each() {
        let read = scans("1.5,nan,inf,1,2,1,2,1\n\n2,,4,1,2,1,2,1\n");
        assert_eq!((read.len(), read[0].ranges[0], read[0].ranges[2]), (2, 1.5, f32::INFINITY));
        assert!(read[0].ranges[1].is_nan() && read[1].ranges[1].is_nan(), "an empty cell is no measurement");
        assert_eq!((read[0].range_max, read[0].header.stamp.to_ns()), (50.0, Some(250_000_000)));
    }

    #[test]
    fn a_header_tells_times_and_ranges_from_other_columns() {
        let read = scans("seq,stamp_ns,r0,r1,label\n7,1700000000000000001,1,2,3\n");
        assert_eq!(read[0].header.stamp.to_ns(), Some(1_700_000_000_000_000_001), "to the nanosecond");
        assert_eq!(read[0].ranges, [1.0, 2.0]);
        let counted = format!("{}\n{}\n", cells(9, ",", |i| i.to_string()), ranges(9, ","));
        assert_eq!(scans(&counted).len(), 1, "numbers of columns are no row");
        let unordered = "r1,r10,r2,q1,q2,q10,angle1,angle2,angle10\n1,10,2,0,0,0,0,0,0\n";
        assert_eq!(scans(unordered)[0].ranges, [1.0, 2.0, 10.0]);
    }

    #[test]
    fn every_separator_is_read_with_a_header_and_without() {
        for (separator, decimal) in
            [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), (" ", "."), (" ", ",")]
        {
            let row = ranges(9, separator).replace('.', decimal);
            let names = cells(9, separator, |i| format!("r{i}"));
            for text in
                [format!("{row}\n{row}\n"), format!("{names}\n{row}\n{row}\n"), format!("# {names}\n{row}\n{row}\n")]
            {
                let read = scans(&text);
                assert_eq!((read.len(), &read[0].ranges[..3]), (2, &FIRST[..]), "{text}");
            }
        }
    }

    #[test]
    fn columns_that_count_up_are_no_beams() {
        let rows = |first: &dyn Fn(usize) -> String| -> String {
            (0..6).map(|i| format!("{},{}\n", first(i), cells(8, ",", |j| format!("{}", (i * j) % 5 + 1)))).collect()
        };
        for (text, second_ns) in [
            (rows(&|i| i.to_string()), 500_000_000),
            (rows(&|i| format!("{}.5", 1_700_000_000 + i)), 1_700_000_001_500_000_000),
            (rows(&|i| format!("{:.1}", i as f64 * 0.2)), 200_000_000),
        ] {
            let read = scans(&text);
            assert_eq!((read[1].ranges.len(), read[1].header.stamp.to_ns()), (8, Some(second_ns)), "{text}");
        }
        let leaving = rows(&|i| format!("{}.5", i + 1));
        assert_eq!(scans(&leaving)[0].ranges.len(), 9, "a wall that is left behind is a beam");
    }

    #[test]
    fn stamps_that_repeat_or_go_back_are_no_beams() {
        const EPOCH: usize = 1_700_000_000;
        let rows = |stamp: &dyn Fn(usize) -> String| -> String {
            (0..30)
                .map(|i| {
                    format!("{},{}\n", stamp(i), cells(8, ",", |j| ["inf", "1e30", "2", "3"][(i * j) % 4].to_owned()))
                })
                .collect()
        };
        for (text, last_ns) in [
            (rows(&|i| (EPOCH + i / 10).to_string()), 1_700_000_002_000_000_000),
            (rows(&|_| EPOCH.to_string()), 1_700_000_000_000_000_000),
            (rows(&|i| format!("{}.5", EPOCH - i)), 1_699_999_971_500_000_000),
            (rows(&|i| format!("{},{}00000000", EPOCH + i / 10, i % 10)), 1_700_000_002_900_000_000),
            (rows(&|i| (i / 10).to_string()), 2_000_000_000),
            (rows(&|i| format!("{:.1}", if i < 20 { i } else { i - 20 } as f64 * 0.1)), 900_000_000),
        ] {
            let read = scans(&text);
            let last = &read[29];
            assert_eq!((last.ranges.len(), last.header.stamp.to_ns()), (8, Some(last_ns)), "{text}");
        }
        let behind = rows(&|i| format!("{}.5", i % 3 + 1)).replace('\n', &format!(",{EPOCH}\n"));
        assert_eq!(scans(&behind)[0].ranges.len(), 9, "a stamp behind the ranges");
        let sentinel = rows(&|_| "4294967295,4294967295,4294967295".to_owned());
        assert_eq!(scans(&sentinel)[0].ranges.len(), 11, "how some write that there is no return");
    }

    #[test]
    fn names_in_degrees_are_bearings() {
        let names = cells(9, ",", |i| format!("{}", i as f64 * 0.5 - 2.0));
        let read = scans(&format!("time,{names}\n5,{}\n", ranges(9, ",")));
        assert_eq!((read[0].angle_min, read[0].angle_increment, read[0].ranges.len()), (-2.0, 0.5, 9));
        let names = cells(9, ",", |i| format!("{}", i * 10));
        let read = scans(&format!("{names}\n{}\n", ranges(9, ",")));
        assert!((read[0].angle_max - 80f32.to_radians()).abs() < 1e-6);
    }

    #[test]
    fn units_in_names_are_taken() {
        let names = cells(9, ";", |i| format!("range {i} (mm)"));
        let row = cells(9, ";", |i| format!("{}500", i % 3 + 1));
        assert_eq!(scans(&format!("{names}\n{row}\n"))[0].ranges[..3], FIRST);
    }

    /// As `rostopic echo -p` writes it, with another number of ranges in the last row.
    #[test]
    fn rows_of_rostopic_state_their_stamps_and_geometry() {
        let fixed = "field.header.seq,field.header.stamp,field.header.frame_id,field.angle_min,field.angle_max,\
                     field.angle_increment,field.time_increment,field.scan_time,field.range_min,field.range_max";
        let names = format!(
            "%time,{fixed},{},{}",
            cells(9, ",", |i| format!("field.ranges{i}")),
            cells(9, ",", |i| format!("field.intensities{i}"))
        );
        let row = |count| {
            let fixed = "3500000000,7,2500000000,laser,-0.4,0.4,0.1,0.0,0.2,0.1,30.0";
            format!("{fixed},{},{}", ranges(count, ","), cells(count, ",", |_| "47.0".to_owned()))
        };
        let read = scans(&format!("{names}\n{}\n{}\n", row(9), row(11)));
        let [first, second] = &read[..] else { panic!("{read:?}") };
        assert_eq!((first.header.stamp.to_ns(), first.header.frame_id.as_str()), (Some(2_500_000_000), "laser"));
        assert_eq!((first.angle_min, first.angle_increment, first.range_max), (-0.4, 0.1, 50.0), "settings win");
        assert_eq!((first.ranges.len(), second.ranges.len(), second.ranges[10]), (9, 11, 2.5));
    }

    #[test]
    fn rows_of_ros2_topic_echo_are_messages() {
        let row = |rest: &str| format!("1700000000,5,,-0.4,0.4,0.1,0.0,0.1,0.05,30.0,{},{rest}\n", ranges(9, ","));
        let read = scans(&(row("") + &row(&cells(9, ",", |_| "47.0".to_owned()))));
        assert_eq!((read.len(), read[0].ranges.len(), read[1].ranges.len()), (2, 9, 9));
        assert_eq!((read[1].intensities.len(), read[0].header.stamp.to_ns()), (9, Some(1_700_000_000_000_000_005)));
        let shortened = format!("1700000000,5,laser,-3.14,3.14,0.0175,0.0,0.1,0.05,30.0,{},...\n", ranges(128, ","));
        assert_eq!(table(&shortened).err(), Some(Found::ShortenedEcho));
        let odometry = "1700000000,5,odom,base_link,1.0,2.0,0.0,0.0,0.0,0.0,1.0,0.1,0.0,0.0\n";
        assert_eq!(table(odometry).err(), Some(Found::OtherTable(String::new())));
    }

    #[test]
    fn a_list_in_a_cell_is_ranges() {
        let read = scans("time,angle_min,angle_max,ranges\n5,-0.1,0.1,\"(1.5, 2.5, inf)\"\n");
        assert_eq!((&read[0].ranges[..], read[0].angle_max), (&[1.5, 2.5, f32::INFINITY][..], 0.1));
    }

    #[test]
    fn tables_without_ranges_are_named() {
        for (text, found) in [
            ("angle,distance\n180.0,0\n", Found::AngleTable),
            ("scan,quality,angle,distance\n0,15,180.0,0\n", Found::AngleTable),
            ("theta;range\n0,5;1,2\n", Found::AngleTable),
            ("0.0 1.5\n0.5 1.6\n", Found::AngleTable),
            ("#COUNT=2\n#Angule\tDistance\tQuality\n0.5\t1500.0\t47\n1.5\t1501.0\t47\n", Found::AngleTable),
            ("x,y,z,intensity\n1,2,3,4\n", Found::PointTable),
            ("1.0 2.0 3.0\n1.0 2.0 3.0\n", Found::PointTable),
            ("time,speed,yaw\n1,2,3\n", Found::OtherTable("`time`, `speed`, `yaw`".to_owned())),
        ] {
            assert_eq!(table(text).err(), Some(found), "{text}");
        }
    }
}
