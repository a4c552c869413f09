//! What a range means.

use crosscut_messages::LaserScan;
use crosscut_stage::{Notes, counted};

/// Ranges this near to `range_max` (a few units in the last place of an f32) are `range_max`: a driver that works in
/// another unit does not hit the number that it states.
const ROUNDING: f64 = 1e-6;

/// No wall of a tunnel is so far away: ranges like this are of another unit.
const FAR_M: f64 = 500.0;

/// What one range says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reading {
    /// A return at this range, metres.
    Return(f64),
    /// Nothing within range.
    Nothing,
    /// Nothing is known.
    Unknown,
}

/// How many beams each rule took out.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub(super) masked: usize,
    zero: usize,
    negative: usize,
    at_wire_max: usize,
    below_wire_min: usize,
    below_min: usize,
    beyond_max: usize,
    returns: usize,
    far_returns: usize,
}

/// The limits of the sensor as the scan states them, and those of the configuration.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    wire_min_m: f64,
    /// Infinite if the scan states none.
    wire_max_m: f64,
    min_m: f64,
    max_m: f64,
}

impl Limits {
    pub(super) fn new(scan: &LaserScan, min_m: f64, max_m: f64, notes: &mut Notes) -> Self {
        let mut wire_min_m = f64::from(scan.range_min);
        if !(0.0..f64::INFINITY).contains(&wire_min_m) {
            notes.add(format!("range_min {} m is no range: taken as 0", scan.range_min));
            wire_min_m = 0.0;
        }
        let mut wire_max_m = f64::from(scan.range_max);
        let is_range = wire_max_m > 0.0;
        if !is_range {
            notes.add(format!("range_max {} m is no range: taken as no limit", scan.range_max));
            wire_max_m = f64::INFINITY;
        } else if wire_max_m <= wire_min_m {
            notes.add(format!(
                "range_max {} m is not above range_min {} m: both taken as no limit",
                scan.range_max, scan.range_min
            ));
            (wire_min_m, wire_max_m) = (0.0, f64::INFINITY);
        }
        Self { wire_min_m, wire_max_m, min_m, max_m }
    }

    /// A beam without a return saw free space up to here.
    pub(super) fn range_max_m(&self) -> f64 {
        self.wire_max_m.min(self.max_m)
    }

    pub(super) fn read(&self, range_m: f32, tally: &mut Tally) -> Reading {
        let range_m = f64::from(range_m);
        let (count, reading) = if range_m.is_nan() || range_m == f64::INFINITY {
            return Reading::Nothing;
        } else if range_m == f64::NEG_INFINITY {
            return Reading::Unknown;
        } else if range_m == 0.0 {
            (&mut tally.zero, Reading::Nothing)
        } else if range_m < 0.0 {
            (&mut tally.negative, Reading::Nothing)
        } else if range_m >= self.wire_max_m * (1.0 - ROUNDING) {
            (&mut tally.at_wire_max, Reading::Nothing)
        } else if range_m < self.wire_min_m {
            (&mut tally.below_wire_min, Reading::Unknown)
        } else if range_m < self.min_m {
            (&mut tally.below_min, Reading::Unknown)
        } else if range_m > self.max_m {
            (&mut tally.beyond_max, Reading::Nothing)
        } else {
            tally.returns += 1;
            tally.far_returns += usize::from(range_m > FAR_M);
            return Reading::Return(range_m);
        };
        *count += 1;
        reading
    }

    pub(super) fn note(&self, tally: &Tally, notes: &mut Notes) {
        // As f32 again, in which the scan states them: 5.6, not 5.599999904632568.
        let (wire_min_m, wire_max_m) = (self.wire_min_m as f32, self.wire_max_m as f32);
        let mut note = |count: usize, what: String| {
            if count > 0 {
                notes.add(format!("{} {what}", counted(count as u64, "beam")));
            }
        };
        note(tally.masked, "in masked sectors left out".to_owned());
        note(tally.zero, "of range 0 read as no return".to_owned());
        note(tally.negative, "of negative range read as no return".to_owned());
        note(tally.at_wire_max, format!("at or beyond range_max {wire_max_m} m read as no return"));
        note(tally.below_wire_min, format!("below range_min {wire_min_m} m left out"));
        note(tally.below_min, format!("nearer than min_range_m {} m left out", self.min_m));
        if 2 * tally.far_returns > tally.returns {
            note(
                tally.far_returns,
                format!("farther than {FAR_M} m: ranges are read in metres; are these millimetres?"),
            );
        }
        note(tally.beyond_max, format!("beyond max_range_m {} m read as no return", self.max_m));
    }
}
