//! Entities of two flights alone that are shown side by side: where they differ, lines of both and the truth, the list, and the
//! summary.

pub(crate) const DIFFERS: &str = "/differs";
pub(crate) const DIFFERS_WALLS: &str = "/differs/walls";
pub(crate) const DIFFERS_CONFIDENCE: &str = "/differs/confidence";
pub(crate) const DIFFERS_LOG: &str = "/differs/log";
pub(crate) const DIFFERS_SUMMARY: &str = "/differs/summary";
