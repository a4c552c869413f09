//! The flight's map with what the vehicle notes beside it: which ways it tried, and how it went from place to place.

use nalgebra::{Isometry2, Point2};

use crosscut_flight::{Located, Node, NodeWay};
use crosscut_stage::{HereKind, Way, unit, wrap_angle_rad};

use crate::known::{Known, KnownPlace, KnownWay, WayState};

/// A note belongs to a way of a place if it is no farther from it than this.
const SAME_PLACE_M: f64 = 3.0;
const SAME_WAY_RAD: f64 = 0.5;

/// A way in view that is farther from all ways of the place on the map is one that the map misses.
const OTHER_WAY_RAD: f64 = 0.6;

/// A way is given up after this many attempts that did not lead into it.
const MOST_TRIES: u32 = 2;

/// Places of the trail are this far apart, m.
const TRAIL_STEP_M: f64 = 0.4;

/// A link that the map does not have is taken to be longer by this, m, so that passages of the map go before.
const LINK_EXTRA_M: f64 = 5.0;

/// What the vehicle notes. Positions and bearings are in the frame of the map, as it was when they were noted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chart {
    notes: Vec<Note>,
    links: Vec<Link>,
    trail_m: Vec<Point2<f64>>,
}

/// A way of a place with what is known of it.
#[derive(Clone, Copy, Debug)]
struct Note {
    place_m: Point2<f64>,
    bearing_rad: f64,
    tries: u32,
    is_taken: bool,
    is_ended: bool,
}

/// How the vehicle went from one place to the next.
#[derive(Clone, Copy, Debug)]
struct Link {
    ends: [LinkEnd; 2],
    length_m: f64,
}

/// A way of a place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinkEnd {
    /// When a visit to the place began. Its number on the map changes where two places turn out to be one; the visit stays
    /// one to it.
    pub(crate) visited_ns: u64,
    /// In the frame of the map.
    pub(crate) bearing_rad: f64,
}

impl LinkEnd {
    pub(crate) fn new(located: &Located, bearing_rad: f64) -> Self {
        let visited_ns = located.map.nodes[located.node].visits.first().map_or(0, |visit| visit[0]);
        Self { visited_ns, bearing_rad }
    }

    fn is_of(&self, node: &Node) -> bool {
        node.visits.iter().any(|visit| visit[0] == self.visited_ns)
    }
}

impl Chart {
    /// Adds the vehicle's place to the trail.
    pub(crate) fn passes(&mut self, place_m: Point2<f64>) {
        if self.trail_m.last().is_none_or(|last_m| (place_m - last_m).norm() > TRAIL_STEP_M) {
            self.trail_m.push(place_m);
        }
    }

    /// The place of the trail about this far back.
    pub(crate) fn back_m(&self, from_m: Point2<f64>, far_m: f64) -> Option<Point2<f64>> {
        self.trail_m.iter().rev().find(|place_m| (*place_m - from_m).norm() >= far_m).copied()
    }

    /// Notes that a way was taken (`led_into`), or that an attempt did not lead into it.
    pub(crate) fn tried(&mut self, place_m: Point2<f64>, bearing_rad: f64, led_into: bool) {
        let note = self.note(place_m, bearing_rad);
        note.is_taken |= led_into;
        note.tries += u32::from(!led_into);
    }

    /// Notes that a way is seen to end.
    pub(crate) fn ends(&mut self, place_m: Point2<f64>, bearing_rad: f64) {
        self.note(place_m, bearing_rad).is_ended = true;
    }

    /// Notes a flight from one way of a place to one of another place.
    pub(crate) fn link(&mut self, from: LinkEnd, to: LinkEnd, length_m: f64) {
        self.links.push(Link { ends: [from, to], length_m });
    }

    /// What a planner is to know. `in_view` are the ways of the present place in the frame of the map.
    pub(crate) fn known(&self, located: &Located, in_view: &[Way], heading_rad: f64) -> Known {
        let nodes = located.map.nodes.iter().enumerate();
        let mut places: Vec<KnownPlace> = nodes
            .map(|(number, node)| KnownPlace {
                kind: node.kind,
                position_m: node.position_m,
                ways: node.ways.iter().map(|way| self.way(located, number, way)).collect(),
            })
            .collect();
        let here = &mut places[located.node];
        let known = here.ways.len();
        for way in in_view.iter().filter(|_| here.kind == HereKind::Junction) {
            let is_other = |known: &KnownWay| wrap_angle_rad(known.bearing_rad - way.bearing_rad).abs() > OTHER_WAY_RAD;
            if here.ways[..known].iter().all(is_other) {
                let unseen =
                    NodeWay { bearing_rad: way.bearing_rad, width_m: way.width_m, taken: false, passage: None };
                let state = self.state(here.position_m, &unseen);
                here.ways.push(KnownWay { bearing_rad: way.bearing_rad, state, leads_to: None });
            }
        }
        Known { places, here: located.node, heading_rad }
    }

    fn way(&self, located: &Located, number: usize, way: &NodeWay) -> KnownWay {
        let node = &located.map.nodes[number];
        let passage = way.passage.map(|passage| &located.map.passages[passage]);
        let by_map =
            passage.map(|passage| (if passage.from == number { passage.to } else { passage.from }, passage.length_m));
        let is_of_way =
            |end: &LinkEnd| end.is_of(node) && wrap_angle_rad(end.bearing_rad - way.bearing_rad).abs() < SAME_WAY_RAD;
        let mut by_links = self.links.iter().rev().filter_map(|link| {
            let other = &link.ends[1 - link.ends.iter().position(is_of_way)?];
            let to = located.map.nodes.iter().position(|node| other.is_of(node))?;
            Some((to, link.length_m + LINK_EXTRA_M))
        });
        // A place may be passed unnoticed once. Where the way was found to lead elsewhere twice, the map is wrong.
        let [last, before] = [by_links.next(), by_links.next()];
        let is_wrong = |by_map: usize| {
            let elsewhere = |link: Option<(usize, f64)>| link.map(|(to, _)| to).filter(|to| *to != by_map);
            elsewhere(last).is_some() && elsewhere(last) == elsewhere(before)
        };
        KnownWay {
            bearing_rad: way.bearing_rad,
            state: self.state(node.position_m, way),
            leads_to: by_map.filter(|(to, _)| !is_wrong(*to)).or(last),
        }
    }

    fn state(&self, place_m: Point2<f64>, way: &NodeWay) -> WayState {
        let note = self.notes.iter().find(|note| note.is_of(place_m, way.bearing_rad));
        if way.taken || note.is_some_and(|note| note.is_taken) || self.is_on_trail(place_m, way) {
            WayState::Taken
        } else if note.is_some_and(|note| note.tries >= MOST_TRIES) {
            WayState::Blocked
        } else if note.is_some_and(|note| note.is_ended) {
            WayState::Ended
        } else {
            WayState::New
        }
    }

    /// Whether the trail leads through the mouth of a way and on: the place may be on the map twice.
    fn is_on_trail(&self, place_m: Point2<f64>, way: &NodeWay) -> bool {
        let along = unit(way.bearing_rad);
        let mouth_m = (1.4 * way.width_m).clamp(1.5, 9.0);
        let within_m = 0.3 * way.width_m.min(5.0) + 0.3;
        let is_passed = |far_m: f64| {
            let at_m = place_m + along * far_m;
            self.trail_m.iter().any(|trail_m| (trail_m - at_m).norm() < within_m)
        };
        is_passed(mouth_m) && is_passed(mouth_m + 1.0) && is_passed(mouth_m + 2.0)
    }

    fn note(&mut self, place_m: Point2<f64>, bearing_rad: f64) -> &mut Note {
        let at = self.notes.iter().position(|note| note.is_of(place_m, bearing_rad)).unwrap_or_else(|| {
            self.notes.push(Note { place_m, bearing_rad, tries: 0, is_taken: false, is_ended: false });
            self.notes.len() - 1
        });
        &mut self.notes[at]
    }
}

impl Note {
    fn is_of(&self, place_m: Point2<f64>, bearing_rad: f64) -> bool {
        (self.place_m - place_m).norm() < SAME_PLACE_M
            && wrap_angle_rad(self.bearing_rad - bearing_rad).abs() < SAME_WAY_RAD
    }
}

/// The ways of a place, turned from the body frame into that of the map.
pub(crate) fn in_map(ways: &[Way], pose: &Isometry2<f64>, correction: &Isometry2<f64>) -> Vec<Way> {
    let turn_rad = pose.rotation.angle() + correction.rotation.angle();
    ways.iter().map(|way| Way { bearing_rad: wrap_angle_rad(way.bearing_rad + turn_rad), ..*way }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_flight::{Map, Passage};

    #[test]
    fn a_way_that_led_elsewhere_twice_is_believed_before_the_map() {
        let way = |bearing_rad: f64| NodeWay { bearing_rad, width_m: 3.0, taken: true, passage: None };
        let node = |number: u64| Node {
            kind: HereKind::Junction,
            position_m: Point2::new(20.0 * number as f64, 0.0),
            ways: [0.0, 1.6, 3.1].map(way).to_vec(),
            visits: vec![[number, number]],
        };
        let mut map = Map { nodes: (0..3).map(node).collect(), ..Map::default() };
        let passage = Passage { from: 0, to: 1, length_m: 20.0, width_m: 3.0, stretch_ns: [0; 2], via_m: Vec::new() };
        map.passages.push(passage);
        (map.nodes[0].ways[0].passage, map.nodes[1].ways[2].passage) = (Some(0), Some(0));
        let located = Located { map, node: 0, correction: Isometry2::identity() };
        let mut chart = Chart::default();
        let end = |visited_ns, bearing_rad| LinkEnd { visited_ns, bearing_rad };
        let mut leads_to = |to: Option<u64>| {
            to.into_iter().for_each(|to| chart.link(end(0, 0.1), end(to, 3.0), 30.0));
            chart.known(&located, &[], 0.0).places[0].ways[0].leads_to
        };
        assert_eq!(leads_to(None), Some((1, 20.0)), "by the map");
        assert_eq!(leads_to(Some(2)), Some((1, 20.0)), "a place may have been passed unnoticed");
        assert_eq!(leads_to(Some(2)), Some((2, 30.0 + LINK_EXTRA_M)), "the map is wrong");
        assert_eq!(leads_to(Some(1)), Some((1, 20.0)), "the map is right again");
    }
}
