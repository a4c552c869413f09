//! What a planner knows: the places of the map, their ways, and which of them are new.

use nalgebra::Point2;

use crosscut_flight::HereKind;
use crosscut_stage::wrap_angle_rad;

/// The map as a planner sees it, at a decision. Bearings and positions are in the frame of the map.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannerMap {
    /// Junctions and dead ends, in the order in which they were found.
    pub places: Vec<KnownPlace>,
    /// The place that the vehicle is in.
    pub here: usize,
    /// The direction in which it came.
    pub heading_rad: f64,
}

/// A junction or a dead end.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownPlace {
    /// Its kind.
    pub kind: HereKind,
    /// Where it is, metres.
    pub position_m: Point2<f64>,
    /// Its ways.
    pub ways: Vec<KnownWay>,
}

/// A way of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownWay {
    /// Its direction.
    pub bearing_rad: f64,
    /// Whether it is to be explored.
    pub state: WayState,
    /// The place that it leads to, and how far that is, metres, if that is known.
    pub leads_to: Option<(usize, f64)>,
}

/// Whether a way is to be explored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WayState {
    /// It was not taken.
    New,
    /// The vehicle came or left by it.
    Taken,
    /// It is seen to end, near by.
    Ended,
    /// It proved impassable.
    Blocked,
}

/// A way over known places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Route {
    /// The way of the present place that it begins with.
    pub way: usize,
    /// The place that it leads to.
    pub to: usize,
    /// Its length, metres.
    pub length_m: f64,
}

impl PlannerMap {
    /// The new way of the present place that is nearest to straight ahead.
    pub fn straightest_new_way(&self) -> Option<usize> {
        let ways = &self.places[self.here].ways;
        let off_rad = |way: &usize| wrap_angle_rad(ways[*way].bearing_rad - self.heading_rad).abs();
        let new = (0..ways.len()).filter(|&way| ways[way].state == WayState::New);
        new.min_by(|a, b| off_rad(a).total_cmp(&off_rad(b)))
    }

    /// Whether a place is a junction with a way to explore.
    pub fn has_new_way(&self, place: usize) -> bool {
        let place = &self.places[place];
        place.kind == HereKind::Junction && place.ways.iter().any(|way| way.state == WayState::New)
    }

    /// The shortest route over known passages to another place that `is_goal` holds for; the nearest one of several.
    pub fn route(&self, is_goal: impl Fn(usize) -> bool) -> Option<Route> {
        let mut least_m = vec![f64::INFINITY; self.places.len()];
        let mut first_way = vec![0; self.places.len()];
        let mut is_done = vec![false; self.places.len()];
        least_m[self.here] = 0.0;
        loop {
            let open = (0..self.places.len()).filter(|&place| !is_done[place] && least_m[place].is_finite());
            let at = open.min_by(|&a, &b| least_m[a].total_cmp(&least_m[b]))?;
            if at != self.here && is_goal(at) {
                return Some(Route { way: first_way[at], to: at, length_m: least_m[at] });
            }
            is_done[at] = true;
            for (number, way) in self.places[at].ways.iter().enumerate() {
                let Some((to, length_m)) = way.leads_to.filter(|_| way.state != WayState::Blocked) else { continue };
                if least_m[at] + length_m < least_m[to] {
                    least_m[to] = least_m[at] + length_m;
                    first_way[to] = if at == self.here { number } else { first_way[at] };
                }
            }
        }
    }
}
