//! Where each revolution was taken, by the chosen kind of pose.

use nalgebra::{Isometry2, Matrix3, Vector3};

use crosscut_stage::{Notes, Number, ParamSpec, Params, Revolution, Word, is_finite_pose};

use crate::{Matched, Motion, ScanMatcher};

const POSE: Word = Word::one_of("pose", &["auto", "odometry", "scan_match", "odometry_scan_match", "none"])
    .doc("odometry, scans matched to the walls seen before, or both; auto: both where there is odometry, else scans");

const ODOMETRY_SHARE: Number = Number::new("odometry_share", "", 0.05)
    .above(0.0)
    .to(1.0)
    .doc("standard deviation of the odometry's motion between two revolutions, as a share of it");

const ODOMETRY_FLOOR_M: Number = Number::new("odometry_floor_m", "m", 0.005)
    .above(0.0)
    .to(1.0)
    .doc("added to that standard deviation, and in rad to that of its turn");

/// Parameters of the pose.
pub(crate) const POSE_PARAMS: [ParamSpec; 3] = [POSE.spec, ODOMETRY_SHARE.spec, ODOMETRY_FLOOR_M.spec];

/// A motion farther than this many standard deviations from the predicted one is noted as a slip or a jump.
const SURPRISING: f64 = 6.0;

/// Gives each revolution of a flight its pose.
#[derive(Clone, Debug)]
pub struct PoseTracker {
    kind: PoseKind,
    odometry_share: f64,
    odometry_floor_m: f64,
    matcher: ScanMatcher,
    /// The last odometry, and the pose of its revolution.
    odometry: Option<(Isometry2<f64>, Isometry2<f64>)>,
    pose: Isometry2<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PoseKind {
    Auto,
    Odometry,
    ScanMatch,
    OdometryScanMatch,
    None,
}

/// The pose of one revolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracked {
    /// In the frame of the first revolution.
    pub pose: Isometry2<f64>,
    /// The scan does not go with those before: what was seen from earlier poses does not lie where it did.
    pub lost: bool,
}

impl PoseTracker {
    /// From checked values of [`PARAMS`](crate::PARAMS).
    pub fn new(params: &Params) -> Self {
        let kind = match params.get(POSE).as_str() {
            "odometry" => PoseKind::Odometry,
            "scan_match" => PoseKind::ScanMatch,
            "odometry_scan_match" => PoseKind::OdometryScanMatch,
            "none" => PoseKind::None,
            _ => PoseKind::Auto,
        };
        Self {
            kind,
            odometry_share: params.get(ODOMETRY_SHARE),
            odometry_floor_m: params.get(ODOMETRY_FLOOR_M),
            matcher: ScanMatcher::default(),
            odometry: None,
            pose: Isometry2::identity(),
        }
    }

    /// The pose of the next revolution, with what was odd in `notes`: a slip or a jump, a lost map, missing odometry.
    /// `None` without a source for it; scans of clouds are not matched.
    pub fn add(&mut self, revolution: &Revolution, notes: &mut Notes) -> Option<Tracked> {
        if self.kind == PoseKind::None {
            return None;
        }
        let odometry = revolution.odometry.filter(is_finite_pose);
        if odometry.is_none() && revolution.odometry.is_some() {
            notes.add("pose: the odometry is not finite");
        }
        let motion = self.odometry.zip(odometry).map(|((before, there), now)| self.motion(there, before.inv_mul(&now)));
        let had_odometry = self.odometry.is_some() || odometry.is_some();
        let tracked = if self.kind == PoseKind::Odometry || revolution.as_sweep().is_none() {
            if !had_odometry {
                if self.kind != PoseKind::Auto {
                    notes.add("pose: no odometry yet");
                }
                return None;
            }
            if odometry.is_none() {
                notes.add("pose: no odometry at this time; the pose before");
            }
            Tracked { pose: motion.map_or(self.pose, |motion| self.pose * motion.step), lost: false }
        } else {
            let motion = motion.filter(|_| self.kind != PoseKind::ScanMatch);
            let is_expected = match self.kind {
                PoseKind::Auto => had_odometry,
                kind => kind == PoseKind::OdometryScanMatch,
            };
            let matched = self.matcher.add(revolution, motion);
            notes.extend(odd(&matched));
            if odometry.is_none() && is_expected {
                notes.add("pose: no odometry at this time; by the scan alone");
            }
            Tracked { pose: matched.pose, lost: matched.lost }
        };
        self.pose = tracked.pose;
        self.odometry = odometry.map(|odometry| (odometry, tracked.pose)).or(self.odometry);
        Some(tracked)
    }

    /// The motion since the revolution before, by a step of the odometry from the pose `there`.
    fn motion(&self, there: Isometry2<f64>, step: Isometry2<f64>) -> Motion {
        let (moved_m, turned_rad) = (step.translation.vector.norm(), step.rotation.angle().abs());
        let deviation_m = self.odometry_floor_m + self.odometry_share * moved_m;
        let deviation_rad = self.odometry_floor_m + self.odometry_share * turned_rad;
        let deviations = Vector3::new(deviation_m, deviation_m, deviation_rad);
        let covariance = Matrix3::from_diagonal(&deviations.component_mul(&deviations));
        let step = self.pose.inv_mul(&(there * step));
        // By its angle: a rotation that is multiplied by the inverse of its like is a unit ever less.
        Motion { step: Isometry2::new(step.translation.vector, step.rotation.angle()), covariance }
    }
}

/// What is odd about a match.
fn odd(matched: &Matched) -> Option<String> {
    if matched.lost {
        Some(format!(
            "pose: lost, as only {:.0} % of the walls match those before; the map begins here",
            100.0 * matched.matched
        ))
    } else if matched.surprise > SURPRISING {
        let times = matched.surprise;
        Some(format!("pose: a slip or a jump, {times:.0} standard deviations from the predicted motion"))
    } else {
        None
    }
}
