//! Results against truth: how often the answer is right, and how far off it is where it is not.
//!
//! In: pairs of a [`Truth`](crosscut_messages::Truth) and the [`ResultsLine`](crosscut_report::ResultsLine) of the same
//! scan, from a recording (where they share a log time), a simulator or anywhere else ([`Score::of`]). Out: an
//! [`Evaluation`] per family and configuration ([`Scoreboard`]), its [`Figures`], and [`tables`]. No I/O.
//!
//! # Definitions
//!
//! A label per beam says which wall it meets. T_a are the beams that the truth gives to wall a, R_b those that the
//! result gives to wall b; islands (pillars) have labels like walls.
//!
//! **Right** is a revolution if both hold:
//! ```text
//! junctions = true walls                                      (islands are in neither)
//! |{(a, b) : |T_a ∩ R_b| / |T_a ∪ R_b| >= 0.8}| = true walls  (b no island)
//! ```
//! Walls of one side share no beam, so above 1/2 no wall is in two pairs: this *is* a one-to-one matching, and it is
//! complete. Islands need not be found. A truth does not tell which of its labels are islands; where it has some, a
//! pillar reported as a wall can therefore stand in for a true wall, if the count comes out equal all the same.
//! A true wall of which every return was lost can be matched by nothing, so such a revolution is never right.
//!
//! **Right count**, **over-count**, **under-count**: junctions =, >, < true walls. The confusion matrix has them all.
//! Shares come with Wilson's 95 % interval ([`Share::interval95`]), which takes revolutions for independent of each
//! other; in a flight they are not, and the interval is too narrow.
//!
//! **Returns right**: over beams that have a return by the truth or that the result puts into a wall,
//! ```text
//! (max_M Σ_a |T_a ∩ R_M(a)| + |{dust put into no wall}|) / |those beams|
//! ```
//! with M a one-to-one matching of all walls and islands, exact by the Hungarian method. Dust (truth label -2) that is
//! put into a wall is wrong, so is a return of a wall that was left out, so is a wall where nothing came back.
//!
//! **Adjusted Rand index**, over the returns of true walls, with n_ab = |T_a ∩ R_b|, those put into no wall being a
//! group b of their own:
//! ```text
//! (Σ_ab C(n_ab, 2) - E) / ((A + B)/2 - E),  A = Σ_a C(n_a, 2),  B = Σ_b C(n_b, 2),  E = A·B / C(n, 2)
//! ```
//! Only for two true walls and more: with one, a single return split off makes it 0.
//!
//! **Openings** are matched one-to-one within 15° of bearing, as many as possible, then with the smallest sum of
//! errors. *Missed*: true ones without a match, of the true ones; *false*: reported ones without, of the reported.
//! Bearing errors are absolute (rad), width errors absolute and relative to the true width, both of matched openings.
//!
//! **Confidence**: answers and the share of right ones by tenths of confidence; the share of answers that are sure
//! (0.9 and above) and how many of those are right; AUROC = P(c_right > c_wrong) + P(c_right = c_wrong) / 2.
//!
//! Percentiles are of the nearest rank. Families together count revolution by revolution, not family by family.
//!
//! **Two configurations without a truth**: [`Agreement`] holds two answers for the same scan against each other by the
//! same measures, the first in the place of the truth, and [`Differences`] sums a flight up and lists the stretches
//! where the walls are not the same.
//!
//! **One configuration without a truth**: [`flips`] are the revolutions whose count is not that of most around them.
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
//! let answer = line(vec![1, 1, -1, 0, 0, 0])?; // other numbers, the same walls, and dust in one of them
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
//! To add a figure: a field of [`Score`] for one revolution, of [`Evaluation`] for the sum, of [`Figures`] for the
//! outcome, and a column in [`tables`].

mod agreement;
mod assignment;
mod confidence;
mod contingency;
mod differences;
mod evaluation;
mod openings;
mod percentiles;
mod score;
mod scoreboard;
mod share;
mod steadiness;
pub mod tables;

pub use agreement::Agreement;
pub use confidence::{BINS, Confidence, ReliabilityBin, SURE};
pub use differences::{Differences, Stretch};
pub use evaluation::{Confusion, Evaluation, Figures, Labels, Openings};
pub use openings::{MatchedOpening, OpeningsScore, SAME_OPENING_RAD};
pub use percentiles::Percentiles;
pub use score::{SAME_WALL_IOU, Score, ScoreError};
pub use scoreboard::{Family, Scoreboard};
pub use share::Share;
pub use steadiness::{AROUND, Flip, flips};
