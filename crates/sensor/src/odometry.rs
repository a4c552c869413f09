//! Poses by odometry, interpolated to the time of a scan.

use std::ops::RangeInclusive;

use crosscut_messages::{
    CDR_ENCODING, DecodeError, Odometry as OdometryMessage, Quaternion, TfMessage, TransformStamped, Vector3, ros,
};
use crosscut_stage::is_finite_pose;
use nalgebra::{Isometry2, UnitQuaternion, Vector2, Vector3 as Axis};

/// The frame in which odometry is kept (REP 105).
const ODOMETRY_FRAME: &str = "odom";

/// Between two odometry messages farther apart than this the pose is unknown.
const MAX_GAP_NS: u64 = 500_000_000;

/// Quaternions that are not normalised still turn; numbers that are none are of another length.
const LENGTHS: RangeInclusive<f64> = 1e-3..=1e3;

/// Where a vehicle is, and how it is tilted there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehiclePose {
    /// In the plane.
    pub plane: Isometry2<f64>,
    /// From the frame of the vehicle to the level one that looks where the vehicle does: its roll and pitch.
    pub tilt: UnitQuaternion<f64>,
}

impl VehiclePose {
    /// The pose on the straight line and the shorter turns from this one to another.
    pub(crate) fn between(&self, to: &Self, share: f64) -> Self {
        Self { plane: self.plane.lerp_slerp(&to.plane, share), tilt: self.tilt.nlerp(&to.tilt, share) }
    }
}

/// Poses of the vehicle by time, in the frame of its odometry.
#[derive(Clone, Debug, Default)]
pub struct Odometry {
    /// By stamp, strictly ascending.
    poses: Vec<(u64, VehiclePose)>,
}

impl Odometry {
    /// Adds the pose at `stamp_ns`. A pose that is not finite, or not later than the last one, is left out: returns
    /// whether it was taken.
    pub fn push(&mut self, stamp_ns: u64, pose: VehiclePose) -> bool {
        let is_later = self.poses.last().is_none_or(|&(last_ns, _)| stamp_ns > last_ns);
        let is_taken = is_later && is_finite_pose(&pose.plane);
        if is_taken {
            self.poses.push((stamp_ns, pose));
        }
        is_taken
    }

    /// Whether messages of this type in CDR are `nav_msgs/Odometry` or transforms, which have poses.
    pub fn reads(type_name: &str) -> bool {
        ros::is_odometry(type_name, CDR_ENCODING) || ros::is_transforms(type_name, CDR_ENCODING)
    }

    /// Adds the pose in a message in CDR of a type that is [read](Self::reads), if it has one: returns whether it was taken.
    ///
    /// # Errors
    /// When the message cannot be decoded.
    pub fn push_message(&mut self, type_name: &str, data: &[u8]) -> Result<bool, DecodeError> {
        let found = pose_in(ros::is_odometry(type_name, CDR_ENCODING), CDR_ENCODING, data)?;
        Ok(found.is_some_and(|(stamp_ns, pose)| self.push(stamp_ns, pose)))
    }

    /// The stamp of the last pose.
    pub fn last_ns(&self) -> Option<u64> {
        self.poses.last().map(|&(pose_ns, _)| pose_ns)
    }

    /// How many poses are kept.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Whether no pose is kept.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// The pose at `stamp_ns`, on the straight line and the shorter turn between the poses before and after; `None`
    /// outside the odometry or in a gap of more than half a second.
    pub fn at(&self, stamp_ns: u64) -> Option<VehiclePose> {
        let after = self.poses.partition_point(|&(pose_ns, _)| pose_ns < stamp_ns);
        let &(after_ns, to) = self.poses.get(after)?;
        if after_ns == stamp_ns {
            return Some(to);
        }
        let &(before_ns, from) = self.poses.get(after.checked_sub(1)?)?;
        let gap_ns = after_ns - before_ns;
        let share = (stamp_ns - before_ns) as f64 / gap_ns as f64;
        (gap_ns <= MAX_GAP_NS).then(|| from.between(&to, share))
    }

    /// Drops the poses before the last one that is not later than `stamp_ns`, so that memory stays flat on a long flight.
    pub fn forget_before(&mut self, stamp_ns: u64) {
        let after = self.poses.partition_point(|&(pose_ns, _)| pose_ns <= stamp_ns);
        self.poses.drain(..after.saturating_sub(1));
    }
}

/// Stamp and pose in a message of odometry, else of transforms, if it holds one.
///
/// # Errors
/// When the message cannot be decoded.
pub fn pose_in(is_odometry: bool, encoding: &str, data: &[u8]) -> Result<Option<(u64, VehiclePose)>, DecodeError> {
    if is_odometry {
        let odometry: OdometryMessage = ros::decode(encoding, data)?;
        let pose = odometry.pose.pose;
        let length = pose.orientation.length();
        if length != 0.0 && !LENGTHS.contains(&length) {
            let cause = format!("a quaternion of length {length:e} is no rotation");
            return Err(DecodeError::Value { field: "pose.orientation", cause });
        }
        let stamp_ns = odometry.header.stamp.to_ns().unwrap_or(0);
        return Ok(Some((stamp_ns, vehicle_pose(pose.position, &pose.orientation))));
    }
    let transforms: TfMessage = ros::decode(encoding, data)?;
    let is_moving = |one: &&TransformStamped| ros::plain_frame(&one.header.frame_id) == ODOMETRY_FRAME;
    let found = transforms.transforms.iter().find(is_moving);
    Ok(found.map(|one| {
        let stamp_ns = one.header.stamp.to_ns().unwrap_or(0);
        (stamp_ns, vehicle_pose(one.transform.translation, &one.transform.rotation))
    }))
}

fn vehicle_pose(position: Vector3, orientation: &Quaternion) -> VehiclePose {
    let Quaternion { x, y, z, w } = *orientation;
    let plane = Isometry2::new(Vector2::new(position.x, position.y), orientation.yaw_rad());
    // Some drivers send zeros.
    let turned = UnitQuaternion::try_new(nalgebra::Quaternion::new(w, x, y, z), 1e-9).unwrap_or_default();
    let ahead = UnitQuaternion::from_axis_angle(&Axis::z_axis(), plane.rotation.angle());
    VehiclePose { plane, tilt: ahead.inverse() * turned }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use nalgebra::Vector2;

    use super::*;

    fn pose(x_m: f64, yaw_rad: f64) -> VehiclePose {
        VehiclePose { plane: Isometry2::new(Vector2::new(x_m, 0.0), yaw_rad), tilt: UnitQuaternion::default() }
    }

    fn quarter_turn() -> Odometry {
        let mut odometry = Odometry::default();
        assert!(odometry.push(100_000_000, pose(1.0, 0.0)));
        assert!(odometry.push(200_000_000, pose(3.0, FRAC_PI_2)));
        odometry
    }

    #[test]
    fn a_scan_between_two_poses_lies_between_them() {
        let between = quarter_turn().at(150_000_000).expect("inside").plane;
        assert!((between.translation.x - 2.0).abs() < 1e-12);
        assert!((between.rotation.angle() - FRAC_PI_2 / 2.0).abs() < 1e-12);
    }

    #[test]
    fn outside_the_odometry_and_in_its_gaps_there_is_no_pose() {
        let mut odometry = quarter_turn();
        assert_eq!(odometry.at(99_999_999), None);
        assert_eq!(odometry.at(200_000_001), None);
        assert!(odometry.push(800_000_000, pose(4.0, 0.0)));
        assert_eq!(odometry.at(500_000_000), None);
        assert_eq!(odometry.at(800_000_000), Some(pose(4.0, 0.0)));
    }

    #[test]
    fn poses_out_of_order_or_not_finite_are_left_out() {
        let mut odometry = quarter_turn();
        assert!(!odometry.push(150_000_000, pose(9.0, 0.0)));
        assert!(!odometry.push(300_000_000, pose(f64::NAN, 0.0)));
        assert_eq!(odometry.at(200_000_000), Some(pose(3.0, FRAC_PI_2)));
    }

    #[test]
    fn forgetting_keeps_what_later_scans_need() {
        let mut odometry = quarter_turn();
        odometry.forget_before(150_000_000);
        assert!(odometry.at(150_000_000).is_some());
        odometry.forget_before(200_000_000);
        assert_eq!((odometry.poses.len(), odometry.at(150_000_000)), (1, None));
    }
}
