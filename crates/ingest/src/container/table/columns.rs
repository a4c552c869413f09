//! What the columns of a table hold, by their names and by its first rows.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use super::dialect::Dialect;
use super::names::{Geometry, Meaning, NS_PER_S, Name};
use crate::Found;

/// Rows with fewer cells and no names are points, or pairs of angles and distances.
const LEAST_BARE_RANGES: usize = 8;
/// Columns of which neither the name says that they are ranges have to be this many.
const LEAST_UNKNOWN_RANGES: usize = 8;
/// This many rows show that a column counts up, as no beam does.
const LEAST_COUNTING: usize = 5;
/// Numbers of a time since 1970, in seconds (from 2001 on) to nanoseconds. No range is as large in any unit.
const EPOCHS: RangeInclusive<f64> = 1e9..=4e18;
/// A table has at most this many columns of such times: others are a way to write that there is no return.
const MOST_TIMES: usize = 2;
/// Numbers between whole seconds that reach this are nanoseconds after them: as ranges they were kilometres in every unit.
const LEAST_NANOSECONDS: f64 = 1e7;
/// The steps of bearings and of counters are equal to within this share.
const EVEN: f64 = 0.05;
/// All but this share of the steps of a time are even: where files were joined, it begins again.
const UNEVEN_SHARE: f64 = 0.1;
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
        let numbers_rows = columns.drop_counters(rows);
        columns.taken = match columns.stamp {
            Some(TimeColumn::One { column, .. }) => {
                format!("column {} of {count} is the time, the others are ranges", column + 1)
            }
            Some(TimeColumn::Two { seconds, nanoseconds }) => format!(
                "columns {} and {} of {count} are the seconds and nanoseconds of the time, the others are ranges",
                seconds + 1,
                nanoseconds + 1
            ),
            None if numbers_rows => format!("column 1 of {count} counts the rows, the others are ranges"),
            None => format!("{} columns of ranges", columns.ranges.len()),
        };
        Ok(columns)
    }

    /// Takes the columns that are no beams from the ranges: times, and the number of the row, of which there was one if this is
    /// true.
    fn drop_counters(&mut self, rows: &[Vec<f64>]) -> bool {
        self.drop_epochs(rows);
        let &[first, second, ..] = &self.ranges[..] else { return false };
        if rows.len() < LEAST_COUNTING || counts_up(rows, second) {
            return false;
        }
        let steps: Vec<f64> =
            numbers_of(rows, first).zip(numbers_of(rows, first).skip(1)).map(|(a, b)| b - a).collect();
        let start = rows[0][first];
        let is_number = [0.0, 1.0].contains(&start) && steps.iter().all(|step| *step == 1.0);
        // Since the start of the flight, in fractions of seconds or in whole ones.
        let is_time = start == 0.0 && (is_even(&steps) || is_of_whole_steps(&steps));
        if is_number || is_time {
            self.ranges.remove(0);
        }
        if is_time && !is_number && self.stamp.is_none() {
            self.stamp = Some(TimeColumn::One { column: first, unit_ns: Name::default().unit_ns(start) });
        }
        is_number
    }

    /// A column of times since 1970 is no beam, in whatever order they are.
    fn drop_epochs(&mut self, rows: &[Vec<f64>]) {
        let has_epoch = |column: &&usize| numbers_of(rows, **column).any(|number| EPOCHS.contains(&number));
        let times: Vec<usize> = self.ranges.iter().filter(has_epoch).copied().collect();
        let is_epoch = |column: &usize| {
            let mut numbers = numbers_of(rows, *column).filter(|number| !number.is_nan());
            numbers.all(|number| EPOCHS.contains(&number))
        };
        if times.is_empty() || times.len() > MOST_TIMES || !times.iter().all(is_epoch) {
            return;
        }
        let column = times[0];
        let nanoseconds = self.ranges.iter().copied().find(|next| *next == column + 1 && are_nanoseconds(rows, *next));
        self.ranges.retain(|beam| !times.contains(beam));
        let first = numbers_of(rows, column).find(|number| !number.is_nan()).unwrap_or(0.0);
        let unit_ns = Name::default().unit_ns(first);
        let is_whole = unit_ns == NS_PER_S && numbers_of(rows, column).all(|number| number.fract() == 0.0);
        let time = match nanoseconds.filter(|_| is_whole) {
            Some(nanoseconds) => {
                self.ranges.retain(|beam| *beam != nanoseconds);
                TimeColumn::Two { seconds: column, nanoseconds }
            }
            None => TimeColumn::One { column, unit_ns },
        };
        self.stamp.get_or_insert(time);
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

/// The numbers of a column, NaN where there is none.
fn numbers_of(rows: &[Vec<f64>], column: usize) -> impl Iterator<Item = f64> {
    rows.iter().map(move |row| row.get(column).copied().unwrap_or(f64::NAN))
}

/// Whether the numbers of a column grow from row to row.
fn counts_up(rows: &[Vec<f64>], column: usize) -> bool {
    numbers_of(rows, column).is_sorted_by(|a, b| a < b)
}

/// Whether nearly all steps are equal and upwards.
fn is_even(steps: &[f64]) -> bool {
    let mut sorted = steps.to_vec();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[sorted.len() / 2];
    let uneven = steps.iter().filter(|step| (*step / usual - 1.0).abs().partial_cmp(&EVEN) != Some(Ordering::Less));
    usual > 0.0 && uneven.count() as f64 <= UNEVEN_SHARE * steps.len() as f64
}

/// Whether steps are those of whole seconds, which several scans share.
fn is_of_whole_steps(steps: &[f64]) -> bool {
    steps.contains(&1.0) && steps.iter().all(|step| [0.0, 1.0].contains(step))
}

/// Whether a column may hold the nanoseconds after whole seconds.
fn are_nanoseconds(rows: &[Vec<f64>], column: usize) -> bool {
    numbers_of(rows, column).all(|number| number.fract() == 0.0 && (0.0..NS_PER_S).contains(&number))
        && numbers_of(rows, column).any(|number| number >= LEAST_NANOSECONDS)
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
