//! Every solver against a decomposition of the tests' own, and what all of them promise.

mod blocks;
mod conformance;
mod graphs;
mod slicing;
mod solving;
