//! The vehicle in its own scans: what stands at the same bearing and range while the rest moves.

use crosscut_stage::Point;

/// Bearings are told apart by sectors of the full turn.
pub(crate) const SECTORS: usize = 360;

/// What is farther from the sensor than this is not the vehicle, metres.
pub(crate) const FARTHEST_M: f64 = 0.5;

/// A range that changes by less than this stays, metres.
pub(crate) const STAYS_M: f64 = 0.05;

/// Scans are compared with one at most this many scans earlier.
const MOST_SCANS: u32 = 50;

/// What stays is the vehicle if this share of what is farther away does not.
pub(crate) const MOVES: f64 = 0.5;

/// Finds the returns of the vehicle itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chassis {
    /// Of each sector the nearest range in the scan that the others are compared with; infinite without a return.
    first_m: Vec<f64>,
    has_moved: Vec<bool>,
    scans: u32,
    /// Of each sector the range at which the vehicle stands in it, if it does.
    of_vehicle_m: Vec<Option<f64>>,
}

pub(crate) fn sector_of(bearing_rad: f64) -> usize {
    let turns = bearing_rad / std::f64::consts::TAU;
    (turns.rem_euclid(1.0) * SECTORS as f64) as usize % SECTORS
}

fn sector(point: &Point) -> usize {
    sector_of(point.y.atan2(point.x))
}

fn range_m(point: &Point) -> f64 {
    point.x.hypot(point.y)
}

impl Chassis {
    /// Scans are compared with one at least this many scans earlier.
    pub(crate) const LEAST_SCANS: u32 = 3;

    /// Takes the returns of the next scan. Whether some are the vehicle's that were not before.
    pub(crate) fn add(&mut self, points_m: &[Point]) -> bool {
        // Nothing near in view is the usual case.
        let is_near = |range_m: &f64| *range_m < FARTHEST_M;
        if self.first_m.is_empty() && !points_m.iter().any(|point| is_near(&range_m(point))) {
            return false;
        }
        let mut ranges_m = vec![f64::INFINITY; SECTORS];
        for point in points_m {
            let nearest_m = &mut ranges_m[sector(point)];
            *nearest_m = nearest_m.min(range_m(point));
        }
        if self.first_m.is_empty() || self.scans > MOST_SCANS {
            self.begin(ranges_m);
            return false;
        }
        self.scans += 1;
        let (mut far, mut moved) = (0, 0);
        for ((has_moved, first_m), now_m) in self.has_moved.iter_mut().zip(&self.first_m).zip(&ranges_m) {
            // A beam at the edge of two sectors is now in one, now in the other.
            *has_moved |= first_m.is_finite() && now_m.is_finite() && (now_m - first_m).abs() > STAYS_M;
            if first_m.is_finite() && !is_near(first_m) {
                (far, moved) = (far + 1, moved + u32::from(*has_moved));
            }
        }
        if self.scans < Self::LEAST_SCANS || f64::from(moved) < MOVES * f64::from(far) || far == 0 {
            return false;
        }
        let of_vehicle = |(first_m, has_moved): (&f64, &bool)| (is_near(first_m) && !has_moved).then_some(*first_m);
        let of_vehicle_m: Vec<_> = self.first_m.iter().zip(&self.has_moved).map(of_vehicle).collect();
        let is_any = |of: &[Option<f64>]| of.iter().any(Option::is_some);
        let is_new = !is_any(&self.of_vehicle_m) && is_any(&of_vehicle_m);
        self.of_vehicle_m = of_vehicle_m;
        self.begin(ranges_m);
        is_new
    }

    fn begin(&mut self, ranges_m: Vec<f64>) {
        self.first_m = ranges_m;
        self.has_moved.clear();
        self.has_moved.resize(SECTORS, false);
        self.scans = 0;
    }

    /// Whether a return is the vehicle's. A beam at the edge of two sectors is now in one, now in the other.
    pub(crate) fn has(&self, point: &Point) -> bool {
        if self.of_vehicle_m.is_empty() {
            return false;
        }
        let (at, point_m) = (sector(point), range_m(point));
        let stays = |by: usize| {
            let of_vehicle_m = self.of_vehicle_m[(at + by) % SECTORS];
            of_vehicle_m.is_some_and(|of_vehicle_m| (point_m - of_vehicle_m).abs() < 2.0 * STAYS_M)
        };
        [0, 1, SECTORS - 1].into_iter().any(stays)
    }
}
