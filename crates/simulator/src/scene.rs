//! A scan with its truth, and flights as sequences of them.

use nalgebra::{Isometry2, Vector2};

use crosscut_messages::{
    Header, LaserScan, Odometry, Quaternion, TfMessage, Time, Transform, TransformStamped, Truth, TruthMap, Vector3,
};

use crate::lidar::{Echo, Lidar};
use crate::mine::Mine;
use crate::noise::{Generator, generator};
use crate::pose::{Motion, Pose};
use crate::reading::Reading;
use crate::survey::seen_from;
use crate::truth::Scenery;
use crate::vehicle::{OdometryState, Vehicle};

/// Stamp of the first scan of every recording. It is fixed, so that a seed gives the same bytes on any day.
pub(crate) const FIRST_STAMP_NS: u64 = 1_700_000_000_000_000_000;

/// One scan, its truth, and on a flight the odometry.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Time of the first beam, nanoseconds since the epoch.
    pub stamp_ns: u64,
    /// The scan.
    pub scan: LaserScan,
    /// The truth of the noise-free view.
    pub truth: Truth,
    /// Odometry at the first beam, if the scene belongs to a flight.
    pub odometry: Option<Odometry>,
    /// True pose at the first beam, if the scene belongs to a flight.
    pub pose: Option<Pose>,
    /// The map of the mine, with the first scene of a flight.
    pub map: Option<TruthMap>,
}

/// The noise-free view of one sweep.
pub(crate) struct View<'a> {
    pub(crate) lidar: &'a Lidar,
    is_moving: bool,
    echoes: Vec<Echo>,
    pub(crate) scenery: Scenery,
}

impl<'a> View<'a> {
    pub(crate) fn of(mine: &Mine, lidar: &'a Lidar, motion: &Motion) -> Self {
        let echoes = lidar.view(mine.surface(), mine.network().height_m, motion);
        let scenery = mine.scenery(lidar, motion, &echoes);
        Self { lidar, is_moving: motion.start != motion.end, echoes, scenery }
    }

    /// The scan, with errors drawn from `rng`, and its truth.
    pub(crate) fn scene(&self, mine: &Mine, stamp_ns: u64, rng: &mut Generator) -> Scene {
        let readings = self.lidar.read(mine.surface(), &self.echoes, rng);
        let scan = message(self.lidar, &readings, stamp_ns, self.is_moving);
        Scene { stamp_ns, scan, truth: self.scenery.truth(&readings), odometry: None, pose: None, map: None }
    }
}

impl Scene {
    /// A scan of which nothing else is known.
    pub fn of_scan(stamp_ns: u64, scan: LaserScan) -> Self {
        Self { stamp_ns, scan, truth: Truth::default(), odometry: None, pose: None, map: None }
    }

    /// The pose by the odometry, if there is any.
    pub fn odometry_pose(&self) -> Option<Isometry2<f64>> {
        let pose = self.odometry.as_ref()?.pose.pose;
        Some(Isometry2::new(Vector2::new(pose.position.x, pose.position.y), pose.orientation.yaw_rad()))
    }

    /// The scene at another time, apart from its flight.
    pub(crate) fn restamped(mut self, stamp_ns: u64) -> Self {
        (self.map, self.truth.pose, self.truth.here) = (None, None, None);
        self.stamp_ns = stamp_ns;
        self.scan.header.stamp = Time::from_ns(stamp_ns);
        if let Some(odometry) = &mut self.odometry {
            odometry.header.stamp = Time::from_ns(stamp_ns);
        }
        self
    }

    /// The transforms of the odometry: the vehicle in the odometry's frame, and the lidar on the vehicle.
    pub fn transforms(&self) -> Option<TfMessage> {
        let odometry = self.odometry.as_ref()?;
        let pose = odometry.pose.pose;
        let vehicle = TransformStamped {
            header: odometry.header.clone(),
            child_frame_id: odometry.child_frame_id.clone(),
            transform: Transform { translation: pose.position, rotation: pose.orientation },
        };
        let lidar = TransformStamped {
            header: Header { stamp: odometry.header.stamp, frame_id: odometry.child_frame_id.clone() },
            child_frame_id: self.scan.header.frame_id.clone(),
            transform: Transform::default(),
        };
        Some(TfMessage { transforms: vec![vehicle, lidar] })
    }
}

pub(crate) fn message(lidar: &Lidar, readings: &[Reading], stamp_ns: u64, is_moving: bool) -> LaserScan {
    let beam_s = lidar.step_rad() / std::f64::consts::TAU * lidar.sweep_s;
    LaserScan {
        header: Header { stamp: Time::from_ns(stamp_ns), frame_id: "laser".into() },
        angle_min: lidar.bearing_rad(0.0) as f32,
        angle_max: lidar.bearing_rad((lidar.beams - 1) as f64) as f32,
        angle_increment: lidar.step_rad() as f32,
        time_increment: if is_moving { beam_s as f32 } else { 0.0 },
        scan_time: lidar.sweep_s as f32,
        range_min: lidar.range_min_m as f32,
        range_max: lidar.range_max_m as f32,
        ranges: readings
            .iter()
            .map(|reading| match *reading {
                Reading::Nothing => f32::INFINITY,
                Reading::Echo(range_m) | Reading::Dust(range_m) | Reading::Mixed(range_m) => range_m as f32,
            })
            .collect(),
        intensities: Vec::new(),
    }
}

/// A flight: an iterator over the scenes along a route.
#[derive(Clone, Debug)]
pub struct Flight {
    mine: Mine,
    lidar: Lidar,
    vehicle: Vehicle,
    stamp_ns: u64,
    rng: Generator,
    /// The pose of the first scene.
    origin: Option<Pose>,
    has_odometry: bool,
}

impl Flight {
    /// A flight of `vehicle` through `mine`, with errors of the lidar drawn from `seed`.
    pub fn new(mine: Mine, lidar: Lidar, vehicle: Vehicle, seed: u64) -> Self {
        let rng = generator(seed, "lidar");
        Self { mine, lidar, vehicle, stamp_ns: FIRST_STAMP_NS, rng, origin: None, has_odometry: true }
    }

    /// This flight with odometry that drifts by this share of the way: the way is longer or shorter by it, and the
    /// heading drifts by a tenth of it in rad per metre. Seeds draw the side and the sign. Other errors stay.
    #[must_use]
    pub fn with_drift(mut self, share: f64, seed: u64) -> Self {
        self.vehicle.set_drift(share, seed);
        self
    }

    /// This flight without odometry.
    #[must_use]
    pub fn without_odometry(mut self) -> Self {
        self.has_odometry = false;
        self
    }

    /// The mine that the flight is in.
    pub fn mine(&self) -> &Mine {
        &self.mine
    }
}

impl Iterator for Flight {
    type Item = Scene;

    fn next(&mut self) -> Option<Scene> {
        let (motion, state) = self.vehicle.next()?;
        let view = View::of(&self.mine, &self.lidar, &motion);
        let mut scene = view.scene(&self.mine, self.stamp_ns, &mut self.rng);
        scene.odometry = self.has_odometry.then(|| odometry(&state, self.stamp_ns));
        scene.pose = Some(motion.start);
        let network = self.mine.network();
        if self.origin.is_none() {
            scene.map = Some(network.map(&motion.start));
        }
        let origin = self.origin.get_or_insert(motion.start);
        scene.truth.pose = Some(seen_from(origin, motion.start.position_m, motion.start.heading_rad));
        scene.truth.here = network.place_at(&motion.start.position_m);
        self.stamp_ns += (self.lidar.sweep_s * 1e9).round() as u64;
        Some(scene)
    }
}

pub(crate) fn odometry(state: &OdometryState, stamp_ns: u64) -> Odometry {
    let mut message = Odometry {
        header: Header { stamp: Time::from_ns(stamp_ns), frame_id: "odom".into() },
        child_frame_id: "base_link".into(),
        ..Odometry::default()
    };
    message.pose.pose.position = Vector3 { x: state.position_m.x, y: state.position_m.y, z: 0.0 };
    message.pose.pose.orientation = Quaternion::from_yaw_rad(state.heading_rad);
    message.twist.twist.linear = Vector3 { x: state.velocity_m_s.x, y: state.velocity_m_s.y, z: 0.0 };
    message.twist.twist.angular = Vector3 { x: 0.0, y: 0.0, z: state.turn_rate_rad_s };
    message
}
