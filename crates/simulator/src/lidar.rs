//! The lidar, and the noise-free echo of each beam. [`reading`](crate::reading) has what the lidar reports of it.

use std::f64::consts::TAU;

use crosscut_stage::unit;

use crate::network::{Point, Vector};
use crate::pose::{Motion, Pose};
use crate::surface::Surface;

/// A 2D lidar that turns anticlockwise, with its errors. Probabilities are per beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lidar {
    /// Number of beams.
    pub beams: usize,
    /// Field of view, centred straight ahead. At 2π the last beam is the neighbour of the first.
    pub field_of_view_rad: f64,
    /// The smallest range that is measured.
    pub range_min_m: f64,
    /// The largest range that is measured.
    pub range_max_m: f64,
    /// Duration of a sweep. Motion of the vehicle during it distorts the scan.
    pub sweep_s: f64,
    /// Standard deviation of the range noise.
    pub noise_sd_m: f64,
    /// Ranges are rounded to multiples of this; 0 for no rounding.
    pub quantum_m: f64,
    /// Probability that a beam is lost.
    pub loss: f64,
    /// Additional probability of loss at the largest range; it grows with the square of the range.
    pub loss_at_range_max: f64,
    /// Additional probability of loss at grazing incidence; it falls linearly in the sine to 0 at 20°.
    pub loss_at_grazing: f64,
    /// Additional probability of loss on wet rock.
    pub loss_on_wet: f64,
    /// Share of the beams lost in patches of neighbouring beams.
    pub patch_share: f64,
    /// Smallest and largest number of beams in a patch.
    pub patch_beams: [usize; 2],
    /// Share of the beams that return from dust.
    pub dust: f64,
    /// Largest range of dust, which is never behind the wall.
    pub dust_range_m: f64,
    /// Probability that one of the two beams at an edge, where the range jumps, reports a range in between (a mixed
    /// pixel).
    pub mixed_at_edges: f64,
    /// Probability that one of the two beams at an edge is lost.
    pub loss_at_edges: f64,
}

impl Lidar {
    /// 360 beams over a full turn, 15 m range, noise of 1.5 cm, ranges in steps of 1 mm, no lost beams.
    pub const CLEAN: Self = Self {
        beams: 360,
        field_of_view_rad: TAU,
        range_min_m: 0.1,
        range_max_m: 15.0,
        sweep_s: 0.1,
        noise_sd_m: 0.015,
        quantum_m: 0.001,
        loss: 0.0,
        loss_at_range_max: 0.0,
        loss_at_grazing: 0.0,
        loss_on_wet: 0.0,
        patch_share: 0.0,
        patch_beams: [3, 18],
        dust: 0.0,
        dust_range_m: 6.0,
        mixed_at_edges: 0.0,
        loss_at_edges: 0.0,
    };

    /// An ordinary one: it loses beams at random, far off and at grazing incidence.
    pub(crate) const ORDINARY: Self = Self { loss: 0.03, loss_at_range_max: 0.2, loss_at_grazing: 0.3, ..Self::CLEAN };

    /// An ordinary one in a mine with wet walls and some dust.
    pub(crate) const IN_WET_MINE: Self =
        Self { loss: 0.05, loss_at_range_max: 0.3, loss_on_wet: 0.7, dust: 0.003, ..Self::ORDINARY };
}

/// The noise-free echo of a beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Echo {
    /// Nothing within range.
    Nothing,
    /// A wall or pillar.
    Rock {
        /// Distance along the beam.
        range_m: f64,
        /// The segment of the surface.
        segment: usize,
        /// Sine of the angle between beam and surface.
        incidence_sine: f64,
    },
    /// The floor or the roof, because the vehicle is tilted.
    Floor {
        /// Distance along the beam.
        range_m: f64,
    },
}

impl Echo {
    /// Distance along the beam; infinite if there is nothing.
    pub fn range_m(&self) -> f64 {
        match *self {
            Self::Nothing => f64::INFINITY,
            Self::Rock { range_m, .. } | Self::Floor { range_m } => range_m,
        }
    }
}

impl Lidar {
    /// Whether the field of view is a full turn.
    pub fn full_turn(&self) -> bool {
        self.field_of_view_rad >= TAU - 1e-9
    }

    /// Angle from one beam to the next.
    pub fn step_rad(&self) -> f64 {
        if self.full_turn() { TAU / self.beams as f64 } else { self.field_of_view_rad / (self.beams.max(2) - 1) as f64 }
    }

    /// Bearing of a beam in the body frame; beams may be fractions, or lie outside the field of view.
    pub fn bearing_rad(&self, beam: f64) -> f64 {
        beam * self.step_rad() - 0.5 * self.field_of_view_rad
    }

    /// Pose of the lidar when it fires a beam.
    pub fn pose_at(&self, motion: &Motion, beam: f64) -> Pose {
        motion.at(beam * self.step_rad() / TAU)
    }

    /// The beam that points at a place, as a fractional number; below 0 or above the last if outside the view.
    pub fn beam_towards(&self, motion: &Motion, point_m: Point) -> f64 {
        // The pose depends on the beam and the beam on the pose. A few iterations converge, because the lidar turns much
        // faster than the vehicle.
        let mut beam = 0.5 * self.beams as f64;
        for _ in 0..5 {
            let pose = self.pose_at(motion, beam);
            let towards = point_m - pose.position_m;
            let bearing_rad = crosscut_stage::wrap_angle_rad(towards.y.atan2(towards.x) - pose.heading_rad);
            beam = (bearing_rad + 0.5 * self.field_of_view_rad) / self.step_rad();
        }
        beam
    }

    /// The noise-free echo of every beam.
    pub fn view(&self, surface: &Surface, height_m: f64, motion: &Motion) -> Vec<Echo> {
        (0..self.beams)
            .map(|beam| self.echo(surface, height_m, &self.pose_at(motion, beam as f64), self.bearing_rad(beam as f64)))
            .collect()
    }

    /// The echo of a beam from `pose` towards `bearing_rad`.
    fn echo(&self, surface: &Surface, height_m: f64, pose: &Pose, bearing_rad: f64) -> Echo {
        let direction: Vector = unit(pose.heading_rad + bearing_rad);
        // For small angles the beam dips by the tilt of the sensor in the direction of the beam.
        let dip_rad = pose.pitch_rad * bearing_rad.cos() - pose.roll_rad * bearing_rad.sin();
        let level = dip_rad.cos();
        let floor_range_m = 0.5 * height_m / dip_rad.sin().abs();
        match surface.cast(pose.position_m, direction, self.range_max_m * level) {
            Some(hit) if hit.range_m / level < floor_range_m => Echo::Rock {
                range_m: hit.range_m / level,
                segment: hit.segment,
                incidence_sine: surface.segments()[hit.segment].incidence_sine(direction),
            },
            _ if floor_range_m < self.range_max_m => Echo::Floor { range_m: floor_range_m },
            _ => Echo::Nothing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_beam_towards_a_place_meets_it_while_moving() {
        let motion = Motion {
            start: Pose::level(Point::new(0.0, 0.3), 0.2),
            end: Pose { heading_rad: 0.35, ..Pose::level(Point::new(0.2, 0.4), 0.0) },
        };
        for lidar in [Lidar::CLEAN, Lidar { beams: 256, field_of_view_rad: 4.45, ..Lidar::CLEAN }] {
            for beam in [10.0, 100.5, 190.0, 250.0] {
                let pose = lidar.pose_at(&motion, beam);
                let target = pose.position_m + unit(pose.heading_rad + lidar.bearing_rad(beam)) * 4.0;
                let found = lidar.beam_towards(&motion, target);
                assert!((found - beam).abs() < 1e-3, "{found} is not {beam}");
            }
        }
    }
}
