//! How far the sensor turns with its vehicle while it takes a scan, by the scan before.
//!
//! Beam i of a scan is taken `time_increment`·i after its stamp. A sensor that turns at ω with its vehicle sees what was at
//! beam i of the scan before, P earlier, at beam i + s now:
//!
//! ω·(P + s·time_increment) + s·angle_increment = 0
//!
//! The shift s is the one for which the ranges of the two scans agree best. Where there is odometry, that tells the angle
//! instead. All beams of a turn are then brought to the heading in the middle of the turn, which stretches or shrinks the
//! angle between them. The distance that the vehicle drives during a turn is not taken into account.
//!
//! Drivers of lidars that turn clockwise list the beams anticlockwise, and leave `time_increment` positive: beam i is taken
//! before beam i - 1. Two scans in a row do not show that, as both are bent alike; a full turn does by itself, where it ends
//! ([`Seam`]). A sensor that turns with its beams sees less than a turn, one that turns against them sees the first walls
//! twice.

use std::f64::consts::{FRAC_PI_4, TAU};

use crosscut_messages::{LaserScan, Time};

/// A sensor that turns by less than this during a scan is left alone, rad.
pub(crate) const LEAST_TURN_RAD: f64 = 9.0 * DEGREE_RAD;
/// A scan is looked for within this angle of the one before, rad.
const FARTHEST_RAD: f64 = FRAC_PI_4;
/// About this many beams are compared.
const COMPARED_BEAMS: usize = 180;
/// Fewer pairs of beams do not show a shift.
const LEAST_PAIRS: usize = 60;
/// Ranges that differ by more than this are of different walls, m.
const OTHER_WALL_M: f64 = 0.5;
/// The ranges at the best shift differ by at most this share of what they differ without a shift.
const BETTER_SHARE: f64 = 0.5;
/// The ranges of a vehicle that does not turn differ by less than this on average without a shift, m.
const STILL_M: f64 = 0.05;
/// The ranges at the best shift differ by at most this on average, m.
const ALIKE_M: f64 = 0.2;
/// At the end of a turn the first walls are seen again if ranges agree to within this, m, and the walls there are uneven
/// by this many times more; they are not if the ranges differ by the second value.
const AGAIN_M: f64 = 0.1;
const UNEVEN: f64 = 3.0;
const NOT_AGAIN_M: f64 = 0.4;
/// So many turns that show one order outweigh those that follow.
const MOST_SURE: i32 = 10;
/// Fewer beams at the end of a turn show nothing.
const LEAST_SEAM_BEAMS: usize = 5;

/// Scans follow each other within this many times the duration of one.
const LONGEST_PERIODS: f64 = 2.5;
/// A stated duration that exceeds the time between the scans by more than this factor is wrong.
const LONGEST_SCAN: f64 = 1.2;
/// A stated duration that exceeds this is wrong, s.
const LONGEST_SCAN_S: f64 = 10.0;

const DEGREE_RAD: f64 = std::f64::consts::PI / 180.0;

/// Compares each scan with the one before it.
#[derive(Debug, Default)]
pub struct Turning {
    before: PreviousScan,
    /// How many turns more show that beams are listed as they are taken than the other way round.
    as_listed: i32,
}

/// What the end of a turn shows of a sensor that turns with its vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Seam {
    /// The first walls are seen again.
    Again,
    /// They are not.
    Short,
}

#[derive(Debug, Default)]
struct PreviousScan {
    stamp: Time,
    /// `angle_min` and `angle_increment`.
    angles_rad: (f32, f32),
    ranges_m: Vec<f32>,
}

impl Turning {
    /// The angle by which the sensor turned from one beam of `scan` to the next, anticlockwise, rad, 0 if that is not
    /// known; and the time from one beam to the next, s, 0 if it is not stated or cannot be right, below 0 if beams are listed
    /// against their order in time. `scan` is the scan before from now on.
    pub fn per_beam(&mut self, scan: &LaserScan) -> (f64, f64) {
        let turned_rad = estimate(&self.before, scan).unwrap_or(0.0);
        let beam_s = beam_s(&self.before, scan).unwrap_or(0.0);
        if let Some(seam) = seam(scan, turned_rad) {
            // Beams that turn the way the sensor does, if they are taken as they are listed, look beyond a full turn.
            let turns_with_beams = turned_rad * f64::from(scan.angle_increment) > 0.0;
            self.as_listed += if turns_with_beams == (seam == Seam::Again) { 1 } else { -1 };
            self.as_listed = self.as_listed.clamp(-MOST_SURE, MOST_SURE);
        }
        let order = if self.as_listed < 0 { -1.0 } else { 1.0 };
        let (turned_rad, beam_s) = (order * turned_rad, order * beam_s);
        self.before.stamp = scan.header.stamp;
        self.before.angles_rad = (scan.angle_min, scan.angle_increment);
        self.before.ranges_m.clone_from(&scan.ranges);
        (turned_rad, beam_s)
    }
}

/// The time from one beam of `scan` to the next as it states it, s, 0 if it does not or that cannot be right.
pub(crate) fn stated_beam_s(scan: &LaserScan) -> f64 {
    beam_s(&PreviousScan::default(), scan).unwrap_or(0.0)
}

/// From the scan before to this one, s.
fn period_s(before: &PreviousScan, scan: &LaserScan) -> Option<f64> {
    let period_ns = scan.header.stamp.to_ns()?.checked_sub(before.stamp.to_ns()?)?;
    Some(period_ns as f64 * 1e-9)
}

/// The time from beam to beam, if it is stated and leaves room for the next scan.
fn beam_s(before: &PreviousScan, scan: &LaserScan) -> Option<f64> {
    let beam_s = f64::from(scan.time_increment);
    let scan_s = beam_s * scan.ranges.len() as f64;
    let has_room = before.ranges_m.is_empty() || period_s(before, scan)? * LONGEST_SCAN >= scan_s;
    (beam_s > 0.0 && scan_s <= LONGEST_SCAN_S && has_room).then_some(beam_s)
}

fn estimate(before: &PreviousScan, scan: &LaserScan) -> Option<f64> {
    let (increment_rad, beam_s) = (f64::from(scan.angle_increment), beam_s(before, scan)?);
    let beams = scan.ranges.len();
    let is_alike = before.angles_rad == (scan.angle_min, scan.angle_increment) && before.ranges_m.len() == beams;
    let period_s = period_s(before, scan)?;
    if !is_alike || increment_rad == 0.0 || period_s > LONGEST_PERIODS * beam_s * beams as f64 {
        return None;
    }
    let unshifted_m = difference_m(&before.ranges_m, scan, 0, coarse(beams)).filter(|apart_m| *apart_m >= STILL_M)?;
    let (shift, least_m) = best_shift(&before.ranges_m, scan)?;
    if least_m > ALIKE_M || least_m > BETTER_SHARE * unshifted_m {
        return None;
    }
    let shift = shift as f64;
    Some(-shift * increment_rad * beam_s / (period_s + shift * beam_s))
}

/// By how many beams what an earlier scan with these ranges saw is shifted in a later one; `None` if they do not agree.
pub(crate) fn shift_beams(before_m: &[f32], scan: &LaserScan) -> Option<i64> {
    best_shift(before_m, scan).filter(|(_, least_m)| *least_m <= ALIKE_M).map(|(shift, _)| shift)
}

/// Every n-th beam is compared first.
fn coarse(beams: usize) -> usize {
    (beams / COMPARED_BEAMS).max(1)
}

/// The shift at which two scans agree best, and what their ranges differ by then, m.
fn best_shift(before_m: &[f32], scan: &LaserScan) -> Option<(i64, f64)> {
    let beams = scan.ranges.len();
    let farthest = ((FARTHEST_RAD / f64::from(scan.angle_increment).abs()) as i64).min(beams as i64 / 2);
    let step = coarse(beams) as i64;
    let best = |shifts: &mut dyn Iterator<Item = i64>| {
        let of = shifts.filter_map(|shift| Some((shift, difference_m(before_m, scan, shift, step as usize)?)));
        of.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.abs().cmp(&b.0.abs())))
    };
    let (near, _) = best(&mut (-farthest / step..=farthest / step).map(|at| at * step))?;
    best(&mut (near - step..=near + step))
}

/// What the end of a full turn shows of a sensor that turned by `turned_rad` from beam to beam.
fn seam(scan: &LaserScan, turned_rad: f64) -> Option<Seam> {
    let (beams, step_rad) = (scan.ranges.len(), f64::from(scan.angle_increment).abs());
    let is_full_turn = (beams as f64 * step_rad - TAU).abs() < 2.0 * step_rad;
    let turned_rad = turned_rad.abs();
    let again = (beams as f64 * turned_rad / (step_rad + turned_rad)).round() as usize;
    if !is_full_turn || again < LEAST_SEAM_BEAMS || 2 * again > beams {
        return None;
    }
    let range_m = |beam: usize| {
        let range_m = f64::from(scan.ranges[beam]);
        (range_m.is_finite() && scan.ranges[beam] > scan.range_min && scan.ranges[beam] < scan.range_max)
            .then_some(range_m)
    };
    let apart_m = |from: usize, to: usize| {
        let pairs = (0..again).filter_map(|beam| Some((range_m(from + beam)? - range_m(to + beam)?).abs()));
        let (count, sum_m) = pairs.fold((0, 0.0), |(count, sum_m), apart_m| (count + 1, sum_m + apart_m));
        (count >= LEAST_SEAM_BEAMS).then(|| sum_m / count as f64)
    };
    let at_end_m = apart_m(0, beams - again)?;
    let uneven_m = apart_m(0, again)?.min(apart_m(beams - 2 * again, beams - again)?);
    match at_end_m {
        m if m < AGAIN_M && uneven_m > UNEVEN * m => Some(Seam::Again),
        m if m > NOT_AGAIN_M => Some(Seam::Short),
        _ => None,
    }
}

/// What the ranges of two scans differ by on average, if beam i of the earlier one is beam i + `shift` of the later one, m.
fn difference_m(before_m: &[f32], scan: &LaserScan, shift: i64, every: usize) -> Option<f64> {
    let is_range = |range_m: f32| range_m.is_finite() && range_m > scan.range_min && range_m < scan.range_max;
    let (mut pairs, mut sum_m) = (0, 0.0);
    for (beam, &earlier_m) in before_m.iter().enumerate().step_by(every) {
        let later_m = usize::try_from(beam as i64 + shift).ok().and_then(|beam| scan.ranges.get(beam));
        let Some(&later_m) = later_m else { continue };
        sum_m += match (is_range(earlier_m), is_range(later_m)) {
            (true, true) => f64::from(earlier_m - later_m).abs().min(OTHER_WALL_M),
            (false, false) => continue,
            _ => OTHER_WALL_M,
        };
        pairs += 1;
    }
    (pairs >= LEAST_PAIRS).then(|| sum_m / pairs as f64)
}
