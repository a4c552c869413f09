//! What matches by scans alone carry from one revolution to the next, beside the walls.

use nalgebra::Isometry2;

use crate::line_points::LinePoint;
use crate::local_map::LocalMap;
use crate::search::Search;

#[derive(Clone, Debug, Default)]
pub(crate) struct Unaided {
    /// Walls showed how the vehicle moves.
    pub(crate) is_motion_known: bool,
    /// For this many revolutions they did not.
    pub(crate) unknown: u32,
    /// The step to expect next, where it is not the last one.
    pub(crate) next_step: Option<Isometry2<f64>>,
    /// What was seen while walls did not hold the pose was remembered.
    pub(crate) is_adrift: bool,
    /// The revolution is remembered, wherever it lies.
    pub(crate) must_remember: bool,
    /// The line points of the revolution that show how far along a direction the vehicle is.
    pub(crate) shown: Vec<LinePoint>,
    /// Those of the revolution before, if the walls did not show it: what comes newly into view is not among the walls.
    pub(crate) fresh: LocalMap,
    pub(crate) search: Search,
}

impl Unaided {
    /// Begins where the motion is known, or is not.
    pub(crate) fn follow(&mut self, is_motion_known: bool) {
        self.is_motion_known = is_motion_known;
        self.unknown = 0;
        self.is_adrift = false;
        self.fresh.clear();
    }

    /// The vehicle's own returns, which move with it as if nothing moved, are found. Until now they held the pose, for so many
    /// revolutions.
    pub(crate) fn was_held(&mut self, revolutions: u32) {
        self.is_motion_known = false;
        self.unknown = revolutions;
    }
}
