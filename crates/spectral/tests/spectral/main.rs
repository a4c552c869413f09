//! Every solver against a decomposition of the tests' own, and what all of them promise.

mod blocks;
mod conformance;
mod graphs;
mod independent;
mod slicing;
mod solving;
