//! The viewer beside the prompt, which needs the feature `rerun`.

use crosscut_debugger::Session;

/// There is none.
pub(super) enum Viewing {}

impl Viewing {
    pub(super) fn open(_: &str, _: &str) -> anyhow::Result<Self> {
        Err(crate::exit::without_rerun())
    }

    pub(super) fn follow(&mut self, _: &Session) -> anyhow::Result<()> {
        match *self {}
    }

    pub(super) fn end(self) -> anyhow::Result<()> {
        match self {}
    }
}
