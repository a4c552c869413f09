//! What a command reports beside its results, and the exit code that follows from it.

use std::fmt::Display;

use crate::exit::Outcome;
use crate::output::say;

/// Prints problems on standard error as they come, and keeps them. A problem that several configurations meet is
/// reported once.
#[derive(Default)]
pub(crate) struct Diagnostics {
    problems: Vec<String>,
    failed: bool,
    interrupted: bool,
    lost: bool,
}

impl Diagnostics {
    /// Reports why the command fails.
    pub(crate) fn error(&mut self, reason: impl Display) {
        self.failed = true;
        self.problem(format!("error: {reason}"));
    }

    /// Reports a part of the input or of the output that is missing; the rest is complete.
    pub(crate) fn lost(&mut self, loss: impl Display) {
        self.lost = true;
        self.problem(format!("lost: {loss}"));
    }

    /// Reports each of the losses.
    pub(crate) fn lost_all(&mut self, losses: impl IntoIterator<Item = impl Display>) {
        losses.into_iter().for_each(|loss| self.lost(loss));
    }

    /// Takes note that the work ended early because somebody asked for it.
    pub(crate) fn interrupt(&mut self) {
        self.interrupted = true;
    }

    /// Reports where the work was interrupted, the first time only.
    pub(crate) fn interrupted(&mut self, place: impl Display) {
        if !self.interrupted {
            self.interrupt();
            self.problem(format!("interrupted {place}"));
        }
    }

    /// Reports something worth knowing that changes no exit code.
    pub(crate) fn note(&mut self, text: impl Display) {
        self.problem(format!("note: {text}"));
    }

    fn problem(&mut self, sentence: String) {
        if !self.problems.contains(&sentence) {
            say(&sentence);
            self.problems.push(sentence);
        }
    }

    /// Every problem that was reported, as it was printed.
    pub(crate) fn problems(&self) -> &[String] {
        &self.problems
    }

    /// The exit code: a failure counts more than an interruption, and that more than a loss.
    pub(crate) fn outcome(&self) -> Outcome {
        if self.failed {
            Outcome::Failed
        } else if self.interrupted {
            Outcome::Interrupted
        } else if self.lost {
            Outcome::SomethingLost
        } else {
            Outcome::Done
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failure_counts_more_than_interruption_and_loss() {
        let mut diagnostics = Diagnostics::default();
        assert_eq!(diagnostics.outcome(), Outcome::Done);
        diagnostics.note("time goes back");
        assert_eq!(diagnostics.outcome(), Outcome::Done);
        diagnostics.lost("a chunk");
        assert_eq!(diagnostics.outcome(), Outcome::SomethingLost);
        diagnostics.interrupted("at scan 3");
        assert_eq!(diagnostics.outcome(), Outcome::Interrupted);
        diagnostics.error("no scan");
        assert_eq!(diagnostics.outcome(), Outcome::Failed);
    }

    #[test]
    fn a_problem_of_two_configurations_is_listed_once() {
        let mut diagnostics = Diagnostics::default();
        diagnostics.lost_all(["a chunk", "a chunk"]);
        diagnostics.interrupted("at paper");
        diagnostics.interrupted("at default");
        assert_eq!(diagnostics.problems(), ["lost: a chunk", "interrupted at paper"]);
    }
}
