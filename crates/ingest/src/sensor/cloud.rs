//! One point cloud to one revolution.

use crosscut_messages::Cloud;
use crosscut_stage::{Notes, Point, Revolution, counted};

use super::Sensor;

impl Sensor {
    /// Writes the returns of `cloud` into `out`, whatever `out` held before; there are no beams. Points that are not
    /// finite are no returns, and neither are those at the sensor itself, by which many drivers say that nothing came
    /// back. `notes` has what was turned or left out.
    ///
    /// `out.seq` is 0: only the recording knows it. `out.stamp_ns` is 0 if the cloud has no stamp.
    pub fn cloud(&self, cloud: &Cloud, out: &mut Revolution, notes: &mut Notes) {
        out.clear();
        out.stamp_ns = cloud.header.stamp.to_ns().unwrap_or(0);
        out.frame_id.push_str(&cloud.header.frame_id);
        self.note_mounting(notes);
        let (sin, cos) = self.yaw_rad.sin_cos();
        let (mut at_sensor, mut near, mut far, mut masked, mut of_other_rings) = (0, 0, 0, 0, 0);
        let slices = !self.rings.is_empty() && !cloud.rings.is_empty();
        if !self.rings.is_empty() && cloud.rings.is_empty() {
            notes.add("the cloud does not state rings: ingest.rings takes all points");
        }
        for (i, &[x, y, z]) in cloud.points_m.iter().enumerate() {
            if slices && cloud.rings.get(i).is_none_or(|ring| !self.takes_ring(*ring)) {
                of_other_rings += 1;
                continue;
            }
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
                out.points_m.push(point_m);
            }
        }
        let mut note = |count: u64, what: &str| {
            if count > 0 {
                notes.add(format!("{} {what}", counted(count, "point")));
            }
        };
        note(at_sensor, "at the sensor itself read as no return");
        note(near, &format!("nearer than min_range_m {} m left out", self.min_range_m));
        note(far, &format!("beyond max_range_m {} m read as no return", self.max_range_m));
        note(masked, "in masked sectors left out");
        note(of_other_rings, "of other rings than ingest.rings left out");
    }
}
