//! How the vehicle moves while its lidar takes a scan, by odometry.

use crosscut_messages::{NS_PER_S, ScanMessage};
use nalgebra::{Isometry2, UnitQuaternion};

use crate::VehiclePose;

/// The poses of the vehicle at two times of a scan. Between and around them it moves evenly.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Seconds after the stamp of the scan.
    pub(crate) times_s: [f64; 2],
    pub(crate) poses: [VehiclePose; 2],
    /// The poses are those of the sensor itself.
    pub is_of_sensor: bool,
}

impl Motion {
    /// During a scan with this stamp, whose first and last point were measured at `times_s`, in whichever order; `poses_at`
    /// knows the poses at two times that ascend. The vehicle stands if the scan does not tell how long it takes, or the poses end before it.
    pub fn during(
        stamp_ns: u64,
        times_s: [f64; 2],
        mut poses_at: impl FnMut([u64; 2]) -> Option<[VehiclePose; 2]>,
    ) -> Option<Self> {
        [times_s, [0.0; 2]].into_iter().find_map(|times_s| {
            let [first_ns, last_ns] = stamps_ns(stamp_ns, times_s);
            let poses = if first_ns <= last_ns {
                poses_at([first_ns, last_ns])?
            } else {
                let [last, first] = poses_at([last_ns, first_ns])?;
                [first, last]
            };
            Some(Self { times_s, poses, is_of_sensor: false })
        })
    }

    fn at(&self, time_s: f64) -> VehiclePose {
        let ([from_s, to_s], [from, to]) = (self.times_s, self.poses);
        let share = if to_s != from_s { (time_s - from_s) / (to_s - from_s) } else { 0.0 };
        from.between(&to, share)
    }

    /// The pose in the middle of the scan, in the plane.
    pub fn middle(&self) -> Isometry2<f64> {
        self.at_middle().plane
    }

    /// What turns the frame of the vehicle level in the middle of the scan, if its odometry states rotations.
    pub(crate) fn tilt(&self) -> Option<UnitQuaternion<f64>> {
        self.at_middle().tilt
    }

    fn at_middle(&self) -> VehiclePose {
        self.at(0.5 * (self.times_s[0] + self.times_s[1]))
    }

    /// The angle by which the vehicle turns, anticlockwise, rad.
    pub(crate) fn turned_rad(&self) -> f64 {
        self.poses[0].plane.rotation.angle_to(&self.poses[1].plane.rotation)
    }

    /// The way from the first pose to the second, m.
    pub(crate) fn way_m(&self) -> f64 {
        (self.poses[1].plane.translation.vector - self.poses[0].plane.translation.vector).norm()
    }

    /// The pose at `time_s` in the frame of the middle of the scan.
    pub(crate) fn in_middle(&self, time_s: f64) -> Isometry2<f64> {
        self.middle().inv_mul(&self.at(time_s).plane)
    }
}

/// The times that are `times_s` after a stamp.
pub(crate) fn stamps_ns(stamp_ns: u64, times_s: [f64; 2]) -> [u64; 2] {
    times_s.map(|time_s| stamp_ns.saturating_add_signed((time_s * NS_PER_S) as i64))
}

/// When the first and last point of a scan were measured, s after the stamp, if its beams are `beam_s` apart; both 0 if
/// that is not known.
pub fn times_s(scan: &ScanMessage, beam_s: f64) -> [f64; 2] {
    match scan {
        ScanMessage::Scan(scan) => {
            let scan_s = beam_s.abs() * scan.ranges.len().saturating_sub(1) as f64;
            if beam_s < 0.0 { [scan_s, 0.0] } else { [0.0, scan_s] }
        }
        ScanMessage::Cloud(cloud) => {
            let times_s = cloud.times_s.iter().filter(|time_s| time_s.is_finite());
            times_s.fold([0.0; 2], |[from_s, to_s], time_s| [time_s.min(from_s), time_s.max(to_s)])
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use nalgebra::{Point2, Vector2};

    use super::*;

    #[test]
    fn what_is_seen_on_the_way_lies_where_the_middle_sees_it() {
        let level = |plane| VehiclePose { plane, tilt: Some(UnitQuaternion::default()) };
        let poses = [Isometry2::identity(), Isometry2::new(Vector2::new(2.0, 0.0), FRAC_PI_2)].map(level);
        let motion = Motion { times_s: [-0.1, 0.1], poses, is_of_sensor: false };
        assert!((motion.turned_rad() - FRAC_PI_2).abs() < 1e-12 && (motion.way_m() - 2.0).abs() < 1e-12);
        let place = Point2::new(5.0, 1.0);
        let expected = motion.middle().inverse_transform_point(&place);
        for time_s in [-0.1, -0.03, 0.0, 0.1] {
            let seen = motion.at(time_s).plane.inverse_transform_point(&place);
            assert!((motion.in_middle(time_s) * seen - expected).norm() < 1e-12, "{time_s}");
        }
        let still = Motion { times_s: [0.0; 2], poses: [poses[1]; 2], is_of_sensor: false };
        assert_eq!((still.middle(), still.turned_rad()), (poses[1].plane, 0.0));
    }
}
