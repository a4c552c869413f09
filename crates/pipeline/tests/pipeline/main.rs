//! Configuration and streaming, with stages that count, fail and panic on command; and whole scans through two solvers.

mod config;
mod slicing;
mod stages;
mod streaming;
