//! The differences between two configurations over flights.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::{Agreement, Proportion};

/// The sum of agreements of consecutive revolutions.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Differences {
    /// Revolutions that only the first answered, and those that only the second answered. No other figure counts them.
    pub answered_by_one: [u64; 2],
    /// Share of the revolutions with the same count.
    pub same_count: Proportion,
    /// Share of the revolutions with the same number of zero eigenvalues.
    pub same_k: Proportion,
    /// Share of the revolutions with the same walls.
    pub same_walls: Proportion,
    /// Share of the returns with the same label.
    pub returns_alike: Proportion,
    /// Openings of the first answer that the second lacks, of all of the first.
    pub openings_lacking: Proportion,
    /// Openings of the second answer that the first lacks, of all of the second.
    pub openings_more: Proportion,
    /// Ways on of the first answer that the second lacks, of all of the first.
    #[serde(skip_serializing_if = "Proportion::is_of_none")]
    pub ways_lacking: Proportion,
    /// Ways on of the second answer that the first lacks, of all of the second.
    #[serde(skip_serializing_if = "Proportion::is_of_none")]
    pub ways_more: Proportion,
    /// Number of revolutions by the two counts.
    #[serde(skip)]
    pub counts: BTreeMap<[usize; 2], u64>,
    /// The stretches where walls or ways on differ, flight by flight, in order.
    pub stretches: Vec<Stretch>,
    /// Whether the last revolution differed, so that the next one may extend its stretch.
    #[serde(skip)]
    is_differing: bool,
}

/// Consecutive revolutions with the same counts and with walls or ways on that differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stretch {
    /// The flight that they are of.
    pub flight: String,
    /// First and last revolution.
    pub seq: [u64; 2],
    /// Their stamps.
    pub stamp_ns: [u64; 2],
    /// Number of revolutions.
    pub revolutions: u64,
    /// The count of each configuration. If they are equal, the walls or ways differ.
    pub junctions: [usize; 2],
    /// The number of ways on of each configuration, where both count these.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ways: Option<[usize; 2]>,
    /// The least confidence of each configuration; `None` if it has none.
    pub confidence: [Option<f64>; 2],
}

impl Differences {
    /// Adds the next revolution of the flight.
    pub fn add(&mut self, agreement: &Agreement) {
        let [first, second] = agreement.junctions;
        self.same_count.count(first == second);
        self.same_k.count(agreement.k[0] == agreement.k[1]);
        self.same_walls.count(agreement.same_walls);
        self.returns_alike.merge(Proportion { hits: agreement.same_returns as u64, of: agreement.returns as u64 });
        let openings = &agreement.openings;
        let unmatched = |of: usize| Proportion { hits: (of - openings.matched.len()) as u64, of: of as u64 };
        self.openings_lacking.merge(unmatched(openings.truth));
        self.openings_more.merge(unmatched(openings.reported));
        if let Some(([first, second], both)) = agreement.ways {
            self.ways_lacking.merge(Proportion { hits: (first - both) as u64, of: first as u64 });
            self.ways_more.merge(Proportion { hits: (second - both) as u64, of: second as u64 });
        }
        *self.counts.entry(agreement.junctions).or_default() += 1;
        if !agreement.is_same() {
            self.extend_stretch(agreement);
        }
        self.is_differing = !agreement.is_same();
    }

    /// Adds the differences over another flight of this name.
    pub fn merge(&mut self, other: Self, flight: &str) {
        (0..2).for_each(|side| self.answered_by_one[side] += other.answered_by_one[side]);
        self.same_count.merge(other.same_count);
        self.same_k.merge(other.same_k);
        self.same_walls.merge(other.same_walls);
        self.returns_alike.merge(other.returns_alike);
        self.openings_lacking.merge(other.openings_lacking);
        self.openings_more.merge(other.openings_more);
        self.ways_lacking.merge(other.ways_lacking);
        self.ways_more.merge(other.ways_more);
        other.counts.into_iter().for_each(|(pair, revolutions)| *self.counts.entry(pair).or_default() += revolutions);
        self.stretches.extend(other.stretches.into_iter().map(|of| Stretch { flight: flight.to_owned(), ..of }));
        self.is_differing = false;
    }

    fn extend_stretch(&mut self, agreement: &Agreement) {
        let ways = agreement.ways.map(|(ways, _)| ways);
        match self.stretches.last_mut() {
            Some(last) if self.is_differing && (last.junctions, last.ways) == (agreement.junctions, ways) => {
                last.seq[1] = agreement.seq;
                last.stamp_ns[1] = agreement.stamp_ns;
                last.revolutions += 1;
                let least = |side: usize| Some(last.confidence[side]?.min(agreement.confidence[side]?));
                last.confidence = [least(0), least(1)];
            }
            _ => self.stretches.push(Stretch {
                flight: String::new(),
                seq: [agreement.seq; 2],
                stamp_ns: [agreement.stamp_ns; 2],
                revolutions: 1,
                junctions: agreement.junctions,
                ways,
                confidence: agreement.confidence,
            }),
        }
    }
}
