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

/// Characters that turn the direction of writing: what follows looks as if it stood elsewhere.
const TURNING: &str = "\u{61c}\u{200e}\u{200f}\u{202a}\u{202b}\u{202c}\u{202d}\u{202e}\u{2066}\u{2067}\u{2068}\u{2069}";

/// The text with control characters escaped, and those of [`TURNING`]. Names of topics come from the
/// recording, and a terminal would obey what stands in them.
fn printable(text: &str) -> String {
    let mut printable = String::with_capacity(text.len());
    for character in text.chars() {
        if TURNING.contains(character) || character.is_control() && character != '\n' {
            printable.extend(character.escape_default());
        } else {
            printable.push(character);
        }
    }
    printable
}
