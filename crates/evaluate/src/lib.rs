//! Compares results with truth: how often the answer is right, and how large its errors are.
//!
//! In: pairs of a [`Truth`](crosscut_messages::Truth) and the [`ResultsLine`](crosscut_report::ResultsLine) of the same
//! scan, from a recording (where they share a log time), a simulator or anywhere else ([`Score::of`]). Out: an
//! [`Evaluation`] per family and configuration ([`Scoreboard`]), its [`Figures`], [`tables`] and [`chart`]s. No I/O.
//!
//! # Definitions
//!
//! The label of a beam is the wall that it hits. T_a are the beams of wall a by the truth, R_b those of wall b by the
//! result; islands (pillars) have labels like walls.
//!
//! A revolution is **right** if both hold:
//! ```text
//! junctions = true walls                                      (islands are in neither)
//! |{(a, b) : |T_a ∩ R_b| / |T_a ∪ R_b| >= 0.8}| = true walls  (b no island)
//! ```
//! Two walls of one side share no beam, so above 1/2 no wall is in two pairs: the pairs are a complete one-to-one
//! matching. Islands need not be found. The truth does not mark which of its labels are islands; where it has some, a
//! pillar reported as a wall can replace a true wall if the count happens to be equal. A true wall without any return
//! cannot be matched, so a revolution with such a wall is never right.
//!
//! **Right count**, **over-count**, **under-count**: junctions =, >, < true walls. The confusion matrix has them all.
//! Shares have Wilson's 95 % interval ([`Proportion::interval95`]), which assumes independent revolutions; those of a
//! flight are not, so there the interval is too narrow.
//!
//! **Returns right**: over beams that have a return by the truth or belong to a wall by the result,
//! ```text
//! (max_M Σ_a |T_a ∩ R_M(a)| + |{dust in no wall}|) / |those beams|
//! ```
//! with M a one-to-one matching of all walls and islands, exact by the Hungarian method. Three labels are wrong: dust
//! (truth label -2) in a wall, a return of a true wall in no wall, and a beam without return in a wall.
//!
//! **Adjusted Rand index**, over the returns of true walls, with n_ab = |T_a ∩ R_b|; returns in no wall are one more
//! group b:
//! ```text
//! (Σ_ab C(n_ab, 2) - E) / ((A + B)/2 - E),  A = Σ_a C(n_a, 2),  B = Σ_b C(n_b, 2),  E = A·B / C(n, 2)
//! ```
//! It is defined for at least two true walls: with one, a single return split off would make it 0.
//!
//! **Openings** are matched one-to-one within 15° of bearing, as many as possible, then with the smallest sum of
//! errors. *Missed*: share of the true openings without a match; *false*: share of the reported ones without a match.
//! Bearing errors are absolute (rad), width errors absolute and relative to the true width, both of matched openings.
//!
//! **Confidence**: number and share of right answers by tenths of confidence; the share of answers that are sure
//! (0.9 and above) and the share of right ones among them; AUROC = P(c_right > c_wrong) + P(c_right = c_wrong) / 2.
//!
//! Percentiles are by nearest rank. A sum over families weights every revolution equally, not every family.
//!
//! **Two configurations without a truth**: [`Agreement`] compares two answers to the same scan by these measures, with
//! the first as truth. [`Differences`] sums them over flights and lists the stretches where the walls differ.
//!
//! **A verdict**: [`experiment`] says what a configuration mends and breaks against another one, and how likely that is by
//! chance ([`verdict`]); [`times`] how much longer it takes.
//!
//! **One configuration without a truth**: [`flips`] are the revolutions whose count differs from most of their
//! neighbours.
//!
//! # Example
//!
//! ```
//! use crosscut_evaluate::{Scoreboard, Score, tables};
//! use crosscut_messages::Truth;
//! # fn line(labels: Vec<i32>) -> Result<crosscut_report::ResultsLine, serde_json::Error> {
//! #     let text = serde_json::json!({"seq": 0, "stamp_ns": 0, "returns": 5, "junctions": 2, "k": 2, "margin": 1.0,
//! #         "confidence": 0.9, "place": "corridor", "eigenvalues": [], "walls": [], "openings": [], "labels": labels,
//! #         "notes": []});
//! #     serde_json::from_value(text)
//! # }
//!
//! let truth = Truth { walls: 2, labels: vec![0, 0, -1, 1, 1, -2], ..Truth::default() };
//! let answer = line(vec![1, 1, -1, 0, 0, 0])?; // other wall numbers, and dust in one wall
//!
//! let mut scoreboard = Scoreboard::new(vec!["default".to_owned()]);
//! let score = Score::of(&truth, &answer)?;
//! assert_eq!((score.right_count(), score.right), (true, false)); // 2 of 3 beams shared: less than 0.8
//! assert_eq!((score.returns_right, score.returns), (4, 5));
//! scoreboard.add("dust", 0, &score);
//! assert_eq!(tables::overview(&scoreboard)[1].rows[0], ["dust", "1", "100.0"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! To add a figure, add a field of [`Score`] for one revolution, of [`Evaluation`] for the sum and of [`Figures`] for the
//! result, and a column in [`tables`].

mod agreement;
mod assignment;
pub mod chart;
mod confidence;
mod contingency;
mod differences;
mod evaluation;
pub mod experiment;
pub mod flights;
mod flips;
pub mod maps;
mod openings;
pub mod panel;
mod percentiles;
mod proportion;
mod score;
mod scoreboard;
pub mod stage_values;
pub mod tables;
pub mod times;
pub mod tolerance;
mod variants;
pub mod verdict;

pub use agreement::Agreement;
pub use confidence::{BINS, Confidence, ReliabilityBin};
pub use crosscut_stage::SURE;
pub use differences::{Differences, Stretch};
pub use evaluation::{Confusion, Evaluation, Figures, Labels, Openings};
pub use flips::{AROUND, Flip, flips};
pub use openings::{MatchedOpening, OpeningsScore, SAME_OPENING_RAD};
pub use percentiles::Percentiles;
pub use proportion::Proportion;
pub use score::{SAME_WALL_IOU, Score, ScoreError};
pub use scoreboard::{Family, Scoreboard};
pub use variants::{Variants, settings_of_step};
