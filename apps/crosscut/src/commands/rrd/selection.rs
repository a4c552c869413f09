//! The revolutions that were asked for.

use crosscut_rrd::{Recording, Row, schema};

use super::args::RrdGetArgs;
use crate::exit::UsageError;

const NO_STAMPS: &str = "the recording has no stamps, which --from and --to need; take --at REVOLUTION";

/// One revolution, a span of time, or all.
pub(super) struct Selection {
    revolution: Option<i64>,
    from_ns: Option<i64>,
    to_ns: Option<i64>,
}

impl Selection {
    /// Seconds count from the stamp of the first revolution, which need not be the earliest if a clock was set back.
    pub(super) fn new(args: &RrdGetArgs, recording: &Recording) -> Result<Self, UsageError> {
        let mut selection = Self { revolution: args.at.map(u64::cast_signed), from_ns: None, to_ns: None };
        if args.from.is_some() || args.to.is_some() {
            let mut rows = recording.rows(schema::REPORT_JUNCTIONS.path).into_iter().flatten();
            let start_ns = rows.find_map(|row| row.ok()?.stamp_ns);
            let start_ns = start_ns.ok_or_else(|| UsageError(NO_STAMPS.to_owned()))?;
            let at_ns = |seconds: f64| start_ns.saturating_add((seconds * 1e9) as i64);
            (selection.from_ns, selection.to_ns) = (args.from.map(at_ns), args.to.map(at_ns));
        }
        Ok(selection)
    }

    pub(super) fn holds(&self, row: &Row) -> bool {
        self.revolution.is_none_or(|revolution| row.revolution == revolution)
            && self.from_ns.is_none_or(|from| row.stamp_ns.is_some_and(|stamp_ns| stamp_ns >= from))
            && self.to_ns.is_none_or(|to| row.stamp_ns.is_some_and(|stamp_ns| stamp_ns <= to))
    }

    /// Whether one revolution is asked for, by number.
    pub(super) fn is_one(&self) -> bool {
        self.revolution.is_some()
    }
}
