//! Configuration and streaming, with stages that count, fail and panic on command; whole scans through two solvers, and
//! through the default method.

mod config;
mod scenes;
mod slicing;
mod stages;
mod streaming;
mod symmetry;
