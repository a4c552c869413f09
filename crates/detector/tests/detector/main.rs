//! The door, the configuration, and whole scans through two solvers and through the default method.

mod config;
mod door;
mod doubt;
mod scenes;
mod slicing;
mod symmetry;
mod ways;
