//! One laser scan to one revolution: mounting, clean-up, and the rules for odd values.

use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

use crosscut_messages::{Echo, LaserScan};
use crosscut_scan::{VEHICLE_HEIGHT_M, VEHICLE_PARAMS, VEHICLE_WIDTH_M};
use crosscut_stage::NoteCode::{N021, N022, N025, N026, N027};
use crosscut_stage::{Beam, Flag, Notes, Number, Pairs, ParamSpec, Params, Point, Revolution, Word, counted};

use nalgebra::UnitQuaternion;

use crate::directions::BeamDirections;
use crate::fan::ScanFan;
use crate::limits::{RangeLimits, Reading, Tally};

/// How the sensor is turned.
pub const YAW_RAD: Number = Number::new("yaw_rad", "rad", 0.0)
    .from(-PI)
    .to(PI)
    .doc("direction of the sensor's zero bearing in the body frame, anticlockwise");

/// Whether the sensor is turned over.
pub const UPSIDE_DOWN: Flag =
    Flag::new("upside_down", false).doc("the sensor hangs upside down, so that its bearings run the other way");

/// The nearest return that is taken.
pub const MIN_RANGE_M: Number = Number::new("min_range_m", "m", 0.0)
    .from(0.0)
    .to(1e6)
    .doc("returns nearer than this are left out (parts of the vehicle); their direction is unknown");

/// The farthest return that is taken.
pub const MAX_RANGE_M: Number = Number::new("max_range_m", "m", f64::INFINITY)
    .above(0.0)
    .to(f64::INFINITY)
    .doc("returns farther than this are read as no return; above min_range_m");

const RANGE_SCALE: Number = Number::new("range_scale", "", 1.0)
    .above(0.0)
    .to(1e6)
    .doc("metres in the unit of the ranges and points of messages: 0.001 for a driver that sends millimetres");

const MASKED_SECTORS_RAD: Pairs = Pairs::new("masked_sectors_rad", "rad")
    .from(-PI)
    .to(PI)
    .doc("bearings in the body frame whose beams are ignored, anticlockwise from..to; from > to crosses ±π");

const RINGS: Pairs = Pairs::new("rings", "")
    .from(0.0)
    .to(65_535.0)
    .doc("rings of a cloud that are taken, each from..to, such as [[7,8]]; empty takes all");

const FIND_BLIND_SECTORS: Flag = Flag::new("find_blind_sectors", true)
    .doc("beams that never return anything in the first scans, as where the driver leaves a sector out, are unknown");

const DESKEW: Flag = Flag::new("deskew", true)
    .doc("beams of a sensor that turns with its vehicle, and points of a cloud with times, are brought to the middle of the scan");

const MOUNT_FROM_TF: Flag = Flag::new("mount_from_tf", true)
    .doc("of a recording with one sensor, how /tf_static mounts it counts where yaw_rad and upside_down are not set");

const FRAME_ID: Word = Word::any("frame_id", "")
    .doc("take only scans of this frame_id, where several sensors share a topic; empty takes all");

const ECHO: Word = Word::one_of("echo", &["first", "last", "strongest"])
    .doc("of several echoes of a beam (MultiEchoLaserScan), the one that is its range");

const ODOMETRY: Word = Word::any("odometry", "").doc(
    "topic of the vehicle's odometry; empty takes /odom, another topic of nav_msgs/Odometry, or the frame odom of /tf",
);

/// The `ingest` section of the configuration.
pub const PARAMS: &[ParamSpec] = &[
    YAW_RAD.spec,
    UPSIDE_DOWN.spec,
    MIN_RANGE_M.spec,
    MAX_RANGE_M.spec,
    MASKED_SECTORS_RAD.spec,
    RINGS.spec,
    FIND_BLIND_SECTORS.spec,
    DESKEW.spec,
    MOUNT_FROM_TF.spec,
    FRAME_ID.spec,
    ECHO.spec,
    ODOMETRY.spec,
    RANGE_SCALE.spec,
];

/// Bearings of f32 angles are known to within this: the beam at f32 -π is the one at π.
const ROUNDING_RAD: f64 = 1e-6;

/// A lidar as it is mounted, with what is to be cleaned up.
///
/// ```
/// use crosscut_sensor::Sensor;
/// use crosscut_messages::LaserScan;
/// use crosscut_stage::{Notes, Revolution};
///
/// let sensor = Sensor::default();
/// let scan = LaserScan {
///     angle_max: 0.2,
///     angle_increment: 0.1,
///     range_max: 30.0,
///     ranges: vec![4.0, 30.0, f32::NAN],
///     ..LaserScan::default()
/// };
/// let (mut revolution, mut notes) = (Revolution::default(), Notes::default());
/// sensor.revolution(&scan, &mut revolution, &mut notes);
/// assert_eq!(revolution.len(), 1);
/// assert_eq!(notes.iter().next(), Some("1 beam at or beyond range_max 30 m read as no return"));
/// ```
#[derive(Clone, Debug)]
pub struct Sensor {
    pub(crate) yaw_rad: f64,
    pub(crate) upside_down: bool,
    /// How it is turned besides, after the yaw: the roll and pitch of its mount, which clouds have.
    pub(crate) tilt: Option<UnitQuaternion<f64>>,
    pub(crate) min_range_m: f64,
    pub(crate) max_range_m: f64,
    masked_sectors_rad: Vec<[f64; 2]>,
    pub(crate) rings: Vec<[f64; 2]>,
    frame_id: String,
    odometry_topic: String,
    echo: Echo,
    finds_blind_sectors: bool,
    deskews: bool,
    takes_mount: bool,
    /// The transform that the recording states gives the mount.
    pub(crate) is_mount_stated: bool,
    pub(crate) range_scale: f64,
    pub(crate) vehicle_width_m: f64,
    pub(crate) vehicle_height_m: f64,
    pub(crate) keeps_cloud: bool,
}

/// Mounted upright, looking ahead, with nothing left out.
impl Default for Sensor {
    fn default() -> Self {
        Self::new(&Params::defaults(PARAMS), &Params::defaults(VEHICLE_PARAMS))
    }
}

/// Brings the ranges of a scan to metres. Its limits are in the unit of its ranges, unless most of these lie beyond them.
pub fn rescale(scan: &mut LaserScan, metres: f64) {
    if metres == 1.0 {
        return;
    }
    let limit = scan.range_max;
    let are_ranges = || scan.ranges.iter().filter(|range| range.is_finite() && **range > 0.0);
    let are_limits_in_metres = 2 * are_ranges().filter(|range| **range > limit).count() > are_ranges().count();
    let limits = [&mut scan.range_min, &mut scan.range_max].into_iter().filter(|_| !are_limits_in_metres);
    limits.chain(&mut scan.ranges).for_each(|range| *range = (f64::from(*range) * metres) as f32);
}

impl Sensor {
    /// From checked values of [`PARAMS`] and [`VEHICLE_PARAMS`]: the size of the vehicle decides what is seen of a cloud.
    pub fn new(params: &Params, vehicle: &Params) -> Self {
        Self {
            yaw_rad: params.get(YAW_RAD),
            upside_down: params.get(UPSIDE_DOWN),
            tilt: Some(UnitQuaternion::default()),
            min_range_m: params.get(MIN_RANGE_M),
            max_range_m: params.get(MAX_RANGE_M),
            masked_sectors_rad: params.get(MASKED_SECTORS_RAD),
            rings: params.get(RINGS),
            finds_blind_sectors: params.get(FIND_BLIND_SECTORS),
            deskews: params.get(DESKEW),
            takes_mount: params.get(MOUNT_FROM_TF),
            is_mount_stated: false,
            range_scale: params.get(RANGE_SCALE),
            frame_id: params.get(FRAME_ID),
            odometry_topic: params.get(ODOMETRY),
            echo: match params.get(ECHO).as_str() {
                "last" => Echo::Last,
                "strongest" => Echo::Strongest,
                _ => Echo::First,
            },
            vehicle_width_m: vehicle.get(VEHICLE_WIDTH_M),
            vehicle_height_m: vehicle.get(VEHICLE_HEIGHT_M),
            keeps_cloud: false,
        }
    }

    /// A scan whose ranges are in metres.
    pub(crate) fn in_metres<'a>(&self, scan: &'a LaserScan) -> Cow<'a, LaserScan> {
        let mut scan = Cow::Borrowed(scan);
        if self.range_scale != 1.0 {
            rescale(scan.to_mut(), self.range_scale);
        }
        scan
    }

    /// Whether sectors that never return anything are looked for in the first scans of a recording.
    pub fn finds_blind_sectors(&self) -> bool {
        self.finds_blind_sectors
    }

    /// Whether the mount that a recording states is to be taken: none is set.
    pub fn takes_mount(&self) -> bool {
        self.takes_mount && self.yaw_rad == 0.0 && !self.upside_down
    }

    /// This sensor, mounted as a recording states: in the frame of the vehicle it is turned over if it hangs upside down, then
    /// by its yaw, then tilted, which clouds alone follow; `None` if the recording states no rotation.
    pub fn mounted(self, yaw_rad: f64, upside_down: bool, tilt: Option<UnitQuaternion<f64>>) -> Self {
        Self { yaw_rad, upside_down, tilt, is_mount_stated: true, ..self }
    }

    /// This sensor, whose revolutions keep all points of a cloud if `keeps` says so.
    #[must_use]
    pub fn keeping_cloud(self, keeps: bool) -> Self {
        Self { keeps_cloud: keeps, ..self }
    }

    /// Whether the turning of the vehicle during a scan is taken into account.
    pub fn deskews(&self) -> bool {
        self.deskews
    }

    /// Of several echoes of a beam, the one that is its range.
    pub fn echo(&self) -> Echo {
        self.echo
    }

    /// The only `frame_id` that is asked for, if any.
    pub fn frame_id(&self) -> Option<&str> {
        (!self.frame_id.is_empty()).then_some(self.frame_id.as_str())
    }

    /// The topic of odometry that is asked for; empty if none is.
    pub fn odometry_topic(&self) -> &str {
        &self.odometry_topic
    }

    /// Writes the revolution that `scan` shows into `out`, and what was turned, left out or repaired into `notes`, whatever
    /// both held before. The rules are in the documentation of this crate.
    ///
    /// `out.seq` is 0: only the recording knows it. `out.stamp_ns` is 0 if the scan has no stamp.
    pub fn revolution(&self, scan: &LaserScan, out: &mut Revolution, notes: &mut Notes) {
        notes.clear();
        self.turning_revolution(&self.in_metres(scan), 0.0, &mut BeamDirections::default(), out, notes);
        self.level(out, notes);
    }

    /// Writes the revolution that `scan`, in metres, shows into `out`, as [`Sensor::revolution`] does, of a sensor that turns by
    /// `rad_per_beam` from one beam to the next, anticlockwise as its own bearings: in the
    /// frame of its middle beam. `directions` are those of the scan before.
    pub(crate) fn turning_revolution(
        &self,
        scan: &LaserScan,
        rad_per_beam: f64,
        directions: &mut BeamDirections,
        out: &mut Revolution,
        notes: &mut Notes,
    ) {
        out.clear();
        out.stamp_ns = scan.header.stamp.to_ns().unwrap_or(0);
        out.frame_id.push_str(&scan.header.frame_id);
        let sweep = out.sweep.get_or_insert_default();
        sweep.ranges_m.extend_from_slice(&scan.ranges);
        sweep.wire_geometry = [scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max];
        self.note_mounting(notes);
        if !scan.intensities.is_empty() && scan.intensities.len() != scan.ranges.len() {
            notes.add(
                N021,
                format!("{} intensities for {} ranges: not used", scan.intensities.len(), scan.ranges.len()),
            );
        }
        let limits = RangeLimits::new(scan, self.min_range_m, self.max_range_m, notes);
        sweep.range_max_m = limits.range_max_m();

        let Some(fan) = ScanFan::new(scan, notes) else {
            sweep.bearings_rad.resize(scan.ranges.len(), 0.0);
            sweep.beams.resize(scan.ranges.len(), Beam::Unknown);
            sweep.step_rad = TAU;
            return;
        };
        let fan = fan.turned(rad_per_beam, scan.ranges.len());
        if rad_per_beam != 0.0 {
            let turned_deg = self.own_angle_rad(rad_per_beam * scan.ranges.len() as f64).to_degrees();
            notes.add(N027, format!("turned by {turned_deg:.1}° during the scan: beams brought to the middle of it"));
        }
        sweep.step_rad = fan.step_rad();
        let mounted = fan.mounted(self.yaw_rad, self.upside_down);
        sweep.fan = Some(mounted);
        let missing = fan.missing();
        (sweep.full_turn, sweep.missing) = (missing.is_some(), missing.unwrap_or(0));
        if sweep.missing > 0 {
            let beams = counted(sweep.missing as u64, "beam");
            notes.add(N022, format!("{beams} short of a full turn: walls are followed across"));
        }
        let mut tally = Tally::default();
        directions.update(mounted, scan.ranges.len(), |bearing_rad| self.masks(bearing_rad));
        sweep.bearings_rad.extend_from_slice(&directions.bearings_rad);
        for (&range_m, direction) in scan.ranges.iter().zip(&directions.beams).take(fan.beams_in_turn()) {
            let reading = if direction.is_masked {
                tally.masked += 1;
                Reading::Unknown
            } else {
                limits.read(range_m, &mut tally)
            };
            sweep.beams.push(match reading {
                Reading::Return(range_m) => {
                    out.points_m.push(Point::new(range_m * direction.cos, range_m * direction.sin, 0.0));
                    Beam::Return(out.points_m.len() as u32 - 1)
                }
                Reading::Nothing => Beam::NoReturn,
                Reading::Unknown => Beam::Unknown,
            });
        }
        limits.note(&tally, notes);
    }

    /// An angle that the vehicle turned, as the sensor's own bearings count it.
    pub(crate) fn own_angle_rad(&self, angle_rad: f64) -> f64 {
        if self.upside_down { -angle_rad } else { angle_rad }
    }

    /// A place in the body frame, in the frame of the sensor, if it is mounted level.
    pub fn in_sensor_frame(&self, point_m: Point) -> Point {
        let (sin, cos) = self.yaw_rad.sin_cos();
        let (x, y) = (point_m.x * cos + point_m.y * sin, point_m.y * cos - point_m.x * sin);
        if self.upside_down { Point::new(x, -y, -point_m.z) } else { Point::new(x, y, point_m.z) }
    }

    pub(crate) fn takes_ring(&self, ring: u32) -> bool {
        self.rings.iter().any(|&[from, to]| (from..=to).contains(&f64::from(ring)))
    }

    pub(crate) fn masks(&self, bearing_rad: f64) -> bool {
        self.masked_sectors_rad.iter().any(|&[from, to]| {
            let span_rad = if from <= to { to - from } else { to - from + TAU };
            (bearing_rad - from + ROUNDING_RAD).rem_euclid(TAU) <= span_rad + 2.0 * ROUNDING_RAD
        })
    }

    pub(crate) fn note_mounting(&self, notes: &mut Notes) {
        let by = if self.is_mount_stated { ", by /tf_static; ingest.mount_from_tf = false turns this off" } else { "" };
        if self.upside_down {
            notes.add(N025, format!("bearings mirrored: the sensor is mounted upside down{by}"));
        }
        if self.yaw_rad != 0.0 {
            notes.add(N026, format!("bearings turned by the sensor's yaw of {} rad{by}", self.yaw_rad));
        }
    }
}
