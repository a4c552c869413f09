//! `nearest_frontier`: the new way that is nearest over the map.

use super::{Choice, Planner, PlannerKind};
use crate::known::Known;

pub(super) const KIND: PlannerKind = PlannerKind {
    name: "nearest_frontier",
    doc: "the new way that takes the least to fly to over the map",
    new: || Box::new(NearestFrontier),
};

struct NearestFrontier;

impl Planner for NearestFrontier {
    fn choose(&mut self, known: &Known) -> Option<Choice> {
        if let Some(choice) = Choice::here(known) {
            return Some(choice);
        }
        let route = known.route(|place| known.has_new_way(place))?;
        let why = format!("the nearest way not taken is {:.0} m ahead, at place {}", route.length_m, route.to);
        Some(Choice { way: route.way, why })
    }
}
