//! The lidar: what each beam of a sweep would see without noise. What it reports: [`reading`](crate::reading).

use std::f64::consts::TAU;

use crate::network::{Point, Vector, unit};
use crate::pose::{Motion, Pose};
use crate::surface::Surface;

/// A 2D lidar that turns anticlockwise, and the ways in which it errs. Probabilities are per beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lidar {
    /// Number of beams.
    pub beams: usize,
    /// Field of view, centred on the nose. 2π is a full turn: then the last beam is the neighbour of the first.
    pub field_of_view_rad: f64,
    /// Nearer than this nothing is measured.
    pub range_min_m: f64,
    /// Farther than this nothing is measured.
    pub range_max_m: f64,
    /// Time that a sweep takes. A vehicle that moves meanwhile skews it.
    pub sweep_s: f64,
    /// Standard deviation of the range noise.
    pub noise_sd_m: f64,
    /// Ranges are whole multiples of this; 0 for none.
    pub quantum_m: f64,
    /// Lost at random.
    pub loss: f64,
    /// Lost at the end of the range; grows with the square of the range.
    pub loss_at_range_max: f64,
    /// Lost where the beam runs along the surface; falls to 0 at 20° of incidence, linearly in the sine.
    pub loss_at_grazing: f64,
    /// Lost on wet rock.
    pub loss_on_wet: f64,
    /// Share of the beams lost in patches of neighbouring beams.
    pub patch_share: f64,
    /// Smallest and largest number of beams in a patch.
    pub patch_beams: [usize; 2],
    /// Share of the beams that return from dust.
    pub dust: f64,
    /// Dust is seen up to here, and never behind the wall.
    pub dust_range_m: f64,
    /// One of the two beams at an edge, where the range jumps, meets both sides of it and reports a range in between
    /// (a mixed pixel).
    pub mixed_at_edges: f64,
    /// One of the two is lost.
    pub loss_at_edges: f64,
}

impl Lidar {
    /// 360 beams all around, 15 m, 1.5 cm noise in steps of a millimetre, nothing lost.
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
}

/// What a beam meets.
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
    /// Whether the sweep closes on itself.
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

    /// Where the lidar is when it fires a beam.
    pub fn pose_at(&self, motion: &Motion, beam: f64) -> Pose {
        motion.at(beam * self.step_rad() / TAU)
    }

    /// The beam that points at a place, as a fraction; less than 0 or more than the last if it is outside the view.
    pub fn beam_towards(&self, motion: &Motion, point_m: Point) -> f64 {
        // Where the lidar is depends on the beam, and the beam on where it is: a few rounds settle that, because the
        // lidar turns much faster than the vehicle.
        let mut beam = 0.5 * self.beams as f64;
        for _ in 0..5 {
            let pose = self.pose_at(motion, beam);
            let towards = point_m - pose.position_m;
            let bearing_rad = crosscut_stage::wrap_angle_rad(towards.y.atan2(towards.x) - pose.heading_rad);
            beam = (bearing_rad + 0.5 * self.field_of_view_rad) / self.step_rad();
        }
        beam
    }

    /// What every beam meets: the noise-free view.
    pub fn view(&self, surface: &Surface, height_m: f64, motion: &Motion) -> Vec<Echo> {
        (0..self.beams)
            .map(|beam| self.echo(surface, height_m, &self.pose_at(motion, beam as f64), self.bearing_rad(beam as f64)))
            .collect()
    }

    /// What a beam meets that leaves `pose` towards `bearing_rad`.
    fn echo(&self, surface: &Surface, height_m: f64, pose: &Pose, bearing_rad: f64) -> Echo {
        let direction: Vector = unit(pose.heading_rad + bearing_rad);
        // Small angles: the beam dips by the tilt of the sensor in its own direction.
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
    fn the_beam_towards_a_place_is_the_one_that_meets_it_on_the_move() {
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
