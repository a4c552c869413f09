//! The figures over many revolutions.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::{Confidence, Percentiles, Proportion, Score};

/// Collected scores of any number of revolutions, in any order and from any source.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evaluation {
    right: Proportion,
    /// Revolutions by (true, reported) number of walls.
    counts: BTreeMap<(usize, usize), u64>,
    returns: u64,
    returns_right: u64,
    rand_indices: Vec<f64>,
    missed: Proportion,
    false_alarms: Proportion,
    seen_false: Proportion,
    judged_gaps: Proportion,
    bearing_errors_rad: Vec<f64>,
    width_errors: Vec<f64>,
    answers: Vec<(f64, bool)>,
}

/// The figures of an [`Evaluation`]. The crate's page defines each figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Revolutions that were compared.
    pub revolutions: u64,
    /// Share of them that are right: count equal, every true wall matched.
    pub right: Proportion,
    /// Share with the right count.
    pub right_count: Proportion,
    /// Share with too large a count.
    pub over_count: Proportion,
    /// Share with too small a count.
    pub under_count: Proportion,
    /// The nonzero entries of the confusion matrix of the counts, by true, then reported count.
    pub confusion: Vec<Confusion>,
    /// Figures of the labels.
    pub labels: Labels,
    /// Figures of the openings.
    pub openings: Openings,
    /// Figures of the confidence.
    pub confidence: Confidence,
}

/// An entry of the confusion matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Confusion {
    /// True number of walls.
    pub truth: usize,
    /// Reported number of walls.
    pub reported: usize,
    /// Number of revolutions with these counts.
    pub revolutions: u64,
}

/// Figures of the labels of returns.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Labels {
    /// Returns that were compared.
    pub returns: u64,
    /// Returns with the right label.
    pub returns_right: u64,
    /// Share of the returns with the right label; `None` without returns.
    pub share: Option<f64>,
    /// Adjusted Rand index per revolution, over revolutions with at least two walls.
    pub adjusted_rand_index: Option<Percentiles>,
}

/// Figures of the openings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Openings {
    /// True openings that were not reported.
    pub missed: Proportion,
    /// Reported openings that are not there.
    #[serde(rename = "false")]
    pub false_alarms: Proportion,
    /// Reported openings that are seen through and not there.
    pub seen_false: Proportion,
    /// Gaps, openings and closed ones, that are judged: neither seen through nor proved to be closed.
    pub judged_gaps: Proportion,
    /// Absolute error of the bearings of matched openings, rad.
    pub bearing_error_rad: Option<Percentiles>,
    /// Relative error of the widths of matched openings.
    pub width_error: Option<Percentiles>,
}

impl Evaluation {
    /// Adds a revolution.
    pub fn add(&mut self, score: &Score) {
        self.right.count(score.right);
        *self.counts.entry((score.true_walls, score.reported_walls)).or_default() += 1;
        self.returns += score.returns as u64;
        self.returns_right += score.returns_right as u64;
        self.rand_indices.extend(score.adjusted_rand_index);
        let (openings, matched) = (&score.openings, score.openings.matched.len());
        self.missed.merge(Proportion { hits: (openings.truth - matched) as u64, of: openings.truth as u64 });
        self.false_alarms
            .merge(Proportion { hits: (openings.reported - matched) as u64, of: openings.reported as u64 });
        let seen_there = openings.matched.iter().filter(|opening| opening.is_seen).count();
        self.seen_false.merge(Proportion { hits: (openings.seen - seen_there) as u64, of: openings.seen as u64 });
        let gaps = score.gaps;
        self.judged_gaps.merge(Proportion { hits: gaps.judged, of: gaps.seen + gaps.proved + gaps.judged });
        self.bearing_errors_rad.extend(openings.matched.iter().map(|opening| opening.bearing_error_rad));
        self.width_errors.extend(openings.matched.iter().filter_map(|opening| opening.width_error));
        self.answers.extend(score.confidence.map(|confidence| (confidence, score.right)));
    }

    /// Adds all revolutions of `other`.
    pub fn merge(&mut self, other: &Self) {
        self.right.merge(other.right);
        for (&counts, &revolutions) in &other.counts {
            *self.counts.entry(counts).or_default() += revolutions;
        }
        self.returns += other.returns;
        self.returns_right += other.returns_right;
        self.rand_indices.extend(&other.rand_indices);
        self.missed.merge(other.missed);
        self.false_alarms.merge(other.false_alarms);
        self.seen_false.merge(other.seen_false);
        self.judged_gaps.merge(other.judged_gaps);
        self.bearing_errors_rad.extend(&other.bearing_errors_rad);
        self.width_errors.extend(&other.width_errors);
        self.answers.extend(&other.answers);
    }

    /// Number of revolutions.
    pub fn revolutions(&self) -> u64 {
        self.right.of
    }

    /// Computes the figures.
    pub fn figures(&self) -> Figures {
        let counted = |is: fn(usize, usize) -> bool| Proportion {
            hits: self.counts.iter().filter(|&(&(truth, reported), _)| is(truth, reported)).map(|(_, n)| n).sum(),
            of: self.right.of,
        };
        let confusion =
            self.counts.iter().map(|(&(truth, reported), &revolutions)| Confusion { truth, reported, revolutions });
        Figures {
            revolutions: self.right.of,
            right: self.right,
            right_count: counted(|truth, reported| reported == truth),
            over_count: counted(|truth, reported| reported > truth),
            under_count: counted(|truth, reported| reported < truth),
            confusion: confusion.collect(),
            labels: Labels {
                returns: self.returns,
                returns_right: self.returns_right,
                share: Proportion { hits: self.returns_right, of: self.returns }.value(),
                adjusted_rand_index: Percentiles::of(&self.rand_indices),
            },
            openings: Openings {
                missed: self.missed,
                false_alarms: self.false_alarms,
                seen_false: self.seen_false,
                judged_gaps: self.judged_gaps,
                bearing_error_rad: Percentiles::of(&self.bearing_errors_rad),
                width_error: Percentiles::of(&self.width_errors),
            },
            confidence: Confidence::of(&self.answers),
        }
    }
}
