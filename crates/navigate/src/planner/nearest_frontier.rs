//! `nearest_frontier`: the new way that is nearest over the map.

use super::{Planner, PlannerKind, WayChoice};
use crate::known::PlannerMap;

pub(super) const KIND: PlannerKind = PlannerKind {
    name: "nearest_frontier",
    doc: "the new way that takes the least to fly to over the map",
    new: || Box::new(NearestFrontier),
};

struct NearestFrontier;

impl Planner for NearestFrontier {
    fn choose(&mut self, known: &PlannerMap) -> Option<WayChoice> {
        if let Some(choice) = WayChoice::here(known) {
            return Some(choice);
        }
        let route = known.route(|place| known.has_new_way(place))?;
        let why = format!("the nearest way not taken is {:.0} m ahead, at place {}", route.length_m, route.to);
        Some(WayChoice { way: route.way, why })
    }
}
