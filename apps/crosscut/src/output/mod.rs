//! What a command writes: files, recordings, answers to a robot, and words for people.

pub(crate) mod answers;
pub(crate) mod files;
pub(crate) mod looking;
mod map_file;
pub(crate) mod map_picture;
pub(crate) mod maps;
pub(crate) mod observers;
pub(crate) mod progress;
pub(crate) mod record;
pub(crate) mod robot;
pub(crate) mod say;
pub(crate) mod summary;
pub(crate) mod typeset;
pub(crate) mod written;

pub(crate) use self::files::Document;
pub(crate) use self::looking::Look;
pub(crate) use self::say::{say, show};
pub(crate) use self::written::Written;
