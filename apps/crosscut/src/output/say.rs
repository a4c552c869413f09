//! Words for people on standard error; tables and other results on standard output.

use std::fmt::Display;
use std::io::Write;

use anyhow::Context;

/// Prints a line on standard error. A failed write (`2>&1 | head`, a full disk) ends nothing and changes no exit code.
pub(crate) fn say(message: impl Display) {
    let _ = writeln!(std::io::stderr(), "{}", printable(&message.to_string()));
}

/// Writes to standard output.
pub(crate) fn show(text: impl Display) -> anyhow::Result<()> {
    let text = printable(&text.to_string());
    std::io::stdout().write_all(text.as_bytes()).context("standard output")
}

/// The text with control characters escaped. Names of topics come from the recording, and a terminal would obey control
/// characters in them.
fn printable(text: &str) -> String {
    let mut printable = String::with_capacity(text.len());
    for character in text.chars() {
        if character.is_control() && character != '\n' {
            printable.extend(character.escape_default());
        } else {
            printable.push(character);
        }
    }
    printable
}
