//! In place of `save.rs` where the program is built without Rerun.

use crosscut_detector::Config;
use crosscut_missions::{Flown, Moment};
use crosscut_simulator::World;

use crate::cli::explore::ExploreArgs;
use crate::diagnostics::Diagnostics;

/// There are none.
pub(super) enum Saved {}

impl Saved {
    pub(super) fn open(
        args: &ExploreArgs,
        _: &str,
        _: &Config,
        _: &World,
        _: &mut Diagnostics,
    ) -> anyhow::Result<Option<Self>> {
        if args.save.is_some() { Err(crate::exit::without_rerun()) } else { Ok(None) }
    }

    pub(super) fn add(&mut self, _: &Moment) {
        match *self {}
    }

    pub(super) fn finish(self, _: &Flown) -> Result<(), anyhow::Error> {
        match self {}
    }
}
