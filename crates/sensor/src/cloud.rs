//! One point cloud to one revolution.

use crosscut_messages::Cloud;
use crosscut_stage::NoteCode::{N001, N008, N010, N027, N030, N031, N032};
use crosscut_stage::{Notes, Point, Revolution, counted};
use nalgebra::{Isometry2, Point2};

use crate::{Motion, Sensor};

/// A vehicle that moves by less than this during a scan, m, and turns by less than the angle below, is taken to stand.
const LEAST_WAY_M: f64 = 0.05;
/// See [`LEAST_WAY_M`], rad.
const LEAST_TURN_RAD: f64 = 0.01;

impl Sensor {
    /// Writes the returns of `cloud` into `out`, and what was turned or left out into `notes`, whatever both held before;
    /// there are no beams. Points that are not finite are no returns, and neither are those at the sensor itself, by which
    /// many drivers say that nothing came back.
    ///
    /// `out.seq` is 0: only the recording knows it. `out.stamp_ns` is 0 if the cloud has no stamp.
    pub fn cloud(&self, cloud: &Cloud, out: &mut Revolution, notes: &mut Notes) {
        notes.clear();
        self.moving_cloud(cloud, None, out, notes);
    }

    /// Writes the returns of `cloud` into `out`, as [`Sensor::cloud`] does. If they have times and the vehicle moved as
    /// `motion` says, in its frame in the middle of the scan.
    pub(crate) fn moving_cloud(&self, cloud: &Cloud, motion: Option<&Motion>, out: &mut Revolution, notes: &mut Notes) {
        out.clear();
        out.stamp_ns = cloud.header.stamp.to_ns().unwrap_or(0);
        out.frame_id.push_str(&cloud.header.frame_id);
        self.note_mounting(notes);
        let (sin, cos) = self.yaw_rad.sin_cos();
        let (mut at_sensor, mut near, mut far, mut masked, mut of_other_rings) = (0, 0, 0, 0, 0);
        let slices = !self.rings.is_empty() && !cloud.rings.is_empty();
        if !self.rings.is_empty() && cloud.rings.is_empty() {
            notes.add(N030, "the cloud does not state rings: ingest.rings takes all points");
        }
        let motion =
            motion.filter(|motion| motion.way_m() >= LEAST_WAY_M || motion.turned_rad().abs() >= LEAST_TURN_RAD);
        if let Some(motion) = motion {
            let (turned_deg, way_m) = (motion.turned_rad().to_degrees(), motion.way_m());
            notes.add(N027, format!(
                "turned by {turned_deg:.1}° and moved by {way_m:.2} m during the scan: points brought to the middle of it"
            ));
        }
        for (i, &[x, y, z]) in cloud.points_m.iter().enumerate() {
            if slices && cloud.rings.get(i).is_none_or(|ring| !self.takes_ring(*ring)) {
                of_other_rings += 1;
                continue;
            }
            let [x, y, z] = [x, y, z].map(|coordinate| coordinate * self.range_scale);
            let [y, z] = if self.upside_down { [-y, -z] } else { [y, z] };
            let point_m = Point::new(x * cos - y * sin, x * sin + y * cos, z);
            let range_m = point_m.coords.norm();
            if !range_m.is_finite() {
            } else if range_m == 0.0 {
                at_sensor += 1;
            } else if range_m < self.min_range_m {
                near += 1;
            } else if range_m > self.max_range_m {
                far += 1;
            } else if self.masks(point_m.y.atan2(point_m.x)) {
                masked += 1;
            } else {
                let time_s = cloud.times_s.get(i).filter(|time_s| time_s.is_finite());
                out.points_m.push(match motion.zip(time_s) {
                    Some((motion, &time_s)) => in_plane(motion.in_middle(time_s), point_m),
                    None => point_m,
                });
            }
        }
        let mut note = |code, count: u64, what: &str| {
            if count > 0 {
                notes.add(code, format!("{} {what}", counted(count, "point")));
            }
        };
        note(N031, at_sensor, "at the sensor itself read as no return");
        note(N008, near, &format!("nearer than min_range_m {} m left out", self.min_range_m));
        note(N010, far, &format!("beyond max_range_m {} m read as no return", self.max_range_m));
        note(N001, masked, "in masked sectors left out");
        note(N032, of_other_rings, "of other rings than ingest.rings left out");
    }
}

/// The point as seen from `pose`, at its own height.
fn in_plane(pose: Isometry2<f64>, point_m: Point) -> Point {
    let moved_m = pose * Point2::new(point_m.x, point_m.y);
    Point::new(moved_m.x, moved_m.y, point_m.z)
}
