//! Where a stretch of the flight lies to which no known way leads: where several of its visits agree on it.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use nalgebra::{Isometry2, Point2};

use super::Mapper;
use super::flown::Flown;
use super::outline::Walls;
use super::recognise::{ANCHORS_M, Candidate, turns_rad};
use crate::HereKind;

/// A place to which no known way leads is thought of from this share on.
const GUESSED_SHARE: f64 = 0.85;

/// This many other places have to agree, and this many more than on the stretch lying elsewhere: along a row of places that look
/// alike, shifted by one, all but one agree.
const AGREED_PLACES: usize = 2;
const AGREED_LEAD: usize = 2;

/// Where two visits take a stretch to lie agrees within this.
const AGREED_RAD: f64 = 0.15;

/// Where a stretch lies if a visit of it was to a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guess {
    pub(super) node: usize,
    /// The number of the node's [group](Mapper::groups): how the places of two groups lie to each other is not known, so that
    /// they do not agree.
    group: usize,
    /// Brings tracked poses into the map's frame.
    stretch: Isometry2<f64>,
}

/// A visit to a place that was not recognised, as it is compared with places of other groups.
#[derive(Clone, Debug)]
pub(super) struct Stray {
    pub(super) kind: HereKind,
    pub(super) anchor: Isometry2<f64>,
    pub(super) bearings_rad: Vec<f64>,
    pub(super) walls: Arc<Walls>,
}

/// Places of other groups than that of a visit.
#[derive(Default)]
pub(super) struct Elsewhere {
    /// Each with its group. Of groups that have enough places to show where a stretch lies.
    many: Vec<(usize, usize)>,
    /// Of groups of [`AGREED_PLACES`], which may but contradict: what one of these would have, the stretch has to have more of.
    pairs: Vec<(usize, usize)>,
}

impl Mapper {
    /// The places to which no known way leads.
    pub(super) fn elsewhere(&self, flown: &[Flown], but: Option<usize>) -> Elsewhere {
        let groups = self.groups();
        let mut sizes: BTreeMap<usize, usize> = BTreeMap::new();
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
    pub(super) fn agreed(&mut self, visit: Stray, elsewhere: &Elsewhere) -> Option<Candidate> {
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
                self.leads(of, &place_m).then_some(at)
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
    fn resembling(&self, visit: &Stray, places: &[(usize, usize)]) -> Vec<(Candidate, Guess)> {
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
    fn leads(&self, of: &Guess, place_m: &Point2<f64>) -> bool {
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
