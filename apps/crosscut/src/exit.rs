//! How the program ends.

use std::fmt;
use std::io;
use std::process::ExitCode;

use crate::say::say;

/// The outcome of a command, as its exit code tells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Everything was done.
    Done,
    /// It failed; what came before is saved.
    Failed,
    /// Results are complete as far as the input allowed, but something was lost.
    SomethingLost,
    /// Two recordings were compared, and they are not the same.
    #[cfg_attr(not(feature = "rerun"), allow(dead_code))] // there are no recordings then
    Different,
    /// It was interrupted; what was made is saved.
    Interrupted,
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        Self::from(match outcome {
            Outcome::Done => 0,
            Outcome::Failed | Outcome::Different => 1,
            Outcome::SomethingLost => 3,
            Outcome::Interrupted => INTERRUPTED,
        })
    }
}

/// 128 + SIGINT, as shells say it.
pub(crate) const INTERRUPTED: u8 = 130;

/// What was typed cannot be done: wrong usage or configuration (exit code 2).
#[derive(Debug)]
pub(crate) struct UsageError(pub(crate) String);

impl fmt::Display for UsageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for UsageError {}

/// The error of a build without Rerun where a recording is to be made, read or shown.
#[cfg(not(feature = "rerun"))]
pub(crate) fn without_rerun() -> anyhow::Error {
    let text = "this crosscut was built without recordings; `cargo install --locked --path apps/crosscut` brings them";
    UsageError(text.to_owned()).into()
}

/// Says what ended a command, and gives the exit code. Whoever closes the pipe that we write to (`| head`) has had
/// enough: that interrupts us, and needs no words.
pub(crate) fn report(error: &anyhow::Error) -> ExitCode {
    let mut causes = error.chain().filter_map(|cause| cause.downcast_ref());
    if causes.any(is_closed_pipe) {
        return Outcome::Interrupted.into();
    }
    say(format_args!("error: {error:#}"));
    if error.is::<UsageError>() { ExitCode::from(2) } else { Outcome::Failed.into() }
}

/// Whether nobody reads any more what is written.
pub(crate) fn is_closed_pipe(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::BrokenPipe
}
