//! A whole flight: where two configurations answer differently.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::{Agreement, Share};

/// Agreements of consecutive revolutions, summed up.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Differences {
    /// Revolutions that the first alone answered, and those that the second alone did; they are in no other figure.
    pub answered_by_one: [u64; 2],
    /// Share of the revolutions with the same count.
    pub same_count: Share,
    /// Share with the same number of zero eigenvalues.
    pub same_k: Share,
    /// Share with the same walls, returns and all.
    pub same_walls: Share,
    /// Share of the returns that are labelled alike.
    pub returns_alike: Share,
    /// Openings of the first answer that the second lacks, of all of the first.
    pub openings_lacking: Share,
    /// Openings of the second answer that the first lacks, of all of the second.
    pub openings_more: Share,
    /// Revolutions by the two counts.
    #[serde(skip)]
    pub counts: BTreeMap<[usize; 2], u64>,
    /// Where walls differ, in the order of the flight.
    pub stretches: Vec<Stretch>,
    /// The last revolution differed, so that a stretch may go on.
    #[serde(skip)]
    differing: bool,
}

/// Consecutive revolutions with the same two counts and with walls that differ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stretch {
    /// First and last revolution.
    pub seq: [u64; 2],
    /// Their stamps.
    pub stamp_ns: [u64; 2],
    /// How many revolutions.
    pub revolutions: u64,
    /// What each configuration counts there. Equal counts: the walls are others.
    pub junctions: [usize; 2],
    /// The least confidence of each.
    pub confidence: [f64; 2],
}

impl Differences {
    /// Takes in the next revolution of the flight.
    pub fn add(&mut self, agreement: &Agreement) {
        let [first, second] = agreement.junctions;
        self.same_count.count(first == second);
        self.same_k.count(agreement.k[0] == agreement.k[1]);
        self.same_walls.count(agreement.same_walls);
        self.returns_alike.merge(Share { hits: agreement.returns_alike as u64, of: agreement.returns as u64 });
        let openings = &agreement.openings;
        let lacking = |of: usize| Share { hits: (of - openings.matched.len()) as u64, of: of as u64 };
        self.openings_lacking.merge(lacking(openings.truth));
        self.openings_more.merge(lacking(openings.reported));
        *self.counts.entry(agreement.junctions).or_default() += 1;
        if !agreement.same_walls {
            self.extend_stretch(agreement);
        }
        self.differing = !agreement.same_walls;
    }

    fn extend_stretch(&mut self, agreement: &Agreement) {
        match self.stretches.last_mut() {
            Some(last) if self.differing && last.junctions == agreement.junctions => {
                last.seq[1] = agreement.seq;
                last.stamp_ns[1] = agreement.stamp_ns;
                last.revolutions += 1;
                last.confidence = [0, 1].map(|side| last.confidence[side].min(agreement.confidence[side]));
            }
            _ => self.stretches.push(Stretch {
                seq: [agreement.seq; 2],
                stamp_ns: [agreement.stamp_ns; 2],
                revolutions: 1,
                junctions: agreement.junctions,
                confidence: agreement.confidence,
            }),
        }
    }
}
