//! Poses by odometry, interpolated to the time of a scan.

use std::ops::RangeInclusive;

use crosscut_messages::{
    CDR_ENCODING, DecodeError, Header, Odometry as OdometryMessage, Quaternion, TfMessage, TransformStamped, Vector3,
    ros,
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
    /// From the frame of the vehicle to the level one that looks where the vehicle does: its roll and pitch; `None` if the message
    /// states no rotation.
    pub tilt: Option<UnitQuaternion<f64>>,
}

impl VehiclePose {
    /// The pose on the straight line and the shorter turns from this one to another.
    pub(crate) fn between(&self, to: &Self, share: f64) -> Self {
        // Of quaternions of either sign, the shorter turn; at half a turn there is none.
        let turned = |(from, to): (UnitQuaternion<f64>, _)| from.try_slerp(&to, share, 1e-9);
        Self { plane: self.plane.lerp_slerp(&to.plane, share), tilt: self.tilt.zip(to.tilt).and_then(turned) }
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
        Ok(found.is_some_and(|found| self.push(found.stamp_ns, found.pose)))
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

/// A pose as a message states it.
#[derive(Clone, Debug)]
pub struct StatedPose {
    /// Its stamp, nanoseconds since the epoch; 0 if there is none.
    pub stamp_ns: u64,
    /// The frame that moves, without a slash before it.
    pub frame_id: String,
    /// The pose of that frame.
    pub pose: VehiclePose,
}

/// The pose in a message of odometry, else of transforms, if it holds one.
///
/// # Errors
/// When the message cannot be decoded.
pub fn pose_in(is_odometry: bool, encoding: &str, data: &[u8]) -> Result<Option<StatedPose>, DecodeError> {
    if is_odometry {
        let odometry: OdometryMessage = ros::decode(encoding, data)?;
        let pose = vehicle_pose("pose.orientation", odometry.pose.pose.position, &odometry.pose.pose.orientation)?;
        return Ok(Some(stated(&odometry.header, &odometry.child_frame_id, pose)));
    }
    let transforms: TfMessage = ros::decode(encoding, data)?;
    let is_moving = |one: &&TransformStamped| ros::plain_frame(&one.header.frame_id) == ODOMETRY_FRAME;
    let Some(one) = transforms.transforms.iter().find(is_moving) else { return Ok(None) };
    let pose = vehicle_pose("transform.rotation", one.transform.translation, &one.transform.rotation)?;
    Ok(Some(stated(&one.header, &one.child_frame_id, pose)))
}

fn stated(header: &Header, frame_id: &str, pose: VehiclePose) -> StatedPose {
    let stamp_ns = header.stamp.to_ns().unwrap_or(0);
    StatedPose { stamp_ns, frame_id: ros::plain_frame(frame_id).to_owned(), pose }
}

fn vehicle_pose(field: &'static str, position: Vector3, orientation: &Quaternion) -> Result<VehiclePose, DecodeError> {
    let length = orientation.length();
    if length != 0.0 && !LENGTHS.contains(&length) {
        let cause = format!("a quaternion of length {length:e} is no rotation");
        return Err(DecodeError::Value { field, cause });
    }
    let Quaternion { x, y, z, w } = *orientation;
    let plane = Isometry2::new(Vector2::new(position.x, position.y), orientation.yaw_rad());
    let ahead = UnitQuaternion::from_axis_angle(&Axis::z_axis(), plane.rotation.angle());
    // Some drivers send zeros: then the place alone is known.
    let turned = UnitQuaternion::try_new(nalgebra::Quaternion::new(w, x, y, z), 1e-9);
    Ok(VehiclePose { plane, tilt: turned.map(|turned| ahead.inverse() * turned) })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use nalgebra::Vector2;

    use super::*;

    fn pose(x_m: f64, yaw_rad: f64) -> VehiclePose {
        VehiclePose { plane: Isometry2::new(Vector2::new(x_m, 0.0), yaw_rad), tilt: Some(UnitQuaternion::default()) }
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
    fn a_tilt_is_known_where_both_poses_around_state_a_rotation() {
        let message = |yaw_rad: f64, sign: f64| {
            let turned = sign * UnitQuaternion::from_euler_angles(0.1, 0.0, yaw_rad).into_inner();
            Quaternion { x: turned.i, y: turned.j, z: turned.k, w: turned.w }
        };
        let zeros = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 0.0 };
        for (to, is_known) in [(message(-3.1, 1.0), true), (message(-3.1, -1.0), true), (zeros, false)] {
            let mut odometry = Odometry::default();
            for (stamp_ns, turn) in [(100, message(3.1, 1.0)), (200, to)] {
                assert!(odometry.push(stamp_ns, vehicle_pose("", Vector3::default(), &turn).expect("a rotation")));
            }
            let tilt = odometry.at(150).expect("inside").tilt;
            assert_eq!(tilt.map(|tilt| (tilt.angle() * 1e3).round()), is_known.then_some(100.0), "{to:?}");
        }
        let no_turn = Quaternion { w: f64::NAN, ..zeros };
        assert!(vehicle_pose("", Vector3::default(), &no_turn).is_err());
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
