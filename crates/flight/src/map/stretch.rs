//! Where a stretch of the flight lies to which no known way leads: where several of its visits agree on it.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry2, Point2};

use super::candidate::{ANCHORS_M, Candidate, turns_rad};
use super::draft::{Draft, Guess, Stray};
use super::legs::{Leg, groups};

/// A place to which no known way leads is thought of from this share on.
const GUESSED_SHARE: f64 = 0.85;

/// A placement of a stretch needs this many other places in support.
const AGREED_PLACES: usize = 2;

/// A placement of a stretch needs this many more places in support than any rival: along a row of places that look alike, all but
/// one support a placement that is shifted by one place.
const AGREED_LEAD: usize = 2;

/// Two visits agree on the heading of a stretch within this.
const AGREED_RAD: f64 = 0.15;

/// Places of other groups than that of a visit.
#[derive(Default)]
pub(super) struct Elsewhere {
    /// Each with its group. Of groups that have enough places to show where a stretch lies.
    many: Vec<(usize, u32)>,
    /// Of groups of [`AGREED_PLACES`], which may but contradict: what one of these would have, the stretch has to have more of.
    pairs: Vec<(usize, u32)>,
}

impl Draft {
    /// The places to which no known way leads.
    pub(super) fn elsewhere(&self, flown: &[Leg], but: Option<usize>) -> Elsewhere {
        let groups = groups(&self.graph, &self.flown);
        let mut sizes: BTreeMap<u32, usize> = BTreeMap::new();
        for place in &self.places {
            *sizes.entry(groups[place.first_visit]).or_default() += 1;
        }
        let mut elsewhere = Elsewhere::default();
        for (node, place) in self.places.iter().enumerate() {
            if Some(node) == but || flown[place.first_visit].sd_m.is_some() {
                continue;
            }
            let group = groups[place.first_visit];
            match sizes[&group] {
                more if more > AGREED_PLACES => elsewhere.many.push((node, group)),
                AGREED_PLACES => elsewhere.pairs.push((node, group)),
                _ => {}
            }
        }
        elsewhere
    }

    /// Of places that a visit may be to although no known way leads there: the one that agrees with what other visits since
    /// may have been to. Three places in their right relation are no chance, unless places stand in a row; one may look like many.
    pub(super) fn place_stretch(&mut self, visit: Stray, elsewhere: &Elsewhere) -> Option<Candidate> {
        let place_m = Point2::from(visit.anchor.translation.vector);
        let (candidates, made): (Vec<Candidate>, Vec<Guess>) =
            self.resembling(&visit, &elsewhere.many).into_iter().unzip();
        let agrees = |of: &&Guess| self.agreeing(of, &place_m) >= AGREED_PLACES;
        let found = match made.iter().enumerate().filter(|(_, of)| agrees(of)).collect::<Vec<_>>()[..] {
            [(at, of)] => {
                let strays = std::mem::take(&mut self.strays);
                let rivals = strays.iter().flat_map(|stray| self.resembling(stray, &elsewhere.pairs));
                let rivals: Vec<Guess> = rivals.map(|(_, guess)| guess).collect();
                self.guesses.extend(rivals);
                self.has_clear_lead(of, &place_m).then_some(at)
            }
            _ => None,
        };
        if let Some(at) = found {
            self.guesses.clear();
            self.strays.clear();
            return candidates.into_iter().nth(at);
        }
        self.guesses.extend(made);
        self.strays.push(visit);
        None
    }

    /// Of places to which no known way leads, those that a visit may be to, each with where its stretch then lies.
    fn resembling(&self, visit: &Stray, places: &[(usize, u32)]) -> Vec<(Candidate, Guess)> {
        let of_kind = places.iter().filter(|(node, _)| self.map.nodes[*node].kind == visit.kind);
        let resembling = of_kind.flat_map(|&(node, group)| {
            let place = &self.places[node];
            let fits = turns_rad(&visit.bearings_rad, &place.ways_rad)
                .filter_map(|rad| place.walls.fit(&visit.walls, &Isometry2::rotation(rad)));
            fits.filter(|fit| fit.share >= GUESSED_SHARE).map(move |fit| {
                let stretch = self.graph.poses[place.first_visit] * fit.pose * visit.anchor.inverse();
                (Candidate { node, fit }, Guess { node, group, stretch })
            })
        });
        resembling.collect()
    }

    /// How many other places other visits may be to if the stretch lies where a guess has it.
    fn agreeing(&self, of: &Guess, place_m: &Point2<f64>) -> usize {
        let others = self.guesses.iter().filter(|other| other.node != of.node && of.is_one(other, place_m));
        others.map(|other| other.node).collect::<BTreeSet<_>>().len()
    }

    /// Whether more places agree on a guess than on any other.
    fn has_clear_lead(&self, of: &Guess, place_m: &Point2<f64>) -> bool {
        let agreeing = self.agreeing(of, place_m);
        let mut rivals = self.guesses.iter().filter(|other| !of.is_one(other, place_m));
        rivals.all(|rival| agreeing >= self.agreeing(rival, place_m) + AGREED_LEAD)
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
