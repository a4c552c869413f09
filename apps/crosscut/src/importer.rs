//! `rerun-importer-crosscut`: with it on the PATH, the Rerun viewer opens recorded flights with the pages of crosscut.

use std::process::ExitCode;

use crosscut_detector::Registry;

fn main() -> ExitCode {
    crosscut::import(std::env::args_os(), &Registry::standard()).into()
}
