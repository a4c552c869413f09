//! A flight that answers back: the core of `crosscut debug`.
//!
//! In: the revolutions of a flight, held in memory, and a configuration. A [`Session`] stands at one revolution and answers
//! words ([`COMMANDS`]): it moves, shows what every stage made, explains, takes other settings or another output of a stage
//! ([`Injected`]) and goes on from it, answers the whole flight again on all cores, and compares with an answer that was
//! held. Out: text for people. A refusal leaves everything as it was.
//!
//! No files but those of `get` and `inject` (NumPy's), no terminal: the program's front ends hold those.
//!
//! A command is a line in [`COMMANDS`] and an arm in [`Session::command`]; a condition of `next` and `break` is a variant
//! of `When`; a picture is a file in `show/`.

mod answers;
mod command;
mod inject;
mod matrices;
mod moves;
pub mod npy;
mod refused;
mod session;
mod settings;
mod show;
mod side;
mod when;

pub use command::{COMMANDS, Command};
pub use inject::Injected;
pub use refused::Refused;
pub use session::{Reader, Session};
pub use side::Scan;
