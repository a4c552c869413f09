//! One file or folder per command; `crosscut config` is printed by [`crate::config`].

pub(crate) mod compare;
pub(crate) mod convert;
pub(crate) mod debug;
pub(crate) mod explore;
#[cfg(feature = "rerun")]
pub(crate) mod import;
pub(crate) mod info;
pub(crate) mod report;
#[cfg(feature = "rerun")]
pub(crate) mod rrd;
pub(crate) mod run;
pub(crate) mod shell;
pub(crate) mod simulate;
#[cfg(feature = "rerun")]
pub(crate) mod view;
