//! Why a map has no place.

use crosscut_stage::Frame;

use super::Map;

/// A lidar that sees at least this much is taken to see all around.
const ALL_AROUND_DEG: f64 = 350.0;

/// Follows how much the scans of a flight see, to explain a map without places.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoPlace {
    /// The widest view of a scan so far; `None` if no scan has beams.
    widest_deg: Option<f64>,
}

impl NoPlace {
    /// Takes the next revolution.
    pub fn add(&mut self, frame: &Frame) {
        let Some(sweep) = frame.revolution.beams() else { return };
        let span_deg = sweep.len() as f64 * sweep.step_rad.to_degrees();
        let view_deg = if sweep.full_turn { 360.0 } else { span_deg };
        self.widest_deg = Some(self.widest_deg.map_or(view_deg, |widest_deg| widest_deg.max(view_deg)));
    }

    /// In a sentence why `map` has neither a junction nor a dead end, and what would give it one; `None` if it has.
    pub fn reason(&self, map: &Map) -> Option<String> {
        let known = "A place is known once the scans have seen all around it";
        map.nodes.is_empty().then(|| match self.widest_deg {
            Some(view_deg) if view_deg < ALL_AROUND_DEG => format!(
                "No place on the map: this lidar sees {view_deg:.0} of 360 degrees. {known}: the vehicle has to drive \
                 through it, or turn in it."
            ),
            _ => format!("No place on the map: no junction or dead end was passed. {known}."),
        })
    }
}
