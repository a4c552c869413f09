//! How the fixed transforms of a recording mount a single sensor on its vehicle.

use std::f64::consts::PI;

use crosscut_sensor::Sensor;
use nalgebra::{UnitQuaternion, Vector3};

use super::frames::Frames;
use crate::CsvGeometry;
use crate::container::{self, Container};

/// Frames that the vehicle moves in.
const WORLD: [&str; 3] = ["map", "odom", "world"];

/// The plane of a sensor that is mounted level is tilted by less than this, rad.
const LEVEL_RAD: f64 = 0.5;

/// A turn below this makes no difference, rad.
const LEAST_TURN_RAD: f64 = 0.01;

/// The fixed transforms, until the frame of the sensor is known.
pub(crate) struct Mount(Frames);

impl Mount {
    /// Of the files of `containers`, which are opened a second time; `None` if the mount of the sensor is set.
    pub(crate) fn read(containers: &[Box<dyn Container>], csv: &CsvGeometry, sensor: &Sensor) -> Option<Self> {
        if !sensor.takes_mount() {
            return None;
        }
        let is_stream = containers.iter().any(|container| container.again().is_some());
        let reopened = containers.iter().filter_map(|container| container::reopen(&**container, csv).ok());
        Some(Self(Frames::read_static(reopened.collect(), is_stream)))
    }

    /// Yaw in rad of a sensor with this frame in that of its vehicle, whether it hangs upside down, and how it is tilted besides
    /// ([`Sensor::mounted`]); one that is far from level is tilted alone, and the tilt is `None` where the recording states no
    /// rotation. `None` if the recording does not state the mount (a stream: up to now), or if the sensor stands upright and looks ahead.
    ///
    /// The frame of the vehicle is the first above the sensor's whose name has `base` in it, else the topmost.
    pub(crate) fn of(&mut self, frame: &str) -> Option<(f64, bool, Option<UnitQuaternion<f64>>)> {
        self.0.read_on();
        let line = self.0.line(frame);
        let mut above = line.iter().skip(1).filter(|name| !WORLD.contains(*name));
        let vehicle = above.clone().find(|name| name.contains("base")).or_else(|| above.next_back())?;
        let Some(rotation) = self.0.pose(frame, vehicle, 0).map(|pose| pose.rotation) else {
            return Some((0.0, false, None));
        };
        let (ahead, up) = (rotation * Vector3::x(), rotation * Vector3::z());
        let is_level = up.z.abs() > LEVEL_RAD.cos();
        let (yaw_rad, upside_down) = if is_level { (ahead.y.atan2(ahead.x), up.z < 0.0) } else { (0.0, false) };
        let over = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), if upside_down { PI } else { 0.0 });
        let tilt = rotation * (UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad) * over).inverse();
        let yaw_rad = if yaw_rad.abs() < LEAST_TURN_RAD { 0.0 } else { yaw_rad };
        let is_turned = yaw_rad != 0.0 || upside_down || tilt.angle() >= LEAST_TURN_RAD;
        is_turned.then_some((yaw_rad, upside_down, Some(tilt)))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use crosscut_messages::{Header, Quaternion, Time, Transform, TransformStamped, Vector3};

    use super::*;

    fn mount(edges: &[(&str, &str, [f64; 4])]) -> Mount {
        let mut frames = Frames::default();
        for &(parent, child, [x, y, z, w]) in edges {
            let header = Header { stamp: Time::default(), frame_id: parent.to_owned() };
            let transform =
                Transform { translation: Vector3 { x: 0.2, y: 0.0, z: 0.3 }, rotation: Quaternion { x, y, z, w } };
            frames.add(&TransformStamped { header, child_frame_id: child.to_owned(), transform }, true);
        }
        Mount(frames)
    }

    fn angle_of(tilt: Option<UnitQuaternion<f64>>) -> f64 {
        tilt.expect("a rotation").angle()
    }

    const AHEAD: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
    const LEFT: [f64; 4] = [0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2];

    #[test]
    fn a_sensor_is_turned_as_it_lies_in_the_frame_of_its_vehicle() {
        let chain = [("odom", "base_link", LEFT), ("base_link", "mast", AHEAD), ("mast", "laser", LEFT)];
        let (yaw_rad, upside_down, tilt) = mount(&chain).of("/laser").expect("stated");
        assert!((yaw_rad - FRAC_PI_2).abs() < 1e-12 && !upside_down && angle_of(tilt) < 1e-7);
        let hangs = mount(&[("base_link", "laser", [1.0, 0.0, 0.0, 0.0])]).of("laser");
        assert!(hangs.is_some_and(|(yaw_rad, upside_down, _)| yaw_rad.abs() < 1e-12 && upside_down), "{hangs:?}");
    }

    #[test]
    fn what_looks_down_is_tilted_and_what_looks_ahead_or_is_unknown_needs_no_mount() {
        assert_eq!(mount(&[("base_link", "laser", AHEAD)]).of("laser"), None);
        let looks_down = mount(&[("base_link", "laser", [0.0, LEFT[2], 0.0, LEFT[3]])]).of("laser");
        assert!(looks_down.is_some_and(|(yaw_rad, over, tilt)| yaw_rad == 0.0
            && !over
            && tilt.is_some_and(|tilt| (tilt * nalgebra::Vector3::x()).z < -0.99)));
        assert_eq!(mount(&[("odom", "laser", LEFT)]).of("laser"), None, "no vehicle");
        assert_eq!(mount(&[]).of("laser"), None);
    }

    #[test]
    fn of_several_mounts_the_last_rotation_counts() {
        const NONE: [f64; 4] = [0.0; 4];
        let tilted = [0.0, f64::sin(0.1), 0.0, f64::cos(0.1)];
        let of = |turns: &[[f64; 4]]| {
            mount(&turns.iter().map(|turn| ("base_link", "laser", *turn)).collect::<Vec<_>>()).of("laser")
        };
        assert!(of(&[LEFT, tilted]).is_some_and(|(_, _, tilt)| (angle_of(tilt) - 0.2).abs() < 1e-9));
        assert!(of(&[tilted, NONE]).is_some_and(|(_, _, tilt)| (angle_of(tilt) - 0.2).abs() < 1e-9));
        assert_eq!(of(&[tilted, AHEAD]), None);
        assert_eq!(of(&[NONE]), Some((0.0, false, None)));
        assert_eq!(of(&[[f64::NAN; 4]]), Some((0.0, false, None)));
    }
}
