//! What the columns of a table hold, by their names and by its first rows.

use std::collections::BTreeMap;

use super::dialect::Dialect;
use super::names::{Geometry, Meaning, Name};
use crate::Found;

/// Rows with fewer cells and no names are points, or pairs of angles and distances.
const LEAST_BARE_RANGES: usize = 8;
/// Columns of which neither the name says that they are ranges have to be this many.
const LEAST_UNKNOWN_RANGES: usize = 8;
/// This many rows show that a column counts up, as no beam does.
const LEAST_COUNTING: usize = 5;
/// The steps of bearings and of counters are equal to within this share.
const EVEN: f64 = 0.05;
/// Bearings are in radians up to this, and in degrees up to that.
const LARGEST_RAD: f64 = 6.4;
const LARGEST_DEG: f64 = 361.0;

/// A column with a time, or two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TimeColumn {
    /// With its unit in nanoseconds.
    One { column: usize, unit_ns: f64 },
    /// Whole seconds, and the nanoseconds after them.
    Two { seconds: usize, nanoseconds: usize },
}

/// What the columns hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Columns {
    /// How many there are.
    pub(super) count: usize,
    /// Those with ranges, in the order of the beams.
    pub(super) ranges: Vec<usize>,
    /// The one column whose cells are lists of ranges in brackets, in place of `ranges`.
    pub(super) list: Option<usize>,
    /// Behind the ranges there are only as many columns of intensities, or none: then a row may have another number of both.
    pub(super) may_vary: bool,
    /// When a scan was taken, and when it was recorded.
    pub(super) stamp: Option<TimeColumn>,
    pub(super) recorded: Option<TimeColumn>,
    /// The column of each part of the geometry.
    pub(super) geometry: BTreeMap<Geometry, usize>,
    pub(super) frame: Option<usize>,
    /// Bearings of the first and the last range in radians, where the names of the columns are bearings.
    pub(super) bearings_rad: Option<[f64; 2]>,
    /// Metres in the unit of the ranges, where their names state it.
    pub(super) unit_m: Option<f64>,
    /// What was taken for what, in words.
    pub(super) taken: String,
}

impl Columns {
    /// Of a table whose columns have these names; `rows` are its first ones.
    ///
    /// # Errors
    /// When none of them are ranges: what the table is.
    pub(super) fn named(texts: &[&str], rows: &[Vec<f64>]) -> Result<Self, Found> {
        let names: Vec<Name> = texts.iter().map(|text| Name::of(text)).collect();
        let mut columns = Self { count: texts.len(), ..Self::default() };
        columns.find_singles(&names, rows);
        columns.find_ranges(&names, texts).ok_or_else(|| not_ranges(&names, texts))?;
        if columns.ranges.first().is_some_and(|first| names[*first].are_ranges().is_none()) {
            columns.drop_counters(rows);
        }
        if let [first, .., last] = columns.ranges[..] {
            let is_next = |pair: &[usize]| pair[1] == pair[0] + 1;
            let behind = &names[last + 1..];
            let are_intensities = behind.iter().all(|name| name.index.is_some() && name.are_ranges() == Some(false));
            let (ranges, behind) = (columns.ranges.len(), behind.len());
            columns.may_vary =
                columns.ranges.windows(2).all(is_next) && are_intensities && [0, ranges].contains(&behind);
            columns.unit_m = names[first].unit_m();
        }
        columns.say(texts);
        Ok(columns)
    }

    /// Of a table without names.
    ///
    /// # Errors
    /// When its rows are too short for scans.
    pub(super) fn bare(count: usize, rows: &[Vec<f64>]) -> Result<Self, Found> {
        if count < LEAST_BARE_RANGES {
            return Err(if count == 2 { Found::AngleTable } else { Found::PointTable });
        }
        let mut columns = Self { count, ranges: (0..count).collect(), ..Self::default() };
        // Some writers end every row by a separator.
        if rows.len() > 1 && rows.iter().all(|row| row.last().is_some_and(|cell| cell.is_nan())) {
            columns.ranges.pop();
        }
        columns.drop_counters(rows);
        columns.taken = match (columns.stamp, columns.ranges[0]) {
            (Some(_), _) => format!("the first of {count} columns is the time, the others are ranges"),
            (None, 1) => format!("the first of {count} columns counts the rows, the others are ranges"),
            _ => format!("{} columns of ranges", columns.ranges.len()),
        };
        Ok(columns)
    }

    /// A first column that counts up evenly, as the beam beside it does not, is a time or the number of the row.
    fn drop_counters(&mut self, rows: &[Vec<f64>]) {
        let &[first, second, ..] = &self.ranges[..] else { return };
        if rows.len() < LEAST_COUNTING || !counts_up(rows, first) || counts_up(rows, second) {
            return;
        }
        let start = rows[0][first];
        let step = rows[1][first] - start;
        let is_epoch = start >= 1e8;
        let is_even = rows.windows(2).all(|pair| ((pair[1][first] - pair[0][first]) / step - 1.0).abs() <= EVEN);
        let is_number = is_even && step == 1.0 && (start == 0.0 || start == 1.0);
        if is_epoch || is_number || (is_even && start == 0.0) {
            self.ranges.remove(0);
            if !is_number && self.stamp.is_none() {
                self.stamp = Some(TimeColumn::One { column: first, unit_ns: Name::default().unit_ns(start) });
            }
        }
    }

    /// The columns that stand alone: times and geometry. Those whose first cell is no number hold none.
    fn find_singles(&mut self, names: &[Name], rows: &[Vec<f64>]) {
        let first = |column: usize| rows.first().and_then(|row| row.get(column)).copied().unwrap_or(0.0);
        let has_number = |column: usize| !first(column).is_nan();
        let (mut seconds, mut nanoseconds) = (None, None);
        for (column, name) in names.iter().enumerate() {
            match name.meaning() {
                Meaning::Nanoseconds => {
                    nanoseconds.get_or_insert(column);
                }
                Meaning::Seconds => {
                    seconds.get_or_insert(column);
                }
                Meaning::Time if has_number(column) => {
                    let time = TimeColumn::One { column, unit_ns: name.unit_ns(first(column)) };
                    if name.is_stamp() { &mut self.stamp } else { &mut self.recorded }.get_or_insert(time);
                }
                Meaning::Frame => {
                    self.frame.get_or_insert(column);
                }
                Meaning::Geometry(part) if has_number(column) => {
                    self.geometry.entry(part).or_insert(column);
                }
                _ => {}
            }
        }
        match (seconds, nanoseconds) {
            (Some(seconds), Some(nanoseconds)) => self.stamp = Some(TimeColumn::Two { seconds, nanoseconds }),
            (Some(column), None) if self.recorded.is_none() => {
                self.recorded = Some(TimeColumn::One { column, unit_ns: names[column].unit_ns(first(column)) });
            }
            _ => {}
        }
        self.stamp = self.stamp.or(self.recorded);
    }

    /// The ranges are the columns of a name for ranges and a number, else those of which there are most with one name.
    /// Columns named by bearings are ranges too.
    fn find_ranges(&mut self, names: &[Name], texts: &[&str]) -> Option<()> {
        let (columns, bearings): (Vec<usize>, Vec<f64>) =
            texts.iter().enumerate().filter_map(|(column, text)| Some((column, text.parse::<f64>().ok()?))).unzip();
        self.bearings_rad = bearings_rad(&bearings);
        if self.bearings_rad.is_some() {
            self.ranges = columns;
            return Some(());
        }
        let mut groups: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (column, name) in names.iter().enumerate().filter(|(_, name)| name.index.is_some()) {
            groups.entry(&name.stem).or_default().push(column);
        }
        let are_ranges = |columns: &Vec<usize>| names[columns[0]].are_ranges();
        let is_group = |columns: &Vec<usize>| match are_ranges(columns) {
            Some(are_ranges) => are_ranges && columns.len() > 1,
            None => columns.len() >= LEAST_UNKNOWN_RANGES,
        };
        let group = groups.into_values().filter(is_group).max_by_key(|columns| (are_ranges(columns), columns.len()));
        if let Some(mut group) = group {
            group.sort_by_key(|column| names[*column].index);
            self.ranges = group;
            return Some(());
        }
        // A list in one cell, as some converters write it.
        self.list = names.iter().position(|name| name.stem == "ranges");
        self.list.map(|_| ())
    }

    fn say(&mut self, texts: &[&str]) {
        let mut used: Vec<usize> = self.geometry.values().copied().chain(self.frame).collect();
        self.taken = match (self.list, &self.ranges[..]) {
            (Some(list), _) => format!("`{}` has the ranges", texts[list]),
            (None, [first, .., last]) => {
                let count = self.ranges.len();
                format!("`{}` to `{}` are the {count} ranges", texts[*first], texts[*last])
            }
            _ => String::new(),
        };
        for (what, time) in [("stamp", self.stamp), ("time of recording", self.recorded)] {
            match time {
                Some(TimeColumn::One { column, .. }) if !used.contains(&column) => {
                    self.taken += &format!(", `{}` is the {what}", texts[column]);
                    used.push(column);
                }
                Some(TimeColumn::Two { seconds, nanoseconds }) => {
                    self.taken += &format!(", `{}` and `{}` are the {what}", texts[seconds], texts[nanoseconds]);
                    used.extend([seconds, nanoseconds]);
                }
                _ => {}
            }
        }
        if !self.geometry.is_empty() {
            self.taken +=
                &format!(", {} state the geometry", listed(self.geometry.values().map(|column| texts[*column])));
        }
        let is_used =
            |column: &usize| used.contains(column) || self.ranges.contains(column) || self.list == Some(*column);
        let rest: Vec<&str> = (0..texts.len())
            .filter(|column| !is_used(column) && !texts[*column].is_empty())
            .map(|column| texts[column])
            .collect();
        if !rest.is_empty() {
            self.taken += &format!("; not used: {}", listed(rest.into_iter()));
        }
    }
}

/// Bearings of the first and the last beam in radians, if these are the bearings of beams: evenly spaced numbers that are no
/// count.
pub(super) fn bearings_rad(bearings: &[f64]) -> Option<[f64; 2]> {
    let (&[first, .., last], true) = (bearings, bearings.len() >= LEAST_BARE_RANGES) else { return None };
    let (span, step) = ((last - first).abs(), (last - first) / (bearings.len() - 1) as f64);
    let is_even = bearings.windows(2).all(|pair| ((pair[1] - pair[0]) / step - 1.0).abs() <= EVEN);
    let is_count = first.fract() == 0.0 && first >= 0.0 && step == 1.0;
    let to_rad = if span <= LARGEST_RAD && first.abs() <= LARGEST_RAD { 1.0 } else { 1f64.to_radians() };
    let is_turn = step != 0.0 && first.abs() <= LARGEST_DEG && span <= LARGEST_DEG;
    (is_even && is_turn && !is_count).then_some([first * to_rad, last * to_rad])
}

/// Whether cells count up, from 0 or 1.
pub(super) fn count_up(cells: &[&str]) -> bool {
    let counts_from = |start: usize| cells.iter().zip(start..).all(|(cell, number)| *cell == number.to_string());
    cells.len() >= LEAST_BARE_RANGES && (counts_from(0) || counts_from(1))
}

/// Whether the numbers of a column grow from row to row.
fn counts_up(rows: &[Vec<f64>], column: usize) -> bool {
    let cell = |row: &Vec<f64>| row.get(column).copied().unwrap_or(f64::NAN);
    rows.windows(2).all(|pair| cell(&pair[1]) > cell(&pair[0]))
}

/// What a table without ranges is.
fn not_ranges(names: &[Name], texts: &[&str]) -> Found {
    let meanings: Vec<Meaning> = names.iter().map(Name::meaning).collect();
    let has = |meaning: Meaning| meanings.contains(&meaning);
    if has(Meaning::Angle) && has(Meaning::Range) {
        Found::AngleTable
    } else if meanings.iter().filter(|meaning| **meaning == Meaning::Coordinate).count() > 1 && !has(Meaning::Frame) {
        Found::PointTable
    } else {
        Found::OtherTable(listed(texts.iter().copied()))
    }
}

/// The first of these names.
fn listed<'a>(names: impl Iterator<Item = &'a str> + Clone) -> String {
    const LISTED: usize = 6;
    let first: Vec<_> = names.clone().take(LISTED).map(|name| format!("`{name:.30}`")).collect();
    let more = names.count().saturating_sub(LISTED);
    first.join(", ") + &if more > 0 { format!(" and {more} more") } else { String::new() }
}

/// The numbers of a row; NaN for other cells.
pub(super) fn numbers(dialect: Dialect, cells: &[&str]) -> Vec<f64> {
    cells.iter().map(|cell| dialect.number(cell).unwrap_or(f64::NAN)).collect()
}
