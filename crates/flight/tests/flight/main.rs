//! Poses of flights: the pose graph against independent checks, scan matching in worlds made of straight walls.

mod maps;
mod places;
mod pose_graph;
mod scan_match;
mod simulated;
mod steady;
