//! What a range means.

use std::collections::BTreeSet;

use crosscut_messages::LaserScan;
use crosscut_stage::NoteCode::{N001, N002, N003, N004, N005, N006, N007, N008, N009, N010, N011, N012, N013, N029};
use crosscut_stage::{Notes, counted};

/// Ranges this near to `range_max` (a few units in the last place of an f32) are `range_max`: a driver that works in
/// another unit does not hit the number that it states.
const ROUNDING: f64 = 1e-6;

/// So many beams hardly ever tell the very same range, the largest of the scan, but where nothing comes back: a driver's
/// word for that, with a `range_max` that is larger still. Two of them are neighbours, or they are more than one place can
/// have that looks the same all around...
const CODE_BEAMS: usize = 3;
const CODE_BEAMS_APART: usize = 5;
/// ...unless ranges are so coarse that more than this share of all neighbours elsewhere are equal, or hardly any beam says
/// anything else.
const COARSE_SHARE: f64 = 0.05;
const ELSEWHERE_SHARE: f64 = 0.1;

/// A limit below this share of the ranges, by more than the second share, is none, if they are no codes: so many
/// different ones.
const BELOW_SHARE: f64 = 0.95;
const BELOW_BY: f64 = 1.05;
const LEAST_DIFFERENT: usize = 10;

/// Filters write the limit and this many metres more into the beams that they mask.
const MASKED_BEYOND_M: f32 = 1.0;

/// Ranges within this share of `range_max` may be noise about it: simulators that add noise to every range cut off what is
/// beyond the maximum, so half of the beams without a hit are at it and half below.
const NOISE_SHARE: f64 = 0.005;
/// They are noise if at least this share of them has a neighbour at `range_max`: a wall that leaves the range has one beam
/// beside the dark at either end, beams of noise mostly have one.
const BESIDE_MAX_SHARE: f64 = 0.5;
/// There are at least this many of them, and as many at `range_max`.
const NOISY_BEAMS: usize = 8;
/// As many are below `range_max` as at it: half of those lie within this many standard deviations (a half normal
/// distribution), all but a few within that many. Noise of more than this share of `range_max` is none.
const MEDIAN_SIGMAS: f64 = 0.6745;
const ALL_SIGMAS: f64 = 4.0;
const MOST_NOISE_SHARE: f64 = 0.06;

/// No wall of a tunnel is so far away: ranges like this are of another unit.
const FAR_M: f64 = 500.0;

/// What one range says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reading {
    /// A return at this range, metres.
    Return(f64),
    /// Nothing within range.
    Nothing,
    /// Nothing is known.
    Unknown,
}

/// How many beams each rule took out.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    pub(crate) masked: usize,
    filtered: usize,
    zero: usize,
    negative: usize,
    too_near: usize,
    at_wire_max: usize,
    code: usize,
    noisy: usize,
    below_wire_min: usize,
    below_min: usize,
    beyond_max: usize,
    returns: usize,
    far_returns: usize,
}

/// The limits of the sensor as the scan states them, and those of the configuration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RangeLimits {
    wire_min_m: f64,
    /// Infinite if the scan states none.
    wire_max_m: f64,
    /// The range by which a filter says that nothing is known.
    masked_m: Option<f64>,
    /// The range by which the scan says that nothing came back, if there is one.
    code_m: Option<f32>,
    /// Ranges beyond this are noise about `range_max`, by which the scan says that nothing came back; infinite if there is
    /// none.
    noise_from_m: f64,
    min_m: f64,
    max_m: f64,
}

impl RangeLimits {
    pub(crate) fn new(scan: &LaserScan, min_m: f64, max_m: f64, notes: &mut Notes) -> Self {
        let mut wire_min_m = f64::from(scan.range_min);
        if !(0.0..f64::INFINITY).contains(&wire_min_m) {
            notes.add(N011, format!("range_min {} m is no range: taken as 0", scan.range_min));
            wire_min_m = 0.0;
        }
        let mut wire_max_m = f64::from(scan.range_max);
        let is_range = wire_max_m > 0.0;
        if !is_range {
            notes.add(N012, format!("range_max {} m is no range: taken as no limit", scan.range_max));
            wire_max_m = f64::INFINITY;
        } else if wire_max_m <= wire_min_m {
            notes.add(
                N013,
                format!(
                    "range_max {} m is not above range_min {} m: both taken as no limit",
                    scan.range_max, scan.range_min
                ),
            );
            (wire_min_m, wire_max_m) = (0.0, f64::INFINITY);
        } else if is_below_ranges(&scan.ranges, wire_max_m) {
            notes.add(N012, format!("range_max {} m is below nearly all ranges: taken as no limit", scan.range_max));
            wire_max_m = f64::INFINITY;
        }
        let code_m = code_m(&scan.ranges, (wire_max_m * (1.0 - ROUNDING)) as f32);
        let noise_from_m = noise_from_m(&scan.ranges, wire_max_m).unwrap_or(f64::INFINITY);
        let masked_m = masked_m(&scan.ranges, wire_max_m as f32);
        Self { wire_min_m, wire_max_m, masked_m, code_m, noise_from_m, min_m, max_m }
    }

    /// A beam without a return saw free space up to here.
    pub(crate) fn range_max_m(&self) -> f64 {
        self.wire_max_m.min(self.max_m)
    }

    pub(crate) fn read(&self, range_m: f32, tally: &mut Tally) -> Reading {
        let range_m = f64::from(range_m);
        let (count, reading) = if range_m.is_nan() || range_m == f64::INFINITY {
            return Reading::Nothing;
        } else if range_m == f64::NEG_INFINITY {
            (&mut tally.too_near, Reading::Unknown)
        } else if range_m == 0.0 {
            (&mut tally.zero, Reading::Nothing)
        } else if range_m < 0.0 {
            (&mut tally.negative, Reading::Nothing)
        } else if self.masked_m == Some(range_m) {
            (&mut tally.filtered, Reading::Unknown)
        } else if range_m >= self.wire_max_m * (1.0 - ROUNDING) {
            (&mut tally.at_wire_max, Reading::Nothing)
        } else if self.code_m.is_some_and(|code_m| range_m == f64::from(code_m)) {
            (&mut tally.code, Reading::Nothing)
        } else if range_m > self.noise_from_m {
            (&mut tally.noisy, Reading::Nothing)
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

    pub(crate) fn note(&self, tally: &Tally, notes: &mut Notes) {
        // As f32 again, in which the scan states them: 5.6, not 5.599999904632568.
        let (wire_min_m, wire_max_m) = (self.wire_min_m as f32, self.wire_max_m as f32);
        let mut note = |code, count: usize, what: String| {
            if count > 0 {
                notes.add(code, format!("{} {what}", counted(count as u64, "beam")));
            }
        };
        note(N001, tally.masked, "in masked sectors left out".to_owned());
        note(N001, tally.filtered, format!("of {MASKED_BEYOND_M} m beyond range_max, as filters mask beams, left out"));
        note(N002, tally.zero, "of range 0 read as no return".to_owned());
        note(N003, tally.negative, "of negative range read as no return".to_owned());
        note(N004, tally.too_near, "of range -inf, too near to measure, left out".to_owned());
        note(N005, tally.at_wire_max, format!("at or beyond range_max {wire_max_m} m read as no return"));
        if let Some(code_m) = self.code_m {
            note(N006, tally.code, format!("of exactly {code_m} m, the largest range, read as no return"));
        }
        note(N029, tally.noisy, format!("within noise of range_max {wire_max_m} m read as no return"));
        note(N007, tally.below_wire_min, format!("below range_min {wire_min_m} m left out"));
        note(N008, tally.below_min, format!("nearer than min_range_m {} m left out", self.min_m));
        if 2 * tally.far_returns > tally.returns {
            note(
                N009,
                tally.far_returns,
                format!(
                    "farther than {FAR_M} m: ranges are read in metres; of millimetres, --set ingest.range_scale=0.001"
                ),
            );
        }
        note(N010, tally.beyond_max, format!("beyond max_range_m {} m read as no return", self.max_m));
    }
}

/// Whether nearly all ranges are beyond `max_m`, and no codes.
fn is_below_ranges(ranges_m: &[f32], max_m: f64) -> bool {
    let are_ranges = || ranges_m.iter().filter(|range_m| range_m.is_finite() && **range_m > 0.0);
    let is_beyond = |range_m: &&f32| f64::from(**range_m) > BELOW_BY * max_m;
    if max_m.is_infinite()
        || (are_ranges().filter(is_beyond).count() as f64) < BELOW_SHARE * are_ranges().count() as f64
    {
        return false;
    }
    let different: BTreeSet<u32> = are_ranges().filter(is_beyond).map(|range_m| range_m.to_bits()).collect();
    different.len() >= LEAST_DIFFERENT
}

/// The range by which a filter masks beams, if other beams say otherwise that nothing came back.
fn masked_m(ranges_m: &[f32], max_m: f32) -> Option<f64> {
    let masked_m = max_m + MASKED_BEYOND_M;
    let is_nothing = |range_m: &f32| {
        !range_m.is_finite() || *range_m == 0.0 || (f64::from(*range_m / max_m) - 1.0).abs() <= ROUNDING
    };
    let is_told = max_m.is_finite() && ranges_m.contains(&masked_m) && ranges_m.iter().any(is_nothing);
    is_told.then_some(f64::from(masked_m))
}

/// From where on ranges scatter about `range_max`, and are cut off there, if beams without a hit are told so.
fn noise_from_m(ranges_m: &[f32], max_m: f64) -> Option<f64> {
    let is_at_max = |range_m: f32| f64::from(range_m) >= max_m * (1.0 - ROUNDING) && range_m.is_finite();
    let is_just_below = |range_m: f32| {
        f64::from(range_m) > max_m * (1.0 - NOISE_SHARE) && f64::from(range_m) < max_m * (1.0 - ROUNDING)
    };
    let at_max = ranges_m.iter().filter(|&&range_m| is_at_max(range_m)).count();
    if max_m.is_infinite() || at_max < NOISY_BEAMS {
        return None;
    }
    let n = ranges_m.len();
    let below = (0..n).filter(|&beam| is_just_below(ranges_m[beam]));
    let (mut noisy, mut beside_max) = (0, 0);
    for beam in below {
        noisy += 1;
        beside_max +=
            usize::from([(beam + n - 1) % n, (beam + 1) % n].into_iter().any(|next| is_at_max(ranges_m[next])));
    }
    if noisy < NOISY_BEAMS || (beside_max as f64) < BESIDE_MAX_SHARE * noisy as f64 {
        return None;
    }
    let ranges = ranges_m.iter().map(|range_m| max_m - f64::from(*range_m));
    let mut below_m: Vec<f64> = ranges.filter(|below_m| *below_m > max_m * ROUNDING && *below_m < max_m).collect();
    below_m.sort_by(f64::total_cmp);
    let middle_m = below_m.get(at_max / 2).copied().unwrap_or(f64::INFINITY);
    let spread_m = ALL_SIGMAS / MEDIAN_SIGMAS * middle_m;
    let spread_m = if spread_m <= MOST_NOISE_SHARE * max_m { spread_m } else { 0.0 };
    Some(max_m - spread_m.max(NOISE_SHARE * max_m))
}

/// The largest range below `limit_m`, if it stands for none.
fn code_m(ranges_m: &[f32], limit_m: f32) -> Option<f32> {
    let are_ranges = |&range_m: &f32| range_m > 0.0 && range_m < limit_m;
    let largest_m = ranges_m.iter().copied().filter(are_ranges).reduce(f32::max)?;
    let runs = ranges_m.chunk_by(|a, b| a == b).filter(|run| are_ranges(&run[0]));
    let (mut largest, mut are_neighbours, mut elsewhere, mut equal) = (0, false, 0, 0);
    for run in runs {
        if run[0] == largest_m {
            (largest, are_neighbours) = (largest + run.len(), are_neighbours || run.len() > 1);
        } else {
            (elsewhere, equal) = (elsewhere + run.len(), equal + run.len() - 1);
        }
    }
    let is_code = largest >= if are_neighbours { CODE_BEAMS } else { CODE_BEAMS_APART };
    let is_fine = equal as f64 <= COARSE_SHARE * elsewhere as f64;
    let are_others = elsewhere as f64 >= ELSEWHERE_SHARE * ranges_m.len() as f64;
    (is_code && is_fine && are_others).then_some(largest_m)
}
