//! `depth_first`: on as long as there is a new way, then back to the place found last that has one.

use super::{Planner, PlannerKind, WayChoice};
use crate::known::PlannerMap;

pub(super) const KIND: PlannerKind = PlannerKind {
    name: "depth_first",
    doc: "the new way nearest to straight ahead, else back to the junction found last that has one",
    new: || Box::new(DepthFirst),
};

struct DepthFirst;

impl Planner for DepthFirst {
    fn choose(&mut self, known: &PlannerMap) -> Option<WayChoice> {
        if let Some(choice) = WayChoice::here(known) {
            return Some(choice);
        }
        // A place that cannot be reached is passed over.
        let last_first = (0..known.places.len()).rev().filter(|&place| known.has_new_way(place));
        let route = last_first.filter_map(|place| known.route(|to| to == place)).next()?;
        let why = format!(
            "back to place {}, {:.0} m away: found last of those with a way not taken",
            route.to, route.length_m
        );
        Some(WayChoice { way: route.way, why })
    }
}
