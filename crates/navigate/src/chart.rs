//! The flight's map with what the vehicle notes beside it: which ways it tried, and how it went from place to place.

use std::cmp::Ordering;

use nalgebra::{Isometry2, Point2};

use crosscut_flight::{HereKind, Located, Map, Node, NodeWay, Way};
use crosscut_stage::{unit, wrap_angle_rad};

use crate::known::{KnownPlace, KnownWay, PlannerMap, WayState};

/// A note belongs to a way whose direction differs by no more than this.
const SAME_WAY_RAD: f64 = 0.5;

/// A way in view that is farther from all ways of the place on the map is one that the map misses.
const OTHER_WAY_RAD: f64 = 0.6;

/// A way is given up after this many attempts that did not lead into it.
const MOST_TRIES: usize = 2;

/// A trail that leads this far beyond the mouth of a way leads through it, m.
const BEYOND_MOUTH_M: f64 = 4.0;

/// What the vehicle notes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chart {
    notes: Vec<(WayEnd, Noted)>,
    /// The flight began in a passage that leads on behind.
    pub(crate) begins_midway: bool,
}

/// What was noted of a way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Noted {
    /// The vehicle got into it.
    Taken,
    /// An attempt did not lead into it.
    Failed,
    /// It is seen to end.
    Ended,
    /// It was chosen to fly home.
    Homewards,
}

/// A way of a place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WayEnd {
    /// When a visit to the place began. Its number on the map changes where two places turn out to be one; the visit stays
    /// one to it.
    pub(crate) visited_ns: u64,
    /// In the frame of the map.
    pub(crate) bearing_rad: f64,
}

impl WayEnd {
    /// A way of the place that the vehicle is in.
    pub(crate) fn new(located: &Located, bearing_rad: f64) -> Self {
        let visited_ns = located.map.nodes[located.node].visits.first().map_or(0, |visit| visit[0]);
        Self { visited_ns, bearing_rad }
    }

    fn is_of(&self, node: &Node, bearing_rad: f64) -> bool {
        self.is_at(node) && wrap_angle_rad(self.bearing_rad - bearing_rad).abs() < SAME_WAY_RAD
    }

    fn is_at(&self, node: &Node) -> bool {
        node.visits.iter().any(|visit| visit[0] == self.visited_ns)
    }
}

impl Chart {
    /// Notes something of a way.
    pub(crate) fn note(&mut self, way: WayEnd, noted: Noted) {
        self.notes.push((way, noted));
    }

    /// Of these ways of the present place, the one that was chosen least often to fly home, and of several the one nearest
    /// to a direction.
    pub(crate) fn homewards(&mut self, located: &Located, ways_rad: &[f64], home_rad: f64) -> Option<usize> {
        let node = &located.map.nodes[located.node];
        let chosen = |bearing_rad: f64| self.count(node, bearing_rad, Noted::Homewards);
        let off_rad = |bearing_rad: f64| wrap_angle_rad(bearing_rad - home_rad).abs();
        let rank = |way: &usize| (chosen(ways_rad[*way]), off_rad(ways_rad[*way]));
        let way = (0..ways_rad.len()).min_by(|a, b| rank(a).partial_cmp(&rank(b)).unwrap_or(Ordering::Equal))?;
        self.note(WayEnd::new(located, ways_rad[way]), Noted::Homewards);
        Some(way)
    }

    /// How often something was noted of a way of a place.
    fn count(&self, node: &Node, bearing_rad: f64, noted: Noted) -> usize {
        self.notes.iter().filter(|(way, of)| *of == noted && way.is_of(node, bearing_rad)).count()
    }

    /// What a planner is to know. `in_view` are the ways of the present place in the frame of the map.
    /// `trail_m`: where the vehicle was, on the map.
    pub(crate) fn known(
        &self,
        located: &Located,
        trail_m: &[Point2<f64>],
        in_view: &[Way],
        heading_rad: f64,
    ) -> PlannerMap {
        let nodes = located.map.nodes.iter().enumerate();
        let mut places: Vec<KnownPlace> = nodes
            .map(|(number, node)| KnownPlace {
                kind: node.kind,
                position_m: node.position_m,
                ways: node.ways.iter().map(|way| self.way(located, trail_m, number, way)).collect(),
            })
            .collect();
        if let Some((place, way)) = self.half_flown(&located.map, trail_m) {
            places[place].ways[way].state = WayState::New;
        }
        let here = &mut places[located.node];
        let known = here.ways.len();
        for way in in_view.iter().filter(|_| here.kind == HereKind::Junction) {
            let is_other = |known: &KnownWay| wrap_angle_rad(known.bearing_rad - way.bearing_rad).abs() > OTHER_WAY_RAD;
            if here.ways[..known].iter().all(is_other) {
                let unseen =
                    NodeWay { bearing_rad: way.bearing_rad, width_m: way.width_m, taken: false, passage: None };
                let state = self.state(&located.map.nodes[located.node], &unseen, trail_m);
                here.ways.push(KnownWay { bearing_rad: way.bearing_rad, state, leads_to: None });
            }
        }
        PlannerMap { places, here: located.node, heading_rad }
    }

    fn way(&self, located: &Located, trail_m: &[Point2<f64>], number: usize, way: &NodeWay) -> KnownWay {
        let passage = way.passage.map(|passage| &located.map.passages[passage]);
        KnownWay {
            bearing_rad: way.bearing_rad,
            state: self.state(&located.map.nodes[number], way, trail_m),
            leads_to: passage.map(|of| (if of.from == number { of.to } else { of.from }, of.length_m)),
        }
    }

    /// The way of the first place of which nothing but the part from the start on was flown, if the passage leads on behind the
    /// start: the place and the way.
    fn half_flown(&self, map: &Map, trail_m: &[Point2<f64>]) -> Option<(usize, usize)> {
        let place = map.first_visited().filter(|_| self.begins_midway)?;
        let node = &map.nodes[place];
        let reach_m = node.ways.iter().map(mouth_m).fold(0.0, f64::max);
        let came = trail_m.iter().map(|place_m| place_m - node.position_m).find(|from| from.norm() < reach_m)?;
        let off_rad = |way: &usize| wrap_angle_rad(node.ways[*way].bearing_rad - came.y.atan2(came.x)).abs();
        let way = (0..node.ways.len()).min_by(|a, b| off_rad(a).total_cmp(&off_rad(b)))?;
        let begins_outside = trail_m.first().is_some_and(|start_m| (start_m - node.position_m).norm() >= reach_m);
        let is_open =
            node.ways[way].passage.is_none() && self.count(node, node.ways[way].bearing_rad, Noted::Taken) == 0;
        (begins_outside && is_open).then_some((place, way))
    }

    fn state(&self, node: &Node, way: &NodeWay, trail_m: &[Point2<f64>]) -> WayState {
        let count = |noted: Noted| self.count(node, way.bearing_rad, noted);
        if way.taken || count(Noted::Taken) > 0 || is_on_trail(node.position_m, way, trail_m) {
            WayState::Taken
        } else if count(Noted::Failed) >= MOST_TRIES {
            WayState::Blocked
        } else if count(Noted::Ended) > 0 {
            WayState::Ended
        } else {
            WayState::New
        }
    }
}

/// How far the mouth of a way is from its place.
fn mouth_m(way: &NodeWay) -> f64 {
    (1.4 * way.width_m).clamp(1.5, 9.0)
}

/// Whether a trail leads through the mouth of a way and on, there or back: the place may be on the map twice. Up to the mouth is
/// not through it: a decision may be taken there, and a flight may begin there.
fn is_on_trail(place_m: Point2<f64>, way: &NodeWay, trail_m: &[Point2<f64>]) -> bool {
    let mouth_m = mouth_m(way);
    let within_m = 0.3 * way.width_m.min(5.0) + 0.3;
    let at_m = place_m + unit(way.bearing_rad) * mouth_m;
    let off_m = |passed_m: &Point2<f64>| (passed_m - place_m).norm();
    let leads_on = |run_m: &mut dyn Iterator<Item = &Point2<f64>>| {
        run_m.map(off_m).take_while(|off_m| *off_m > mouth_m - within_m).any(|off_m| off_m > mouth_m + BEYOND_MOUTH_M)
    };
    let in_mouth = (0..trail_m.len()).filter(|at| (trail_m[*at] - at_m).norm() < within_m);
    in_mouth.into_iter().any(|at| leads_on(&mut trail_m[at..].iter()) || leads_on(&mut trail_m[..at].iter().rev()))
}

/// The ways of a place, turned from the body frame into that of the map.
pub(crate) fn in_map(ways: &[Way], pose: &Isometry2<f64>, correction: &Isometry2<f64>) -> Vec<Way> {
    let turn_rad = pose.rotation.angle() + correction.rotation.angle();
    ways.iter().map(|way| Way { bearing_rad: wrap_angle_rad(way.bearing_rad + turn_rad), ..*way }).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crosscut_flight::Passage;

    /// Three junctions in a row; by the map the first leads to the second. The vehicle is in the first.
    pub(crate) fn in_a_row() -> Located {
        let way = |bearing_rad: f64| NodeWay { bearing_rad, width_m: 3.0, taken: true, passage: None };
        let node = |number: u64| Node {
            kind: HereKind::Junction,
            position_m: Point2::new(20.0 * number as f64, 0.0),
            ways: [0.0, 1.6, 3.1].map(way).to_vec(),
            visits: vec![[number, number]],
        };
        let mut map = Map { nodes: (0..3).map(node).collect(), ..Map::default() };
        let passage = Passage {
            from: 0,
            to: 1,
            length_m: 20.0,
            length_sd_m: None,
            width_m: 3.0,
            stretch_ns: [0; 2],
            via_m: Vec::new(),
        };
        map.passages.push(passage);
        (map.nodes[0].ways[0].passage, map.nodes[1].ways[2].passage) = (Some(0), Some(0));
        Located { map, node: 0, correction: Isometry2::identity(), visits: Vec::new() }
    }

    #[test]
    fn a_way_home_that_led_back_is_not_taken_again_before_the_others() {
        let (located, mut chart) = (in_a_row(), Chart::default());
        let mut taken = || chart.homewards(&located, &[0.0, 1.6, 3.1], 1.0);
        assert_eq!([taken(), taken(), taken(), taken()], [Some(1), Some(0), Some(2), Some(1)]);
    }

    /// Places of a trail along x, 0.4 m apart.
    fn along_x(from_m: f64, to_m: f64) -> Vec<Point2<f64>> {
        let steps = ((to_m - from_m).abs() / 0.4) as i32;
        (0..=steps).map(|step| Point2::new(from_m + (to_m - from_m).signum() * 0.4 * f64::from(step), 0.0)).collect()
    }

    #[test]
    fn a_trail_up_to_a_mouth_does_not_lead_through_it() {
        let way = NodeWay { bearing_rad: 0.0, width_m: 3.0, taken: false, passage: None };
        let there_and_back = [along_x(0.0, 7.0), along_x(7.0, 0.0)].concat();
        for (trail_m, is_through) in [
            (along_x(0.0, 12.0), true),
            (along_x(12.0, 0.0), true),
            (there_and_back, false),
            (along_x(7.0, 30.0), false),
        ] {
            assert_eq!(is_on_trail(Point2::origin(), &way, &trail_m), is_through, "{:?}", trail_m.first());
        }
    }

    #[test]
    fn a_way_flown_from_a_start_midway_alone_is_new() {
        let located = in_a_row();
        let mut chart = Chart::default();
        let state = |chart: &Chart, from_m: f64| {
            let known = chart.known(&located, &along_x(from_m, 20.0), &[], 0.0);
            known.places[0].ways[2].state
        };
        assert_eq!(state(&chart, -20.0), WayState::Taken);
        chart.begins_midway = true;
        assert_eq!(state(&chart, -20.0), WayState::New);
        assert_eq!(state(&chart, 1.0), WayState::Taken, "the start is within the place");
        chart.note(WayEnd::new(&located, 3.1), Noted::Taken);
        assert_eq!(state(&chart, -20.0), WayState::Taken);
    }
}
