//! Messages on standard error.

use std::fmt::Display;
use std::io::Write;

/// Prints a line on standard error. A failed write (`2>&1 | head`, a full disk) ends nothing and changes no exit code.
pub(crate) fn say(message: impl Display) {
    let _ = writeln!(std::io::stderr(), "{}", printable(&message.to_string()));
}

/// The text with control characters escaped. Names of topics come from the recording, and a terminal would obey control
/// characters in them.
pub(crate) fn printable(text: &str) -> String {
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
