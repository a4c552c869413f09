//! What is decided at a gap.

use crosscut_stage::Measured;

/// How much room there is at a gap, by the rule that finds the most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decision {
    /// The room that there is, divided by the room that an opening needs; 0 if the gap hides nothing.
    pub(super) room_ratio: f64,
    /// What decides, in a few words: why the gap is an opening, or why it is none.
    pub(super) reason: &'static str,
    /// What was measured.
    pub(super) measured: Option<Measured>,
    /// The room ratio by the rules, whatever the odds make of it: one of the measurements that the odds rest on.
    pub(super) ratio_by_rules: f64,
}

impl Decision {
    /// A decision by the room that was measured, for a reason.
    pub(super) fn room(reason: &'static str, measured: Measured) -> Self {
        let room_ratio = measured.ratio();
        Self { room_ratio, reason, measured: Some(measured), ratio_by_rules: room_ratio }
    }

    /// A decision that there is no room, for a reason.
    pub(super) fn no_room(reason: &'static str, measured: Option<Measured>) -> Self {
        Self { room_ratio: 0.0, reason, measured, ratio_by_rules: 0.0 }
    }

    /// Whether a vehicle can pass.
    pub(super) fn is_opening(self) -> bool {
        self.room_ratio >= 1.0
    }
}
