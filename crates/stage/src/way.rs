//! Ways on in three dimensions, and the directions that they are made of.

use std::fmt;

use nalgebra::Vector3;

use crate::Evidence;

/// Up to this elevation a way is level, radians.
const LEVEL_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Up to this elevation a way is a ramp, beyond it a shaft, radians.
const RAMP_RAD: f64 = 50.0 * std::f64::consts::PI / 180.0;

/// What an affinity gives beside W whose rows are directions and not returns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dual {
    /// Of each row: its direction in the body frame, a unit vector.
    pub directions: Vec<Vector3<f64>>,
    /// Of each row: the way that it is of, an index of `ways`.
    pub way_of_row: Vec<u32>,
    /// The ways, as their rows were joined.
    pub ways: Vec<Way>,
    /// The lowest and the highest elevation that the sensor looks at, in [-π/2, π/2].
    pub view_rad: [f64; 2],
    /// The distance at which the directions were cut, metres.
    pub cut_m: f64,
}

/// A way on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way {
    /// Towards it, in the body frame; a unit vector.
    pub direction: Vector3<f64>,
    /// Diameter of the largest ball that passes, metres.
    pub clearance_m: f64,
    /// The odds that it is one, as a probability.
    pub p: f64,
    /// Why it is believed.
    pub evidence: Evidence,
    /// It goes on beyond what the sensor looks at: direction and clearance are those of the part in view.
    pub cut_by_view: bool,
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

impl Way {
    /// Its bearing, in (-π, π].
    pub fn bearing_rad(&self) -> f64 {
        self.direction.y.atan2(self.direction.x)
    }

    /// Its elevation, in [-π/2, π/2].
    pub fn elevation_rad(&self) -> f64 {
        self.direction.z.clamp(-1.0, 1.0).asin()
    }

    /// Where it leads: level up to 10°, a ramp up to 50°, a shaft beyond.
    pub fn kind(&self) -> WayKind {
        let (elevation_rad, up) = (self.elevation_rad().abs(), self.direction.z > 0.0);
        match (elevation_rad <= LEVEL_RAD, elevation_rad <= RAMP_RAD, up) {
            (true, ..) => WayKind::Level,
            (_, true, true) => WayKind::RampUp,
            (_, true, false) => WayKind::RampDown,
            (_, _, true) => WayKind::ShaftUp,
            (_, _, false) => WayKind::ShaftDown,
        }
    }

    /// "shaft up at +51°, 78° up: 2.6 m": where it leads, its bearing and elevation, and its clearance.
    pub fn words(&self) -> String {
        let kind = self.kind().to_string().replace('_', " ");
        // The sum with 0 leaves no -0.
        let [bearing_deg, elevation_deg] =
            [self.bearing_rad(), self.elevation_rad()].map(|rad| rad.to_degrees().round() + 0.0);
        let side = if elevation_deg < 0.0 { "down" } else { "up" };
        format!("{kind} at {bearing_deg:+.0}°, {:.0}° {side}: {:.1} m", elevation_deg.abs(), self.clearance_m)
    }

    /// Whether a vehicle on the ground can take it: shafts are for flyers.
    pub fn is_for_ground(&self) -> bool {
        !matches!(self.kind(), WayKind::ShaftUp | WayKind::ShaftDown)
    }
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
