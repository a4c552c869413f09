//! Ways on in three dimensions, and the directions that they are made of.

use std::fmt;

use nalgebra::{UnitQuaternion, Vector3};

use crate::Evidence;

/// Up to this elevation a way is level, radians.
const LEVEL_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Up to this elevation a way is a ramp, beyond it a shaft, radians.
const RAMP_RAD: f64 = 50.0 * std::f64::consts::PI / 180.0;

/// What an affinity gives beside W whose rows are directions and not returns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dual {
    /// All directions, in rings about the axis of the lidar from the lowest up, each anticlockwise from behind. Those of ways are
    /// the rows of W.
    pub cells: Vec<Cell>,
    /// From the frame of the cells, in which the axis of the lidar is upright, to that of the body.
    pub tilt: UnitQuaternion<f64>,
    /// The ways, as their rows were joined.
    pub ways: Vec<Way>,
    /// Where ways are nearest to being one: one fewer than ways, or still fewer where the sensor does not look.
    pub between: Vec<Between>,
    /// The lowest and the highest elevation that the sensor looks at, in [-π/2, π/2].
    pub view_rad: [f64; 2],
    /// R, the radius of the largest ball that holds the sensor, metres; 0 where nothing is seen.
    pub room_m: f64,
    /// The distance at which the directions were cut, metres.
    pub cut_m: f64,
    /// The distance that the vehicle gets far in a way, or farther, metres.
    pub on_m: f64,
}

impl Dual {
    /// The directions that are rows of W, way after way, each with the way that it is of, an index of `ways`.
    pub fn rows(&self) -> impl Iterator<Item = (Vector3<f64>, u32)> {
        let of_way = move |way| {
            self.cells
                .iter()
                .filter(move |cell| cell.way == Some(way))
                .map(move |cell| (self.tilt * cell.direction, way))
        };
        (0..self.ways.len() as u32).flat_map(of_way)
    }

    /// Of each of `ways`, its number among the reported ones; `None` of one that is reported otherwise.
    pub fn numbers_in(&self, reported: &[Way]) -> Vec<Option<u32>> {
        self.ways.iter().map(|way| (0..).zip(reported).find(|(_, of)| *of == way).map(|(number, _)| number)).collect()
    }
}

/// A direction, and what is known there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Towards its middle, in the frame of the cells; a unit vector.
    pub direction: Vector3<f64>,
    /// The distance of what is seen there, metres: infinite where nothing came back, NaN where the sensor does not look.
    pub range_m: f64,
    /// How far the vehicle gets straight on, metres; as above.
    pub reach_m: f64,
    /// The way that it is of, an index of [`Dual::ways`].
    pub way: Option<u32>,
}

/// What parts two ways: of the directions that lead from one to the other, that in which the vehicle gets least far, on the path
/// on which that is the most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Between {
    /// The two ways, indices of [`Dual::ways`].
    pub ways: [u32; 2],
    /// The direction, in the body frame; a unit vector.
    pub direction: Vector3<f64>,
    /// How far the vehicle gets there, metres; less than [`Dual::cut_m`].
    pub reach_m: f64,
}

/// A way on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// Towards it, in the body frame; a unit vector.
    pub direction: Vector3<f64>,
    /// How steep it is, in [-π/2, π/2], up is positive: the elevation of the line along its middle, wherever in the place the sensor is.
    pub slope_rad: f64,
    /// Diameter of the largest ball that passes, metres.
    pub clearance_m: f64,
    /// The odds that it is one, as a probability.
    pub p: f64,
    /// Why it is believed.
    pub evidence: Evidence,
    /// It goes on beyond what the sensor looks at: direction and clearance are those of the part in view.
    pub cut_by_view: bool,
    /// It takes up half a turn, or a third of all directions, as in a place that is wide for its height: it may be several ways.
    pub is_wide: bool,
}

/// Where a way leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // the names suffice
pub enum WayKind {
    Level,
    RampUp,
    RampDown,
    ShaftUp,
    ShaftDown,
}

impl WayKind {
    /// The kind of a slope in [-π/2, π/2]: level up to 10°, a ramp up to 50°, a shaft beyond.
    pub fn of_slope(slope_rad: f64) -> Self {
        match (slope_rad.abs() <= LEVEL_RAD, slope_rad.abs() <= RAMP_RAD, slope_rad > 0.0) {
            (true, ..) => Self::Level,
            (_, true, true) => Self::RampUp,
            (_, true, false) => Self::RampDown,
            (_, _, true) => Self::ShaftUp,
            (_, _, false) => Self::ShaftDown,
        }
    }
}

impl Way {
    /// Its bearing, in (-π, π].
    pub fn bearing_rad(&self) -> f64 {
        self.direction.y.atan2(self.direction.x)
    }

    /// Its elevation as seen from the sensor, in [-π/2, π/2].
    pub fn elevation_rad(&self) -> f64 {
        self.direction.z.clamp(-1.0, 1.0).asin()
    }

    /// Where it leads.
    pub fn kind(&self) -> WayKind {
        WayKind::of_slope(self.slope_rad)
    }

    /// "shaft up at +51°, 78° up: 2.6 m": where it leads, its bearing and elevation, and its clearance.
    pub fn words(&self) -> String {
        let kind = self.kind().to_string().replace('_', " ");
        format!("{kind} at {}: {:.1} m", direction_words(&self.direction), self.clearance_m)
    }

    /// Whether a vehicle on the ground can take it: shafts are for flyers.
    pub fn is_for_ground(&self) -> bool {
        !matches!(self.kind(), WayKind::ShaftUp | WayKind::ShaftDown)
    }
}

/// "+51°, 78° up": bearing and elevation of a unit vector.
pub fn direction_words(direction: &Vector3<f64>) -> String {
    let elevation_deg = direction.z.clamp(-1.0, 1.0).asin().to_degrees().round();
    let side = if elevation_deg < 0.0 { "down" } else { "up" };
    format!("{}, {:.0}° {side}", degrees_words(direction.y.atan2(direction.x)), elevation_deg.abs())
}

/// "+51°": a bearing or an elevation; never "-0°".
pub fn degrees_words(rad: f64) -> String {
    format!("{:+.0}°", rad.to_degrees().round() + 0.0)
}

impl fmt::Display for WayKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Level => "level",
            Self::RampUp => "ramp_up",
            Self::RampDown => "ramp_down",
            Self::ShaftUp => "shaft_up",
            Self::ShaftDown => "shaft_down",
        })
    }
}
