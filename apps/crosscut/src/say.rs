//! Words for people, on standard error.

use std::fmt::Display;
use std::io::Write;

/// Says a line. Nobody may be there to hear it (`2>&1 | head`, a full disk): that ends nothing and changes no exit code.
pub(crate) fn say(words: impl Display) {
    let _ = writeln!(std::io::stderr(), "{words}");
}
