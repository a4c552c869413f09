//! Places that move with the map when its drift is corrected.

use nalgebra::Isometry2;

use super::Mapper;

/// A place relative to the latest visit before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchored {
    /// The visit, as an index of [`Mapper::poses`]; `None` before the first.
    pub visit: Option<usize>,
    /// The place in the frame of that visit, or in the map's before the first.
    pub pose: Isometry2<f64>,
}

impl Anchored {
    /// Where the place lies if the visits were at these poses.
    pub fn placed(&self, visits: &[Isometry2<f64>]) -> Isometry2<f64> {
        self.visit.and_then(|visit| visits.get(visit)).map_or(self.pose, |pose| pose * self.pose)
    }
}

impl Mapper {
    /// Where the visits were, by what is known now, in the map's frame.
    pub fn poses(&self) -> &[Isometry2<f64>] {
        &self.log.graph.poses
    }

    /// A pose as it is tracked since the latest visit that has ended, relative to this visit.
    pub fn anchored(&self, tracked: Isometry2<f64>) -> Anchored {
        let visit = self.log.last();
        let pose = visit.map_or(tracked, |last| self.log.visits[last].anchor.inv_mul(&tracked));
        Anchored { visit, pose }
    }

    /// Where an anchored place lies by what is known now.
    pub fn placed(&self, anchored: &Anchored) -> Isometry2<f64> {
        anchored.placed(self.poses())
    }
}
