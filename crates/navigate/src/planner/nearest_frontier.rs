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
        if let Some(way) = known.straightest_new_way() {
            return Some(Choice { way, why: "a new way here, nearest to straight ahead".to_owned() });
        }
        let route = known.route(|place| known.has_new_way(place))?;
        let why = format!("to the new way at place {}, {:.0} m away", route.to, route.length_m);
        Some(Choice { way: route.way, why })
    }
}
