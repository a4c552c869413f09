//! Lists: a return a row, by an angle and a distance, or by x and y. Rows are joined to turns: a new one begins where
//! the angle jumps back, or where the column that numbers the turns changes. The angles of a turn need not be even, nor
//! those of another turn: its beams are as far apart as rows usually are, and each sees the distance of the row nearest
//! to its middle.

use std::f64::consts::{PI, TAU};

use crosscut_messages::{Cloud, LaserScan};

use crate::order::{at_share, usual};

/// Units of ranges and places in names, metres.
pub(super) const UNITS_M: [(&str, f64); 6] =
    [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("in", 0.0254), ("inches", 0.0254), ("ft", 0.3048)];
/// Fewer rows do not show what they hold, and are no turn.
const LEAST_ROWS: usize = 8;
/// Angles are in radians up to this, in degrees up to that, and else in hundredths of a degree.
pub(super) const LARGEST_RAD: f64 = 6.4;
const LARGEST_DEG: f64 = 400.0;
/// A number that is this many times as large as nine of ten angles is none.
const FAR_OFF: f64 = 3.0;
/// Distances of which half are larger than this are millimetres.
const LARGEST_M: f64 = 100.0;
/// A view that falls short of a turn by less than this, beside two steps, is one.
const SHORT_RAD: f64 = 5.0 * PI / 180.0;
/// A list whose first angle is this share of a turn from where angles jump back begins within a turn.
const BEGINS_WITHIN: f64 = 0.1;
/// Turns with fewer rows than this share of the usual ones are the beginning and the end of a list.
const LEAST_SHARE: f64 = 0.25;
/// A turn with fewer beams than this share of all was not listed as a whole.
const WHOLE_SHARE: f64 = 0.9;
/// At least this share of the steps of an angle go one way, and are about even.
const ONE_WAY_SHARE: f64 = 0.8;
const EVEN_SHARE: f64 = 0.6;
/// This many rows are kept for one turn.
const MOST_ROWS: usize = crosscut_messages::MOST_BEAMS;

/// The columns of a list.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Columns {
    /// The angle and the distance, or x and y.
    pub(super) first: usize,
    pub(super) second: usize,
    /// z.
    pub(super) third: Option<usize>,
    pub(super) are_points: bool,
    /// The number of the turn.
    pub(super) turn: Option<usize>,
    /// Radians in the unit of the angle and metres in that of the distance, where they are stated.
    pub(super) unit_rad: Option<f64>,
    pub(super) unit_m: Option<f64>,
}

/// How rows become turns, and the rows of the turn that is not complete.
#[derive(Default)]
pub(super) struct List {
    pub(super) columns: Columns,
    unit_rad: f64,
    unit_m: f64,
    /// What is larger is no angle.
    most: f64,
    /// 1 where angles rise from row to row, -1 where they fall.
    direction: f64,
    /// Where turns begin, if it is not where angles jump back by themselves, rad.
    seam_rad: Option<f64>,
    /// The sensor swings: a turn begins where the angle turns back.
    swings: bool,
    /// An angle that goes back by more than this begins a turn, rad; `None` if it does not.
    jump_rad: Option<f64>,
    /// Where the first beam looks, and from beam to beam, in the direction of the list.
    first_rad: f64,
    step_rad: f64,
    beams: usize,
    /// Rows of a usual turn.
    usual: usize,
    rows: Vec<Row>,
    /// How many turns were given, how many were left out as too short, and the least and largest number of rows.
    pub(super) turns: u64,
    short: u64,
    sizes: [usize; 2],
}

/// A row, with its times of stamp and recording.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Row {
    /// Angle and distance, or x, y and z.
    values: [f64; 3],
    turn: f64,
    angle_rad: f64,
    /// 1 where the angle rises towards this row, -1 where it falls, 0 of the first.
    way: f64,
    pub(super) times_ns: [Option<u64>; 2],
    /// Where the vehicle is by this row.
    pub(super) pose: Option<[f64; 3]>,
}

impl Row {
    fn way_after(&self, before: &Self) -> f64 {
        let step_rad = self.angle_rad - before.angle_rad;
        if step_rad == 0.0 { before.way } else { step_rad.signum() }
    }
}

/// A turn of a list, without its stamp.
pub(super) enum Seen {
    Scan(LaserScan),
    Cloud(Cloud),
}

impl List {
    /// Of a list with these columns, of which `rows` are the first; `None` if they are too few.
    pub(super) fn of(mut columns: Columns, rows: &[Vec<f64>]) -> Option<Self> {
        columns.turn = columns.turn.filter(|turn| {
            let changes = rows.windows(2).filter(|pair| pair[0].get(*turn) != pair[1].get(*turn)).count();
            rows.len() > LEAST_ROWS * changes
        });
        let row_of = |row: &Vec<f64>| Self::row(&columns, |column| row.get(column).copied().unwrap_or(f64::NAN));
        let mut rows: Vec<Row> = rows.iter().map(row_of).filter(|row| row.values[0].is_finite()).collect();
        if rows.len() < LEAST_ROWS {
            return None;
        }
        let nine_of_ten = at_share(rows.iter().map(|row| row.values[0].abs()), 0.9)?;
        let most = if columns.are_points { f64::INFINITY } else { FAR_OFF * nine_of_ten };
        rows.retain(|row| row.values[0].abs() <= most);
        let largest = rows.iter().fold(0.0, |largest: f64, row| largest.max(row.values[0].abs()));
        let falls = |pair: &[Row]| (pair[0].values[0] - pair[1].values[0]).abs() > 0.5 * largest;
        // Degrees count on beyond a turn, hundredths of a degree do not.
        let counts_on = !rows.windows(2).any(falls);
        let are_degrees = largest <= LARGEST_DEG || counts_on;
        let by_size = if largest <= LARGEST_RAD { 1.0 } else { PI / if are_degrees { 180.0 } else { 18000.0 } };
        let mut list =
            Self { columns, unit_rad: columns.unit_rad.unwrap_or(by_size), direction: 1.0, ..Self::default() };
        list.most = if counts_on { f64::INFINITY } else { most };
        let middle = usual(rows.iter().map(|row| list.distance(row)).filter(|range| *range > 0.0)).unwrap_or(0.0);
        list.unit_m = columns.unit_m.unwrap_or(if middle >= LARGEST_M { 1e-3 } else { 1.0 });
        list.find_turns(&mut rows)?;
        Some(list)
    }

    fn row(columns: &Columns, value: impl Fn(usize) -> f64) -> Row {
        let values = [value(columns.first), value(columns.second), columns.third.map_or(0.0, &value)];
        Row { values, turn: columns.turn.map_or(0.0, value), ..Row::default() }
    }

    fn distance(&self, row: &Row) -> f64 {
        if self.columns.are_points { row.values[0].hypot(row.values[1]) } else { row.values[1] }
    }

    /// The angle of a row; of a point at the sensor itself there is none.
    fn angle_rad(&self, row: &Row) -> Option<f64> {
        let [a, b, _] = row.values;
        let angle_rad = if self.columns.are_points { b.atan2(a) } else { a * self.unit_rad };
        let has_angle = angle_rad.is_finite() && (!self.columns.are_points || a != 0.0 || b != 0.0);
        let from =
            |seam_rad: f64| seam_rad + self.direction * (self.direction * (angle_rad - seam_rad)).rem_euclid(TAU);
        has_angle.then(|| self.seam_rad.map_or(angle_rad, from))
    }

    /// Finds out how rows become turns, and turns beams; `None` if there are too few rows with an angle.
    fn find_turns(&mut self, rows: &mut Vec<Row>) -> Option<()> {
        let [mut least_rad, mut span_rad] = self.take_angles(rows);
        if rows.len() < LEAST_ROWS {
            return None;
        }
        let steps =
            |rows: &[Row]| rows.windows(2).map(|pair| pair[1].angle_rad - pair[0].angle_rad).collect::<Vec<_>>();
        let small = steps(rows).into_iter().filter(|step| step.abs() <= 0.5 * span_rad && *step != 0.0);
        let (up, small) = (small.clone().filter(|step| *step > 0.0).count(), small.count());
        if 2 * up < small {
            self.direction = -1.0;
            [least_rad, span_rad] = self.take_angles(rows);
        }
        let first_rad = rows[0].angle_rad;
        let from_end = (self.direction * first_rad - least_rad) / TAU;
        let begins_within = span_rad > TAU - SHORT_RAD && (BEGINS_WITHIN..1.0 - BEGINS_WITHIN).contains(&from_end);
        // A list that begins within a turn goes on from there.
        if span_rad > TAU + SHORT_RAD || begins_within {
            self.seam_rad = Some(first_rad);
            [least_rad, span_rad] = self.take_angles(rows);
        }
        let jumps = steps(rows).into_iter().filter(|step| step * self.direction < -0.5 * span_rad).count();
        let goes_one_way = up.max(small - up) as f64 >= ONE_WAY_SHARE * small as f64;
        let has_jumps = self.columns.turn.is_none() && goes_one_way && rows.len() > LEAST_ROWS * jumps;
        self.jump_rad = has_jumps.then_some(0.5 * span_rad);
        (1..rows.len()).for_each(|at| rows[at].way = rows[at].way_after(&rows[at - 1]));
        let reversals = rows.windows(2).filter(|pair| pair[0].way * pair[1].way < 0.0).count();
        let is_free = self.columns.turn.is_none() && !self.columns.are_points && !goes_one_way;
        self.swings = is_free && rows.len() > LEAST_ROWS * reversals;
        let (mut gaps, mut sizes) = (Vec::new(), Vec::new());
        for turn in rows.chunk_by(|before, row| !self.begins(before, row)) {
            let mut angles: Vec<f64> = turn.iter().map(|row| row.angle_rad).collect();
            angles.sort_by(f64::total_cmp);
            gaps.extend(angles.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > 1e-9));
            sizes.push(turn.len() as f64);
        }
        self.usual = usual(sizes)? as usize;
        let step_rad = usual(gaps).unwrap_or(TAU).max(TAU / MOST_ROWS as f64);
        let is_full = span_rad + 2.0 * step_rad + SHORT_RAD >= TAU;
        let all_rad = if is_full { TAU } else { span_rad };
        let steps = (all_rad / step_rad).round().max(1.0);
        (self.beams, self.step_rad) = (steps as usize + usize::from(!is_full), all_rad / steps);
        self.first_rad = self.direction * least_rad;
        Some(())
    }

    /// Computes the angles of the rows, and gives the least in the direction of the list, and their span.
    fn take_angles(&self, rows: &mut Vec<Row>) -> [f64; 2] {
        rows.retain_mut(|row| self.angle_rad(row).map(|angle_rad| row.angle_rad = angle_rad).is_some());
        let travels = rows.iter().map(|row| self.direction * row.angle_rad);
        let least_rad = travels.clone().fold(f64::INFINITY, f64::min);
        [least_rad, travels.fold(f64::NEG_INFINITY, f64::max) - least_rad]
    }

    fn begins(&self, before: &Row, row: &Row) -> bool {
        let goes_back_rad = self.direction * (before.angle_rad - row.angle_rad);
        let turns_back = self.swings && before.way * row.way < 0.0;
        before.turn != row.turn || turns_back || self.jump_rad.is_some_and(|jump_rad| goes_back_rad > jump_rad)
    }

    /// Whether a number may be an angle, or a coordinate, of this list.
    pub(super) fn may_be(&self, first: f64) -> bool {
        first.abs() <= self.most
    }

    /// Takes a row; gives the turn before it, with its first row and the time that it took, if this one begins another.
    pub(super) fn take(
        &mut self,
        value: impl Fn(usize) -> f64,
        times_ns: [Option<u64>; 2],
        pose: Option<[f64; 3]>,
    ) -> Option<(Seen, Row)> {
        let mut row = Row { times_ns, pose, ..Self::row(&self.columns, value) };
        let last_rad = self.rows.last().map_or(0.0, |last| last.angle_rad);
        row.angle_rad = self.angle_rad(&row).unwrap_or(last_rad);
        row.way = self.rows.last().map_or(0.0, |last| row.way_after(last));
        let is_next = self.rows.last().is_some_and(|last| self.begins(last, &row)) || self.rows.len() >= MOST_ROWS;
        let turn = if is_next { self.turn() } else { None };
        self.rows.push(row);
        turn
    }

    /// The next row is the first.
    pub(super) fn restart(&mut self) {
        self.rows.clear();
        (self.turns, self.short, self.sizes) = (0, 0, [0; 2]);
    }

    /// The turn of the rows that were taken; `None` if it is one that is left out.
    pub(super) fn turn(&mut self) -> Option<(Seen, Row)> {
        let rows = std::mem::take(&mut self.rows);
        let first = *rows.first()?;
        if (rows.len() as f64) < LEAST_SHARE * self.usual as f64 {
            self.short += 1;
            return None;
        }
        let [least, most] = if self.turns == 0 { [rows.len(); 2] } else { self.sizes };
        self.sizes = [least.min(rows.len()), most.max(rows.len())];
        self.turns += 1;
        if !self.columns.are_points {
            return Some((Seen::Scan(self.scan(&rows)), first));
        }
        let points_m = rows.iter().map(|row| row.values.map(|value| value * self.unit_m)).collect();
        Some((Seen::Cloud(Cloud { points_m, ..Cloud::default() }), first))
    }

    fn scan(&self, rows: &[Row]) -> LaserScan {
        // How far the nearest row of a beam is, in steps, and its distance.
        let mut nearest = vec![(f64::INFINITY, f32::NAN); self.beams];
        let (mut least, mut most) = (self.beams, 0);
        for row in rows {
            let place = (self.direction * (row.angle_rad - self.first_rad)).rem_euclid(TAU) / self.step_rad;
            // An angle may be rounded to before the first beam.
            let (at, off) =
                (place.round() as usize % (TAU / self.step_rad).round() as usize, (place - place.round()).abs());
            if at >= self.beams {
                continue;
            }
            if off < nearest[at].0 {
                nearest[at] = (off, (self.distance(row) * self.unit_m) as f32);
            }
            (least, most) = (least.min(at), most.max(at));
        }
        let is_whole = (most + 1).saturating_sub(least) as f64 >= WHOLE_SHARE * self.beams as f64;
        let (least, most) = if is_whole || least > most { (0, self.beams - 1) } else { (least, most) };
        let bearing_rad = |beam: usize| (self.first_rad + self.direction * beam as f64 * self.step_rad) as f32;
        let [first_ns, last_ns] = [rows.first(), rows.last()].map(|row| row.and_then(|row| row.times_ns[0]));
        let took_ns = last_ns.zip(first_ns).map_or(0, |(last, first)| last.saturating_sub(first));
        LaserScan {
            angle_min: bearing_rad(least),
            angle_max: bearing_rad(most),
            angle_increment: (self.direction * self.step_rad) as f32,
            time_increment: (took_ns as f64 * 1e-9 / (most - least).max(1) as f64) as f32,
            range_max: f32::INFINITY,
            ranges: nearest[least..=most].iter().map(|(_, range_m)| *range_m).collect(),
            ..LaserScan::default()
        }
    }

    /// How the rows are taken, in words.
    pub(super) fn described(&self) -> String {
        let name = |units: &[(&'static str, f64)], unit: f64| {
            units.iter().find(|(_, of)| (unit / of - 1.0).abs() < 1e-9).map_or("units", |(name, _)| *name)
        };
        let metres = name(&UNITS_M, self.unit_m);
        if self.columns.are_points {
            return format!("in {metres}");
        }
        let angles = [("rad", 1.0), ("degrees", PI / 180.0), ("hundredths of a degree", PI / 18000.0)];
        let angle = name(&angles, self.unit_rad);
        let way = if self.direction > 0.0 { "rising" } else { "falling" };
        format!("in {angle}, {way}, anticlockwise from ahead, and in {metres}; {} beams a turn", self.beams)
    }

    /// How many turns were found.
    pub(super) fn found(&self) -> String {
        let ([least, most], left) = (self.sizes, self.short);
        format!("{} of {least} to {most} rows; {left} of less than a quarter of that left out", self.turns)
    }

    /// Names for the columns of a list without any, by its first rows: where an angle and a distance are, or x and y.
    pub(super) fn guess(rows: &[Vec<f64>], is_time: impl Fn(usize) -> bool) -> Option<Vec<&'static str>> {
        let columns = rows.first()?.len();
        let of = |column: usize| rows.iter().filter_map(move |row| row.get(column).copied()).filter(|v| v.is_finite());
        let share = |column: usize, holds: &dyn Fn(f64) -> bool| {
            of(column).filter(|value| holds(*value)).count() as f64 / rows.len() as f64
        };
        let free = |column: &usize| *column < columns && !is_time(*column);
        let mut names: Vec<_> = (0..columns).map(|column| if is_time(column) { "time" } else { "other" }).collect();
        let angles = (0..columns).filter(free).filter_map(|c| Some((c, is_angle(&of(c).collect::<Vec<_>>())?)));
        let angle = angles.max_by_key(|(column, has_turns)| (*has_turns, columns - column)).map(|(column, _)| column);
        let is_distance = |column: &usize| free(column) && share(*column, &|value| value >= 0.0) > ONE_WAY_SHARE;
        let distance = angle.and_then(|angle| [angle + 1, angle.wrapping_sub(1)].into_iter().find(is_distance));
        if let Some((angle, distance)) = angle.zip(distance) {
            (names[angle], names[distance]) = ("angle", "distance");
            return Some(names);
        }
        let both = |column: usize| [1.0, -1.0].iter().all(|sign| share(column, &|value| value * sign > 0.0) > 0.1);
        let x = (1..columns).find(|y| free(y) && free(&(y - 1)))? - 1;
        let has_z = x + 2 < columns && share(x + 2, &|value| value < 0.0) > 0.0;
        (names[x], names[x + 1]) = ("x", "y");
        if has_z {
            names[x + 2] = "z";
        }
        (both(x) && both(x + 1) && rows.len() >= LEAST_ROWS).then_some(names)
    }
}

/// Whether numbers are the angles of a lidar that turns: they go one way in about even steps; and whether they jump
/// back.
fn is_angle(angles: &[f64]) -> Option<bool> {
    let [least, most] = angles.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(*v), b.max(*v)]);
    let (span, largest) = (most - least, most.abs().max(least.abs()));
    let steps = angles.windows(2).map(|pair| pair[1] - pair[0]);
    let small: Vec<f64> = steps.filter(|step| step.abs() <= 0.5 * span && *step != 0.0).collect();
    let up = small.iter().filter(|step| **step > 0.0).count();
    let middle = usual(small.iter().map(|step| step.abs()))?;
    let even = small.iter().filter(|step| (middle / 3.0..=middle * 3.0).contains(&step.abs())).count();
    let others = angles.len() - 1 - small.len();
    let is_wide = largest <= LARGEST_DEG && span >= if largest <= LARGEST_RAD { 1.0 } else { 60.0 };
    let is_share = |count: usize, share: f64| count as f64 >= share * small.len() as f64;
    let goes_round = is_share(up.max(small.len() - up), ONE_WAY_SHARE) && is_share(even, EVEN_SHARE);
    (is_wide && goes_round && small.len() >= LEAST_ROWS * others.max(1)).then_some(others > 0)
}
