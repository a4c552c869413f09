//! Tables of ranges, such as CSV: one scan a row. What its columns hold is found by their names and by the first rows; where
//! the table does not say where its beams look, settings do.

mod columns;
mod dialect;
mod echo;
mod names;
mod sample;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;

use crosscut_messages::{CDR_ENCODING, Endian, Header, LaserScan, Message as _, SCAN_TOPIC, SCHEMA_ENCODING, Time};
use crosscut_sensor::{CsvGeometry, rescale};

use self::columns::{Columns, TimeColumn};
pub(crate) use self::dialect::Dialect;
use self::names::{Geometry, NS_PER_S};
use self::sample::{Sample, is_comment};
use super::lines::{Line, LineFormat};
use super::resting_file::RestingFile;
use super::{ChannelId, Message, Topic};
use crate::{Found, IngestError};

/// The only channel.
const SCANS: ChannelId = 0;

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
