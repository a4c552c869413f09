//! Every affinity against values worked out by hand, and what all of them promise.

mod breakpoint;
mod conformance;
mod dbscan;
mod passage;
mod passage_clouds;
mod rbf;
mod threshold;
