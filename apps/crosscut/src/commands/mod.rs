//! One file or folder per command; `crosscut config` is printed by [`crate::config`].

pub(crate) mod compare;
pub(crate) mod convert;
pub(crate) mod debug;
pub(crate) mod evaluate;
pub(crate) mod explore;
#[cfg(feature = "rerun")]
pub(crate) mod import;
pub(crate) mod info;
pub(crate) mod map;
pub(crate) mod replay;
pub(crate) mod report;
#[cfg(feature = "rerun")]
pub(crate) mod rrd;
pub(crate) mod run;
pub(crate) mod runs;
pub(crate) mod shell;
pub(crate) mod simulate;
pub(crate) mod sweep;
#[cfg(feature = "rerun")]
pub(crate) mod view;
