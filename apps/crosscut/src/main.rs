//! `crosscut`: the command line with the stages that ship.

use std::process::ExitCode;

use crosscut_detector::Registry;

fn main() -> ExitCode {
    crosscut::main(&Registry::standard())
}
