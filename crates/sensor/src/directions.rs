//! Where the beams look, kept from scan to scan: most scans of a recording have one geometry, and sines take longer than all
//! else that is done with a scan.

use crosscut_stage::wrap_angle_rad;

use crate::Sensor;
use crate::fan::Fan;

/// Directions of the beams of one sensor in the body frame.
#[derive(Debug, Default)]
pub(crate) struct Directions {
    /// The fan and the number of beams that they belong to.
    of: Option<(Fan, usize)>,
    pub(crate) bearings_rad: Vec<f64>,
    pub(crate) beams: Vec<Direction>,
}

/// Direction of one beam.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Direction {
    pub(crate) sin: f64,
    pub(crate) cos: f64,
    pub(crate) is_masked: bool,
}

impl Directions {
    /// Makes them those of `fan` with this number of beams, as `sensor` is mounted.
    pub(crate) fn update(&mut self, sensor: &Sensor, fan: Fan, beams: usize) {
        if self.of.replace((fan, beams)) == Some((fan, beams)) {
            return;
        }
        self.bearings_rad.clear();
        self.beams.clear();
        let fan = fan.mounted(sensor.yaw_rad, sensor.upside_down);
        for beam in 0..beams {
            let angle_rad = fan.angle_rad(beam);
            let bearing_rad = wrap_angle_rad(angle_rad);
            let (sin, cos) = angle_rad.sin_cos();
            self.bearings_rad.push(bearing_rad);
            self.beams.push(Direction { sin, cos, is_masked: sensor.masks(bearing_rad) });
        }
    }
}
