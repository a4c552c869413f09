//! Scores, sums and comparisons of answers made by hand.

mod agreement;
mod figures;
mod maps;
mod scans;
mod score;
