//! Where the beams look, kept from scan to scan: most scans of a recording have one geometry, and sines take longer than all
//! else that is done with a scan.

use crosscut_stage::{Fan, wrap_angle_rad};

/// Directions of the beams of one sensor in the body frame.
#[derive(Debug, Default)]
pub(crate) struct BeamDirections {
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

impl BeamDirections {
    /// Makes them those of `fan` with this number of beams; `masks` tells the bearings that the sensor ignores.
    pub(crate) fn update(&mut self, fan: Fan, beams: usize, masks: impl Fn(f64) -> bool) {
        if self.of.replace((fan, beams)) == Some((fan, beams)) {
            return;
        }
        self.bearings_rad.clear();
        self.beams.clear();
        for beam in 0..beams {
            let angle_rad = fan.angle_rad(beam);
            let bearing_rad = wrap_angle_rad(angle_rad);
            let (sin, cos) = angle_rad.sin_cos();
            self.bearings_rad.push(bearing_rad);
            self.beams.push(Direction { sin, cos, is_masked: masks(bearing_rad) });
        }
    }
}
