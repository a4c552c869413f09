//! Every assignment against values worked out by hand, and what all of them promise.

mod components;
mod conformance;
mod embeddings;
mod kmeans_plus_plus;
