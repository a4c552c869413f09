//! One point cloud to one revolution.

use crosscut_messages::Cloud;
use crosscut_scan::LevelView;
use crosscut_stage::NoteCode::{N001, N008, N010, N027, N030, N031, N032, N062, N063, N104, N105};
use crosscut_stage::{Beam, Notes, Point, Revolution, Sweep, counted};
use nalgebra::{Isometry2, Point2, UnitQuaternion, Vector3};

use crate::{Motion, Sensor};

/// A vehicle that moves by less than this during a scan, m, and turns by less than the angle below, is taken to stand.
const LEAST_WAY_M: f64 = 0.05;
/// See [`LEAST_WAY_M`], rad. What is tilted by less is level.
const LEAST_TURN_RAD: f64 = 0.01;
/// A cloud that shows the vehicle fewer returns is looked at for their heights.
const LEAST_RETURNS: usize = 8;
/// A sweep of more beams is levelled like a cloud: its neighbouring returns are closer than a range is exact.
const MOST_BEAMS: usize = 4096;

impl Sensor {
    /// Writes what a level vehicle sees of `cloud` into `out` ([`LevelView`]), and what was turned or left out into
    /// `notes`, whatever both held before. Points that are not finite are no entries, and neither are those at the sensor
    /// itself, by which many drivers say that nothing came back.
    ///
    /// `out.seq` is 0: only the recording knows it. `out.stamp_ns` is 0 if the cloud has no stamp.
    pub fn cloud(&self, cloud: &Cloud, out: &mut Revolution, notes: &mut Notes) {
        notes.clear();
        self.moving_cloud(cloud, None, out, notes);
        self.level(out, notes);
    }

    /// Makes of points without beams, or of a sweep of very many beams, the revolution that a level vehicle sees.
    pub fn level(&self, out: &mut Revolution, notes: &mut Notes) {
        self.level_in(&mut LevelView::default(), out, notes);
    }

    /// As [`Sensor::level`], in buffers that are kept.
    pub(crate) fn level_in(&self, view: &mut LevelView, out: &mut Revolution, notes: &mut Notes) {
        let beams = out.beams().map(Sweep::len);
        if beams.is_some_and(|beams| beams <= MOST_BEAMS) {
            return;
        }
        let heights_m = out.points_m.iter().map(|point_m| point_m.z);
        let [low_m, high_m] = heights_m.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], z| [a.min(z), b.max(z)]);
        let aside = view.level(out, self.vehicle_height_m, self.vehicle_width_m);
        if self.keeps_cloud && beams.is_none() {
            // As exact as points are on the wire, and as recordings hold them.
            let rounded = |x: f64| f64::from((x as f32).clamp(f32::MIN, f32::MAX));
            out.cloud_m.extend(view.points_m().iter().map(|point_m| point_m.map(rounded)));
        }
        let tilt = out.cloud_tilt;
        let seen = out.sweep.get_or_insert_default();
        if beams.is_none() && tilt != UnitQuaternion::default() {
            hide_unseen(seen, &tilt, view.points_m());
        }
        let [first_rad, step_rad, ..] = &mut seen.wire_geometry;
        *first_rad = self.own_angle_rad(f64::from(*first_rad) - self.yaw_rad) as f32;
        *step_rad = self.own_angle_rad(seen.step_rad) as f32;
        if let Some(beams) = beams {
            notes.add(N062, format!("sweep of {beams} beams processed as a cloud of {} beams", seen.len()));
        }
        if aside > 0 {
            let aside = counted(aside as u64, "return");
            let half_m = 0.5 * self.vehicle_height_m;
            let heights = if out.len() < LEAST_RETURNS && (low_m > half_m || high_m < -half_m) {
                format!(
                    ": they are {low_m:.2} to {high_m:.2} m high, and the vehicle takes {:.2} to {half_m:.2} m, by \
                     vehicle.height_m",
                    -half_m
                )
            } else {
                String::new()
            };
            let ignored = if out.cloud_m.is_empty() { "ignored" } else { "not in the level view" };
            notes.add(N063, format!("{aside} above or below the vehicle, or within it, {ignored}{heights}"));
        }
    }

    /// Writes the points of `cloud` into `out`, without beams, in the frame of the vehicle, turned level by `motion`. If they have
    /// times and the vehicle moved meanwhile, they are in its frame in the middle of the scan.
    pub(crate) fn moving_cloud(&self, cloud: &Cloud, motion: Option<&Motion>, out: &mut Revolution, notes: &mut Notes) {
        out.clear();
        out.stamp_ns = cloud.header.stamp.to_ns().unwrap_or(0);
        out.frame_id.push_str(&cloud.header.frame_id);
        // Poses of the sensor itself have its mount in them.
        let is_mounted = !(self.is_mount_stated && motion.is_some_and(|motion| motion.is_of_sensor));
        let (yaw_rad, upside_down) = if is_mounted { (self.yaw_rad, self.upside_down) } else { (0.0, false) };
        if is_mounted {
            self.note_mounting(notes);
        }
        let (sin, cos) = yaw_rad.sin_cos();
        let (mut at_sensor, mut near, mut far, mut masked, mut of_other_rings) = (0, 0, 0, 0, 0);
        let slices = !self.rings.is_empty() && !cloud.rings.is_empty();
        if !self.rings.is_empty() && cloud.rings.is_empty() {
            notes.add(N030, "the cloud does not state rings: ingest.rings takes all points");
        }
        let of_vehicle = motion.and_then(Motion::tilt);
        let (mount, vehicle) = (self.tilt.filter(|_| is_mounted).and_then(tilted), of_vehicle.and_then(tilted));
        let by_mount = ("sensor", "on its vehicle, by /tf_static; ingest.mount_from_tf = false turns this off");
        for (tilt, (what, by)) in [(mount, by_mount), (vehicle, ("vehicle", "by its odometry"))] {
            notes.extend(tilt.map(|tilt| {
                let tilt_deg = tilt.transform_vector(&Vector3::z()).angle(&Vector3::z()).to_degrees();
                (N104, format!("cloud turned level: the {what} is tilted by {tilt_deg:.1}° {by}"))
            }));
        }
        out.cloud_tilt = vehicle.unwrap_or_default() * mount.unwrap_or_default();
        if self.keeps_cloud && of_vehicle.is_none() {
            notes.add(N105, "no odometry tells how the vehicle is tilted: taken to be level");
        }
        if is_mounted && self.tilt.is_none() {
            notes.add(N105, "the quaternion by which /tf_static mounts the sensor is no rotation: taken to be level");
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
            let [y, z] = if upside_down { [-y, -z] } else { [y, z] };
            let point_m = turned(mount, Point::new(x * cos - y * sin, x * sin + y * cos, z));
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
                let point_m = turned(vehicle, point_m);
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

/// Makes the beams unknown at which a tilted lidar does not look: their elevation about its axis is none of those of the points.
fn hide_unseen(sweep: &mut Sweep, tilt: &UnitQuaternion<f64>, points_m: &[Point]) {
    let rise = |towards: &Vector3<f64>| tilt.inverse_transform_vector(towards).z / towards.norm();
    let rises = points_m.iter().map(|point_m| rise(&point_m.coords));
    let [low, high] = rises.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], rise| [a.min(rise), b.max(rise)]);
    for (beam, bearing_rad) in sweep.beams.iter_mut().zip(&sweep.bearings_rad) {
        let is_in_view = (low..=high).contains(&rise(&Vector3::new(bearing_rad.cos(), bearing_rad.sin(), 0.0)));
        if *beam == Beam::NoReturn && !is_in_view {
            *beam = Beam::Unknown;
        }
    }
}

/// The tilt, if it makes a difference.
fn tilted(tilt: UnitQuaternion<f64>) -> Option<UnitQuaternion<f64>> {
    (tilt.angle() >= LEAST_TURN_RAD).then_some(tilt)
}

fn turned(tilt: Option<UnitQuaternion<f64>>, point_m: Point) -> Point {
    tilt.map_or(point_m, |tilt| tilt * point_m)
}

/// The point as seen from `pose`, at its own height.
fn in_plane(pose: Isometry2<f64>, point_m: Point) -> Point {
    let moved_m = pose * Point2::new(point_m.x, point_m.y);
    Point::new(moved_m.x, moved_m.y, point_m.z)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::VehiclePose;

    #[test]
    fn points_of_a_cloud_with_times_lie_where_the_middle_of_it_sees_them() {
        let (speed_m_s, rate_rad_s, scan_s) = (3.0, 1.5, 0.1);
        let pose = |time_s: f64| Isometry2::new(Vector2::new(speed_m_s * time_s, 0.0), rate_rad_s * time_s);
        let place = |i: usize| Point2::new(4.0 + 0.01 * i as f64, 2.0 - 0.03 * i as f64);
        let times_s: Vec<_> = (0..200).map(|i| scan_s * f64::from(i) / 199.0).collect();
        let seen_m = |(i, time_s): (usize, &f64)| {
            let seen_m = pose(*time_s).inverse_transform_point(&place(i));
            [seen_m.x, seen_m.y, 0.5]
        };
        let points_m = times_s.iter().enumerate().map(seen_m).collect();
        let mut cloud = Cloud { points_m, times_s, ..Cloud::default() };
        let level = |time_s| VehiclePose { plane: pose(time_s), tilt: Some(UnitQuaternion::default()) };
        let motion = Motion { times_s: [0.0, scan_s], poses: [0.0, scan_s].map(level), is_of_sensor: false };
        let farthest_m = |cloud: &Cloud| {
            let (mut out, mut notes) = (Revolution::default(), Notes::default());
            Sensor::default().moving_cloud(cloud, Some(&motion), &mut out, &mut notes);
            assert!(notes.iter().any(|note| note.starts_with("turned by 8.6° and moved by 0.30 m")), "{notes:?}");
            let off_m = |(i, point_m): (usize, &Point)| {
                assert_eq!(point_m.z, 0.5);
                (pose(0.5 * scan_s).inverse_transform_point(&place(i)) - point_m.xy()).norm()
            };
            out.points_m.iter().enumerate().map(off_m).fold(0.0, f64::max)
        };
        assert!(farthest_m(&cloud) < 0.005);
        cloud.times_s.clear();
        assert!(farthest_m(&cloud) > 0.2, "points without times stay where they were seen");
    }
}
