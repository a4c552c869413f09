//! Straight pieces of the surface.

use crate::network::{Point, Vector};

/// A straight piece of the surface.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Start of the segment.
    pub from_m: Point,
    /// End of the segment.
    pub to_m: Point,
    /// Number of the pillar that the segment belongs to; `None` for the rock around the mine.
    pub pillar: Option<u32>,
    /// Whether the rock is wet here.
    pub wet: bool,
}

impl Segment {
    /// Sine of the angle between a ray and the segment: 1 head on, 0 along it.
    pub fn incidence_sine(&self, direction: Vector) -> f64 {
        let along = self.to_m - self.from_m;
        (direction.perp(&along) / along.norm()).abs()
    }

    /// Distance along a ray to the segment, if the ray meets it.
    pub(crate) fn meets(&self, origin_m: Point, direction: Vector) -> Option<f64> {
        let along = self.to_m - self.from_m;
        let offset = self.from_m - origin_m;
        let cross = direction.perp(&along);
        // origin + t·direction = from + s·along, solved by crossing with one and the other direction.
        let (t, s) = (offset.perp(&along) / cross, offset.perp(&direction) / cross);
        (t >= 0.0 && (0.0..=1.0).contains(&s)).then_some(t)
    }

    /// Distance from a point to the nearest place of the segment.
    pub(crate) fn distance_m(&self, point_m: Point) -> f64 {
        let along = self.to_m - self.from_m;
        let s = ((point_m - self.from_m).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        (point_m - (self.from_m + along * s)).norm()
    }
}
