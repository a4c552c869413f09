//! The lengths by which a scan is divided.

use crosscut_stage::Number;

/// The length of an island.
pub const ISLAND_M: Number = Number::new("island_m", "m", 2.0)
    .from(0.0)
    .to(100.0)
    .doc("a piece of wall no longer than this in front of what is on both sides of it is an island, cut off by the affinity and not counted; 0: none is");

/// The lengths by which a scan is divided, metres.
#[derive(Clone, Copy, Debug)]
pub struct Lengths {
    /// Where two neighbouring returns are this far apart, a vehicle could pass, and the ring is cut. What is nearer to
    /// the sensor than half of it is the vehicle itself, unless it continues as a wall.
    pub passage_m: f64,
    /// Islands are shorter than this.
    pub island_m: f64,
    /// The length of wall over which the direction of its end is taken.
    pub stretch_m: f64,
}
