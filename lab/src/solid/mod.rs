//! Places in three dimensions with a truth that comes from a mesh alone.

pub mod lidar;
pub mod mesh;
pub mod truth;
pub mod tubes;
