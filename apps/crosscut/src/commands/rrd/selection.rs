//! Which revolutions are asked for.

use crosscut_recorder::{Recording, Row};

use crate::cli::RrdGetArgs;

/// One revolution, a span of time, or all.
pub(super) struct Selection {
    revolution: Option<i64>,
    from_ns: Option<i64>,
    to_ns: Option<i64>,
}

impl Selection {
    /// Seconds count from the stamp of the first revolution, which need not be the earliest if a clock was set back.
    pub(super) fn new(args: &RrdGetArgs, recording: &Recording) -> Self {
        let mut rows = recording.rows("/report/junctions").into_iter().flatten();
        let start_ns = rows.find_map(|row| row.ok()?.stamp_ns).unwrap_or(0);
        let at_ns = |seconds: f64| start_ns.saturating_add((seconds * 1e9) as i64);
        Self { revolution: args.revolution, from_ns: args.from.map(at_ns), to_ns: args.to.map(at_ns) }
    }

    pub(super) fn holds(&self, row: &Row) -> bool {
        let stamp_ns = row.stamp_ns.unwrap_or(0);
        self.revolution.is_none_or(|revolution| row.revolution == revolution)
            && self.from_ns.is_none_or(|from| stamp_ns >= from)
            && self.to_ns.is_none_or(|to| stamp_ns <= to)
    }

    /// Whether one revolution is asked for, by number.
    pub(super) fn is_one(&self) -> bool {
        self.revolution.is_some()
    }
}
