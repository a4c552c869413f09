//! Tables of ranges, such as CSV: one scan a row. The file does not say where its beams look; settings do.

use std::collections::{BTreeMap, VecDeque};

use crosscut_messages::{CDR_ENCODING, Endian, Header, LaserScan, Message as _, SCAN_TOPIC, SCHEMA_ENCODING, Time};
use crosscut_sensor::CsvGeometry;

use super::lines::{Line, LineFormat};
use super::{ChannelId, Message, Topic};
use crate::limits;

/// The only channel.
const SCANS: ChannelId = 0;
/// Names of columns that hold a time; one may end in its unit: `stamp_ns`.
const TIME_NAMES: [&str; 5] = ["stamp", "timestamp", "time", "t", "secs"];
const NS_PER_S: f64 = 1e9;

/// A table, as far as it was surveyed.
pub(super) struct Table {
    geometry: CsvGeometry,
    layout: Option<Layout>,
}

/// What the columns hold.
struct Layout {
    separator: char,
    columns: usize,
    /// Line of the first row.
    first_row: u64,
    /// The column with the time, and its unit in nanoseconds.
    time: Option<(usize, f64)>,
    /// The columns with ranges.
    ranges: Vec<usize>,
}

impl Table {
    pub(super) fn new(geometry: CsvGeometry) -> Self {
        Self { geometry, layout: None }
    }
}

impl LineFormat for Table {
    const NAME: &'static str = "table of ranges";
    const LAST_WORD_COUNTS: bool = true;

    fn survey(&mut self, line: &Line) {
        if self.layout.is_none() && !is_blank(&line.text) {
            self.layout = Some(Layout::of(line));
        }
    }

    fn channels(&self) -> BTreeMap<ChannelId, Topic> {
        let [name, type_name, encoding, schema_encoding] =
            [SCAN_TOPIC, LaserScan::SCHEMA_NAME, CDR_ENCODING, SCHEMA_ENCODING].map(str::to_owned);
        [(SCANS, Topic { name, type_name, encoding, schema_encoding })].into()
    }

    fn read(&self, line: &Line, out: &mut VecDeque<Message>) -> Result<(), (ChannelId, String)> {
        let Some(layout) = self.layout.as_ref().filter(|layout| line.number >= layout.first_row) else { return Ok(()) };
        if is_blank(&line.text) {
            return Ok(());
        }
        let scan = self.scan(layout, line).map_err(|cause| (SCANS, cause))?;
        let log_time_ns = scan.header.stamp.to_ns().unwrap_or(0);
        out.push_back(Message { channel: SCANS, log_time_ns, data: scan.encode(Endian::Little) });
        Ok(())
    }
}

impl Table {
    fn scan(&self, layout: &Layout, line: &Line) -> Result<LaserScan, String> {
        let cells: Vec<&str> = cells_of(&line.text, layout.separator).collect();
        if cells.len() != layout.columns {
            return Err(format!("it has {} columns, the first line has {}", cells.len(), layout.columns));
        }
        let mut ranges = Vec::with_capacity(layout.ranges.len());
        for &column in &layout.ranges {
            let range_m = number_in(cells[column], layout.separator);
            ranges.push(range_m.ok_or_else(|| format!("`{:.20}` is no range", cells[column]))? as f32);
        }
        let time_ns = match layout.time {
            Some((column, unit_ns)) => {
                let time = cells[column].parse::<u64>().map(|time| time as f64).ok();
                let exact = cells[column].parse::<u64>().ok().filter(|_| unit_ns == 1.0);
                let time = time.or_else(|| number_in(cells[column], layout.separator)).filter(|time| *time >= 0.0);
                exact
                    .or(time.map(|time| (time * unit_ns).round() as u64))
                    .ok_or_else(|| format!("`{:.20}` is no time", cells[column]))?
            }
            // The first row is not at 0, which would be no stamp.
            None => ((line.number - layout.first_row + 1) as f64 * NS_PER_S / self.geometry.rate_hz).round() as u64,
        };
        let CsvGeometry { first_rad, last_rad, range_max_m, .. } = self.geometry;
        let steps = ranges.len().saturating_sub(1).max(1) as f64;
        Ok(LaserScan {
            header: Header { stamp: Time::from_ns(time_ns), frame_id: "laser".to_owned() },
            angle_min: first_rad as f32,
            angle_max: last_rad as f32,
            angle_increment: ((last_rad - first_rad) / steps) as f32,
            range_max: range_max_m as f32,
            ranges,
            ..LaserScan::default()
        })
    }
}

impl Layout {
    /// By the first line: names of columns, or the first row.
    fn of(line: &Line) -> Self {
        let separator = [';', ','].into_iter().find(|separator| line.text.contains(*separator)).unwrap_or(' ');
        let cells: Vec<&str> = cells_of(&line.text, separator).take(limits::BEAMS).collect();
        let columns = cells.len();
        let is_number = |cell: &&str| number_in(cell, separator).is_some();
        let counts_up = columns > 2 && cells.iter().enumerate().all(|(i, cell)| *cell == i.to_string());
        if cells.iter().all(is_number) && !counts_up {
            return Self { separator, columns, first_row: line.number, time: None, ranges: (0..columns).collect() };
        }
        let names: Vec<String> = cells.iter().map(|cell| cell.to_lowercase()).collect();
        let time = names.iter().enumerate().find_map(|(column, name)| Some((column, time_unit_ns(name)?)));
        // The ranges are those columns of which there are most with one name and a number.
        let stem = |name: &String| name.trim_end_matches(|c: char| !c.is_alphabetic()).to_owned();
        let mut stems: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for (column, name) in names.iter().enumerate().filter(|(column, _)| time.is_none_or(|time| time.0 != *column)) {
            stems.entry(stem(name)).or_default().push(column);
        }
        let ranges = stems.into_values().max_by_key(Vec::len).unwrap_or_default();
        Self { separator, columns, first_row: line.number + 1, time, ranges }
    }
}

/// The unit of a time in a column of this name, in nanoseconds, if it holds one.
fn time_unit_ns(name: &str) -> Option<f64> {
    let (name, unit_ns) = match name.rsplit_once('_') {
        Some((name, "ns")) => (name, 1.0),
        Some((name, "us")) => (name, 1e3),
        Some((name, "ms")) => (name, 1e6),
        Some((name, "s")) => (name, NS_PER_S),
        _ => (name, NS_PER_S),
    };
    TIME_NAMES.contains(&name).then_some(unit_ns)
}

/// The cells of a line; ' ' as the separator stands for any blanks.
fn cells_of(text: &str, separator: char) -> impl Iterator<Item = &str> {
    let is_end = move |c: char| if separator == ' ' { c.is_whitespace() } else { c == separator };
    let is_cell = move |cell: &&str| separator != ' ' || !cell.is_empty();
    text.split(is_end).filter(is_cell).map(|cell| cell.trim().trim_matches('"'))
}

/// The number in a cell; an empty cell is no measurement. Where cells are separated by semicolons numbers may have a
/// decimal comma.
fn number_in(cell: &str, separator: char) -> Option<f64> {
    if cell.is_empty() {
        return Some(f64::NAN);
    }
    if separator == ';' { cell.replace(',', ".").parse().ok() } else { cell.parse().ok() }
}

fn is_blank(text: &str) -> bool {
    text.trim().is_empty() || text.starts_with('#')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scans(text: &str) -> Vec<LaserScan> {
        let geometry = CsvGeometry { first_rad: -1.0, last_rad: 1.0, range_max_m: 5.0, rate_hz: 4.0 };
        let mut table = Table::new(geometry);
        let lines: Vec<_> = text
            .lines()
            .zip(1..)
            .map(|(text, number)| Line { number, text: text.to_owned(), is_ended: true })
            .collect();
        lines.iter().for_each(|line| table.survey(line));
        let mut out = VecDeque::new();
        for line in &lines {
            table.read(line, &mut out).expect("a row");
        }
        out.iter().map(|message| LaserScan::decode(&message.data).expect("a scan")).collect()
    }

    #[test]
    fn rows_of_bare_ranges_are_a_scan_each() {
        let read = scans("1.5,nan,inf\n\n2,,4\n");
        assert_eq!((read.len(), read[0].ranges[0], read[0].ranges[2]), (2, 1.5, f32::INFINITY));
        assert!(read[0].ranges[1].is_nan() && read[1].ranges[1].is_nan(), "an empty cell is no measurement");
        assert_eq!((read[0].angle_min, read[0].angle_increment, read[0].range_max), (-1.0, 1.0, 5.0));
        assert_eq!(read[0].header.stamp.to_ns(), Some(250_000_000));
    }

    #[test]
    fn a_header_tells_times_and_ranges_from_other_columns() {
        let read = scans("seq,stamp_ns,r0,r1,label\n7,1700000000000000001,1,2,3\n");
        assert_eq!(read[0].header.stamp.to_ns(), Some(1_700_000_000_000_000_001), "to the nanosecond");
        assert_eq!(read[0].ranges, [1.0, 2.0]);
        assert_eq!(scans("0,1,2,3\n5,6,7,8\n").len(), 1, "numbers of columns are no row");
    }

    #[test]
    fn decimal_commas_and_blanks_between_cells_are_understood() {
        assert_eq!(scans("1,5;2,5;3\n")[0].ranges, [1.5, 2.5, 3.0]);
        assert_eq!(scans(" 1.5  2.5\t 3 ").len(), 1);
        assert_eq!(scans("1.5 2.5  3\n")[0].ranges, [1.5, 2.5, 3.0]);
    }
}
