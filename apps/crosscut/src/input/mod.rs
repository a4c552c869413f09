//! What a command reads: the options that select it, recordings and robots, settings and plans.

mod args;
mod coming;
pub(crate) mod config;
pub(crate) mod configurations;
mod files;
mod flight;
mod judge;
pub(crate) mod live;
#[cfg(feature = "rerun")]
pub(crate) mod recorded;
mod related;
pub(crate) mod text_file;

#[cfg(not(feature = "rerun"))]
pub(crate) use crate::gate as recorded;

pub(crate) use self::args::{InputArgs, LiveArgs, RecordingsArgs};
#[cfg(feature = "rerun")]
pub(crate) use self::args::{live_input, without_query};
pub(crate) use self::coming::{Coming, files_of};
pub(crate) use self::config::{CONFIGURATION, ConfigArgs};
#[cfg(feature = "rerun")]
pub(crate) use self::files::refuse_empty_span;
pub(crate) use self::files::{each_of, files_read, left_out_of_folders};
pub(crate) use self::flight::Flight;
pub(crate) use self::judge::{Judge, Judged, TruthAt};
