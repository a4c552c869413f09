//! Words for people.

use std::fmt::Display;
use std::io::Write;

/// Of a flight in which nothing is seen.
pub(crate) const NO_RETURN: &str =
    "note: no scan has a return that can be used: nothing came back, or the notes of the results say why";

/// Says a line on standard error. Nobody may be there to hear it (`2>&1 | head`, a full disk): that ends nothing and
/// changes no exit code.
pub(crate) fn say(words: impl Display) {
    let _ = writeln!(std::io::stderr(), "{}", printable(&words.to_string()));
}

/// The text as a terminal may have it. A recording is not ours: its topics may be named with control characters, which
/// would be obeyed.
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
