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

use std::f64::consts::FRAC_PI_4;

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
    before: Before,
}

#[derive(Debug, Default)]
struct Before {
    stamp: Time,
    /// `angle_min` and `angle_increment`.
    angles_rad: (f32, f32),
    ranges_m: Vec<f32>,
}

impl Turning {
    /// The angle by which the sensor turned from one beam of `scan` to the next, anticlockwise, rad, 0 if that is not
    /// known; and the time from one beam to the next, s, 0 if it is not stated or cannot be right. `scan` is the scan
    /// before from now on.
    pub fn per_beam(&mut self, scan: &LaserScan) -> (f64, f64) {
        let turned_rad = estimate(&self.before, scan).unwrap_or(0.0);
        let beam_s = beam_s(&self.before, scan).unwrap_or(0.0);
        self.before.stamp = scan.header.stamp;
        self.before.angles_rad = (scan.angle_min, scan.angle_increment);
        self.before.ranges_m.clone_from(&scan.ranges);
        (turned_rad, beam_s)
    }
}

/// The time from one beam of `scan` to the next as it states it, s, 0 if it does not or that cannot be right.
pub(crate) fn stated_beam_s(scan: &LaserScan) -> f64 {
    beam_s(&Before::default(), scan).unwrap_or(0.0)
}

/// From the scan before to this one, s.
fn period_s(before: &Before, scan: &LaserScan) -> Option<f64> {
    let period_ns = scan.header.stamp.to_ns()?.checked_sub(before.stamp.to_ns()?)?;
    Some(period_ns as f64 * 1e-9)
}

/// The time from beam to beam, if it is stated and leaves room for the next scan.
fn beam_s(before: &Before, scan: &LaserScan) -> Option<f64> {
    let beam_s = f64::from(scan.time_increment);
    let scan_s = beam_s * scan.ranges.len() as f64;
    let has_room = before.ranges_m.is_empty() || period_s(before, scan)? * LONGEST_SCAN >= scan_s;
    (beam_s > 0.0 && scan_s <= LONGEST_SCAN_S && has_room).then_some(beam_s)
}

fn estimate(before: &Before, scan: &LaserScan) -> Option<f64> {
    let (increment_rad, beam_s) = (f64::from(scan.angle_increment), beam_s(before, scan)?);
    let beams = scan.ranges.len();
    let is_alike = before.angles_rad == (scan.angle_min, scan.angle_increment) && before.ranges_m.len() == beams;
    let period_s = period_s(before, scan)?;
    if !is_alike || increment_rad == 0.0 || period_s > LONGEST_PERIODS * beam_s * beams as f64 {
        return None;
    }
    let farthest = ((FARTHEST_RAD / increment_rad.abs()) as i64).min(beams as i64 / 2);
    let coarse = (beams / COMPARED_BEAMS).max(1) as i64;
    let difference_m = |shift: i64| difference_m(&before.ranges_m, scan, shift, coarse as usize);
    let unshifted_m = difference_m(0).filter(|difference_m| *difference_m >= STILL_M)?;
    let best = |shifts: &mut dyn Iterator<Item = i64>| {
        let of = shifts.filter_map(|shift| Some((shift, difference_m(shift)?)));
        of.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.abs().cmp(&b.0.abs())))
    };
    let (near, _) = best(&mut (-farthest / coarse..=farthest / coarse).map(|step| step * coarse))?;
    let (shift, least_m) = best(&mut (near - coarse..=near + coarse))?;
    if least_m > ALIKE_M || least_m > BETTER_SHARE * unshifted_m {
        return None;
    }
    let shift = shift as f64;
    Some(-shift * increment_rad * beam_s / (period_s + shift * beam_s))
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
