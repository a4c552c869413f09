//! Where a stretch of the flight lies to which no known way leads: where several of its visits agree on it.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry2, Point2};

use super::candidate::{ANCHORS_M, Candidate, turns_rad};
use super::derived::Derived;
use super::legs::groups;
use super::log::{Known, Log};

/// A place to which no known way leads is thought of from this share on.
const GUESSED_SHARE: f64 = 0.85;

/// A placement of a stretch needs this many other places in support.
const AGREED_PLACES: usize = 2;

/// A placement of a stretch needs this many more places in support than any rival: along a row of places that look
/// alike, all but one support a placement that is shifted by one place.
const AGREED_LEAD: usize = 2;

/// Two visits agree on the heading of a stretch within this.
const AGREED_RAD: f64 = 0.15;

/// Where the visits of a stretch to which no known way led may have been.
#[derive(Clone, Debug, Default)]
pub(super) struct Guesses {
    made: Vec<Guess>,
    /// Visits that were not compared with all places.
    strays: Vec<usize>,
}

/// Where a stretch lies if a visit of it was to a place.
#[derive(Clone, Copy, Debug)]
struct Guess {
    /// A visit to the place.
    of: usize,
    /// The number of its [group](groups): how the places of two groups lie to each other is not known, so that they do
    /// not agree.
    group: u32,
    /// Brings tracked poses into the map's frame.
    stretch: Isometry2<f64>,
}

/// Places of other groups than that of a visit.
#[derive(Default)]
struct Elsewhere {
    /// Each with its group. Of groups that have enough places to show where a stretch lies.
    many: Vec<(usize, u32)>,
    /// Of groups of [`AGREED_PLACES`], which may but contradict: what one of these would have, the stretch has to have
    /// more of.
    pairs: Vec<(usize, u32)>,
}

/// The places to which no known way leads.
fn elsewhere(log: &Log, map: &Derived, flown: &[Known], but: Option<usize>) -> Elsewhere {
    let groups = groups(log);
    let mut sizes: BTreeMap<u32, usize> = BTreeMap::new();
    for place in &map.places {
        *sizes.entry(groups[place.first]).or_default() += 1;
    }
    let mut elsewhere = Elsewhere::default();
    for (node, place) in map.places.iter().enumerate() {
        if Some(node) == but || flown[place.first].sd_m.is_some() {
            continue;
        }
        let group = groups[place.first];
        match sizes[&group] {
            more if more > AGREED_PLACES => elsewhere.many.push((node, group)),
            AGREED_PLACES => elsewhere.pairs.push((node, group)),
            _ => {}
        }
    }
    elsewhere
}

/// Of places to which no known way leads, those that a visit may be to, each with where its stretch then lies.
fn resembling(log: &Log, map: &Derived, visit: usize, places: &[(usize, u32)]) -> Vec<(Candidate, Guess)> {
    let visit = &log.visits[visit];
    let bearings_rad = visit.bearings_rad();
    let of_kind = places.iter().filter(|(node, _)| map.map.nodes[*node].kind == visit.kind);
    let resembling = of_kind.flat_map(|&(node, group)| {
        let (of, walls) = (map.places[node].first, &log.visits[map.places[node].first].walls);
        let turns_rad: Vec<f64> = turns_rad(&bearings_rad, &map.places[node].ways_rad).collect();
        let fits = turns_rad.into_iter().filter_map(move |rad| walls.fit(&visit.walls, &Isometry2::rotation(rad)));
        fits.filter(|fit| fit.share >= GUESSED_SHARE).map(move |fit| {
            let stretch = log.graph.poses[of] * fit.pose * visit.anchor.inverse();
            (Candidate { node, fit, odds: 0.0 }, Guess { of, group, stretch })
        })
    });
    resembling.collect()
}

impl Guesses {
    /// Of places that the latest visit may be to although no known way leads there: the one that agrees with what other
    /// visits since may have been to. Three places in their right relation are no chance, unless places stand in a row;
    /// one may look like many.
    pub(super) fn place_stretch(
        &mut self,
        log: &Log,
        map: &Derived,
        flown: &[Known],
        but: Option<usize>,
    ) -> Option<Candidate> {
        let (visit, elsewhere) = (log.visits.len() - 1, elsewhere(log, map, flown, but));
        let place_m = Point2::from(log.visits[visit].anchor.translation.vector);
        let (candidates, made): (Vec<Candidate>, Vec<Guess>) =
            resembling(log, map, visit, &elsewhere.many).into_iter().unzip();
        let agrees = |of: &&Guess| self.agreeing(map, of, &place_m) >= AGREED_PLACES;
        let found = match made.iter().enumerate().filter(|(_, of)| agrees(of)).collect::<Vec<_>>()[..] {
            [(at, of)] => {
                let strays = std::mem::take(&mut self.strays);
                let rivals = strays.iter().flat_map(|&stray| resembling(log, map, stray, &elsewhere.pairs));
                self.made.extend(rivals.map(|(_, guess)| guess));
                self.has_clear_lead(map, of, &place_m).then_some(at)
            }
            _ => None,
        };
        if let Some(at) = found {
            *self = Self::default();
            return candidates.into_iter().nth(at);
        }
        self.made.extend(made);
        self.strays.push(visit);
        None
    }

    /// How many other places other visits may be to if the stretch lies where a guess has it.
    fn agreeing(&self, map: &Derived, of: &Guess, place_m: &Point2<f64>) -> usize {
        let agreeing = self.made.iter().filter(|other| of.is_one(other, place_m)).map(|other| map.node_of[other.of]);
        agreeing.filter(|&node| node != map.node_of[of.of]).collect::<BTreeSet<_>>().len()
    }

    /// Whether more places agree on a guess than on any other.
    fn has_clear_lead(&self, map: &Derived, of: &Guess, place_m: &Point2<f64>) -> bool {
        let agreeing = self.agreeing(map, of, place_m);
        let mut rivals = self.made.iter().filter(|other| !of.is_one(other, place_m));
        rivals.all(|rival| agreeing >= self.agreeing(map, rival, place_m) + AGREED_LEAD)
    }
}

impl Guess {
    /// Whether both have the stretch lie at the same place, by where they have this place of it.
    fn is_one(&self, other: &Self, place_m: &Point2<f64>) -> bool {
        let off_rad = self.stretch.rotation.angle_to(&other.stretch.rotation).abs();
        let off_m = (self.stretch * place_m - other.stretch * place_m).norm();
        self.group == other.group && off_rad < AGREED_RAD && off_m < ANCHORS_M
    }
}
