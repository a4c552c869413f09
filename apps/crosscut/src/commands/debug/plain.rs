//! Lines of words from a file or pipe. Answers go to standard output, refusals to standard error.

use std::io::BufRead;

use anyhow::Context;

use super::{Debugger, is_end, words};
use crate::output::{say, show};

/// Does one line after the other up to the end; empty lines, and lines that begin with `#`, do nothing. Returns how many
/// were refused.
pub(super) fn answer_all(debugger: &mut Debugger, lines: impl BufRead) -> anyhow::Result<u64> {
    show(format_args!("{}\n", debugger.session.greeting()))?;
    let mut refused = 0;
    for line in lines.lines() {
        let words = words(&line.context("standard input")?);
        if words.is_empty() || words[0].starts_with('#') {
            continue;
        }
        if is_end(&words) {
            break;
        }
        match debugger.command(&words) {
            Ok(reply) => show(format_args!("{reply}\n"))?,
            Err(error) => {
                refused += 1;
                say(format_args!("error: {error}"));
            }
        }
    }
    Ok(refused)
}
