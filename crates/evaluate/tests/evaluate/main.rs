//! Scores, sums and comparisons of answers made by hand.

mod agreement;
mod figures;
mod scans;
mod score;
