//! How the sensor is mounted in the body frame, which connects the drawings with the transforms of a robot.

use rerun::{CoordinateFrame, Quaternion, RecordingStream, RecordingStreamResult, Transform3D};

use crate::schema::SCAN_MOUNTING;

/// How the sensor is mounted in the body frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mounting {
    /// Direction of the sensor's zero bearing in the body frame, anticlockwise, rad.
    pub yaw_rad: f64,
    /// The sensor hangs upside down.
    pub upside_down: bool,
}

impl Mounting {
    /// From the sensor's frame to the body frame: half a turn about x if it hangs upside down, then the yaw about z.
    fn quaternion(self) -> Quaternion {
        let (sin, cos) = (0.5 * self.yaw_rad as f32).sin_cos();
        Quaternion::from_xyzw(if self.upside_down { [cos, sin, 0.0, 0.0] } else { [0.0, 0.0, sin, cos] })
    }
}

/// The name of the sensor's frame in the flight, and its rotation into the body frame.
pub(crate) fn log(rec: &RecordingStream, mounting: Mounting, frame_id: &str) -> RecordingStreamResult<()> {
    let turned = Transform3D::from_rotation(mounting.quaternion());
    if frame_id.is_empty() {
        return rec.log_static(SCAN_MOUNTING.path, &turned);
    }
    rec.log_static(SCAN_MOUNTING.path, &[&turned as &dyn rerun::AsComponents, &CoordinateFrame::new(frame_id)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// v turned by q.
    fn turn(q: Quaternion, v: [f32; 3]) -> [f32; 3] {
        let [x, y, z, w] = q.xyzw();
        nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z))
            .transform_vector(&nalgebra::Vector3::from(v))
            .into()
    }

    #[test]
    fn a_beam_is_turned_as_ingest_turns_it() {
        let angle_rad = 0.3_f32;
        let beam = [angle_rad.cos(), angle_rad.sin(), 0.0];
        for (upside_down, sign) in [(false, 1.0), (true, -1.0)] {
            let turned = turn(Mounting { yaw_rad: 1.1, upside_down }.quaternion(), beam);
            let expected_rad = 1.1 + sign * angle_rad;
            let error = (turned[0] - expected_rad.cos()).hypot(turned[1] - expected_rad.sin());
            assert!(error < 1e-6, "{turned:?}, upside down: {upside_down}");
        }
    }
}
