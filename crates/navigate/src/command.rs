//! What a vehicle is to do, and what it is able to do.

/// What a vehicle is to do until the next command.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command {
    /// Speed ahead; below 0 astern.
    pub speed_m_s: f64,
    /// Turn rate, anticlockwise.
    pub turn_rate_rad_s: f64,
}

/// What the vehicle is able to do, as far as the steering needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest speed ahead.
    pub speed_max_m_s: f64,
    /// Largest turn rate.
    pub turn_rate_max_rad_s: f64,
    /// The vehicle is a disc of this radius.
    pub radius_m: f64,
}
