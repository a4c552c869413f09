//! A mission to fly.

use crosscut_simulator::{Family, World};

/// One mission to fly.
pub(super) struct Job {
    pub(super) name: String,
    pub(super) seed: u64,
    pub(super) place: Place,
}

impl Job {
    pub(super) fn world(&self) -> World {
        match &self.place {
            Place::Family(family) => (family.world)(self.seed),
            Place::Plan(world) => World::clone(world),
        }
    }
}

/// Where a mission is flown.
pub(super) enum Place {
    Family(&'static Family),
    Plan(Box<World>),
}
