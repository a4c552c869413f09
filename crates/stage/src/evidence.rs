//! Why what is open is believed to be.

use std::fmt;

/// Why an opening, or a way on, is believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Evidence {
    /// A wall farther away is seen past the edge of a nearer one.
    SeenThrough,
    /// Beams in its direction came back with nothing.
    NoReturn,
}

impl fmt::Display for Evidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::SeenThrough => "seen_through",
            Self::NoReturn => "no_return",
        })
    }
}
