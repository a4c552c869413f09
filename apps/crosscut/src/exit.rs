//! Exit codes.

use std::fmt;
use std::io;

use crosscut_detector::nearest_and_all;

use crate::output::say;

/// The outcome of a command, one for each exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Everything requested was done.
    Done,
    /// The command failed; results up to the failure are saved.
    Failed,
    /// The results are as complete as the input allowed, but something was lost.
    SomethingLost,
    /// The two recordings that were compared differ.
    #[cfg_attr(not(feature = "rerun"), allow(dead_code))] // recordings need the feature
    Different,
    /// The viewer asked for a file that another importer may know.
    NotOurs,
    /// The command was interrupted; results so far are saved.
    Interrupted,
}

impl From<Outcome> for u8 {
    fn from(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Done => 0,
            Outcome::Failed | Outcome::Different => 1,
            Outcome::SomethingLost => 3,
            Outcome::NotOurs => INCOMPATIBLE,
            Outcome::Interrupted => INTERRUPTED,
        }
    }
}

/// 128 + SIGINT, as shells report it.
pub(crate) const INTERRUPTED: u8 = 130;

/// `EXTERNAL_IMPORTER_INCOMPATIBLE_EXIT_CODE` of Rerun.
const INCOMPATIBLE: u8 = 66;

/// The exit code of a wrong command line or configuration.
pub(crate) const WRONG_USAGE: u8 = 2;

/// Wrong usage or configuration (exit code 2).
#[derive(Debug)]
pub(crate) struct UsageError(pub(crate) String);

/// The entry of this name; or what there is, with the nearest name.
pub(crate) fn chosen<T>(
    what: &str,
    name: &str,
    list: &'static [T],
    name_of: fn(&T) -> &'static str,
) -> Result<&'static T, UsageError> {
    list.iter().find(|entry| name_of(entry) == name).ok_or_else(|| {
        let all: Vec<&str> = list.iter().map(name_of).collect();
        UsageError(format!("there is no {what} {name:?}; {}", nearest_and_all(name, &all)))
    })
}

impl fmt::Display for UsageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for UsageError {}

/// Reports what a signal ended; that is no error.
pub(crate) fn report_interrupted(error: &anyhow::Error) -> u8 {
    if !is_of_closed_pipe(error) {
        say(format_args!("interrupted: {}", error.root_cause()));
    }
    INTERRUPTED
}

/// Reports the error that ended a command and returns the exit code. A reader that closes our output pipe (`| head`)
/// interrupts the command; that is no error and prints nothing.
pub(crate) fn report(error: &anyhow::Error) -> u8 {
    if is_of_closed_pipe(error) {
        return Outcome::Interrupted.into();
    }
    say(format_args!("error: {error:#}"));
    if error.is::<UsageError>() { WRONG_USAGE } else { Outcome::Failed.into() }
}

fn is_of_closed_pipe(error: &anyhow::Error) -> bool {
    error.chain().filter_map(|cause| cause.downcast_ref()).any(is_closed_pipe)
}

/// Whether the reader of the output closed the pipe.
pub(crate) fn is_closed_pipe(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::BrokenPipe
}
