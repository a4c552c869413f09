//! In place of `save.rs` where the program is built without Rerun.

use std::path::Path;

use crosscut_explore::Moment;
use crosscut_pipeline::Config;
use crosscut_simulator::World;

/// There are none.
pub(super) enum Saved {}

impl Saved {
    pub(super) fn create(_: &Path, _: &str, _: &Config, _: &World) -> Result<Self, anyhow::Error> {
        Err(crate::exit::without_rerun())
    }

    pub(super) fn add(&mut self, _: &Moment) {
        match *self {}
    }

    pub(super) fn finish(self) -> Result<(), anyhow::Error> {
        match self {}
    }
}
