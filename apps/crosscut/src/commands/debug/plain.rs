//! Lines of words from a file or pipe. Answers go to standard output, refusals to standard error.

use std::io::{self, BufRead, Read as _};

use anyhow::Context;
use crosscut_debugger::Refused;

use super::{Debugger, is_end, words};
use crate::output::{say, show};

/// The longest line, bytes.
const LONGEST_LINE: usize = 1 << 16;

/// Does one line after the other up to the end; empty lines, and lines that begin with `#`, do nothing. Returns how many
/// were refused.
pub(super) fn answer_all(debugger: &mut Debugger, mut lines: impl BufRead) -> anyhow::Result<u64> {
    show(format_args!("{}\n", debugger.session.greeting()))?;
    let mut refused = 0;
    while let Some(line) = next_line(&mut lines).context("standard input")? {
        let words = line.map(|line| words(&line));
        if words.as_ref().is_ok_and(|words| words.is_empty() || words[0].starts_with('#')) {
            continue;
        }
        if words.as_ref().is_ok_and(|words| is_end(words)) {
            break;
        }
        match words.and_then(|words| debugger.command(&words)) {
            Ok(reply) => show(format_args!("{reply}\n"))?,
            Err(error) => {
                refused += 1;
                say(format_args!("error: {error}"));
            }
        }
    }
    Ok(refused)
}

/// The next line, refused if it is no text or longer than [`LONGEST_LINE`]; `None` at the end.
fn next_line(lines: &mut impl BufRead) -> io::Result<Option<Result<String, Refused>>> {
    let mut line = Vec::new();
    lines.by_ref().take(LONGEST_LINE as u64 + 1).read_until(b'\n', &mut line)?;
    if line.is_empty() {
        return Ok(None);
    }
    if line.len() > LONGEST_LINE && line.last() != Some(&b'\n') {
        lines.skip_until(b'\n')?;
        return Ok(Some(Err(Refused::Usage(format!("a line of more than {LONGEST_LINE} bytes")))));
    }
    Ok(Some(String::from_utf8(line).map_err(|_| Refused::Usage("a line that is no UTF-8 text".to_owned()))))
}
