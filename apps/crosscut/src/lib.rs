//! The command line of crosscut: counts the walls in 2D lidar scans and finds the openings between them.
//!
//! [`main`] is the whole program, with the stages of a [`Registry`]. A program of one's own calls it with a registry that
//! holds stages of its own too; they are then chosen, compared and recorded as those that ship. [`run`] is the
//! program for a process whose arguments are not those of the command line, such as that of an interpreter.
//!
//! Each command has a file or folder in `commands`, with its options; what it reads is in `input`, what it writes in `output`.
//! Results go to files or standard output, messages to standard error.

// These macros panic when they cannot write. Messages go through `say`, and writing results returns its error.
#![deny(clippy::print_stderr, clippy::print_stdout)]

mod commands;
mod diagnostics;
mod exit;
mod fly;
#[cfg(not(feature = "rerun"))]
mod gate;
mod host;
mod input;
mod interrupt;
mod output;
mod values;

use std::ffi::OsString;
use std::panic::resume_unwind;
use std::path::Path;
use std::process::ExitCode;
use std::thread::{self, Builder};

use clap::FromArgMatches;
use crosscut_detector::Registry;
use crosscut_flight::Map;
use crosscut_ingest::KeptStandardInput;

use crate::commands::{Cli, help};
pub use crate::host::{Host, Kinds};
pub use crate::input::live::{Answer, Robot, RobotAddress, RobotError, Robots};
pub use crate::output::answers::scene;
#[cfg(feature = "rerun")]
pub use crate::output::observers::recorder_options;
use crate::output::{maps, say};

/// Stack of the thread that does the command: that of the first thread is what the system grants, which may be a few pages.
const STACK_BYTES: usize = 8 << 20;

/// Runs the command in the arguments of this process, with the stages of `registry` to choose from.
pub fn main(registry: &Registry) -> ExitCode {
    let run = || run(std::env::args_os(), registry, &Host::default());
    let code = thread::scope(|scope| match Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, run) {
        Ok(command) => command.join().unwrap_or_else(|panicked| resume_unwind(panicked)),
        Err(_) => run(),
    });
    code.into()
}

/// Runs the command in `args`, of which the first is the name of the program, and returns its exit code. By the name
/// `rerun-importer-crosscut`, of a link or a copy, it is the importer that the Rerun viewer calls.
pub fn run(args: impl IntoIterator<Item = OsString>, registry: &Registry, host: &Host<'_>) -> u8 {
    let args: Vec<OsString> = args.into_iter().map(with_home).collect();
    let is_importer = args.first().is_some_and(|name| Path::new(name).file_stem() == Some(IMPORTER.as_ref()));
    if is_importer && !cfg!(feature = "rerun") {
        return exit::Outcome::NotOurs.into();
    }
    let args = if is_importer { of_importer(args) } else { without_help_of_help(args) };
    let retired = help::instead_of(&args);
    let command = match commands::command().try_get_matches_from(args).and_then(|found| Cli::from_arg_matches(&found)) {
        Ok(cli) => cli.command,
        Err(refused) => {
            refused.print().ok(); // help, or what is wrong; a closed pipe changes no exit code
            retired.iter().for_each(say);
            return if refused.use_stderr() { exit::WRONG_USAGE } else { exit::Outcome::Done.into() };
        }
    };
    interrupt::limit_is_an_error();
    let _standard_input = KeptStandardInput::keep(); // commands open their inputs several times
    match command.run(registry, host) {
        Ok(outcome) => outcome.into(),
        Err(error) if interrupt::is_requested() => exit::report_interrupted(&error),
        Err(error) => exit::report(&error),
    }
}

/// The name by which the Rerun viewer calls the program with each file that it opens.
const IMPORTER: &str = "rerun-importer-crosscut";

/// The arguments of the importer, with the command for them.
fn of_importer(args: Vec<OsString>) -> Vec<OsString> {
    ["crosscut", "import"].map(OsString::from).into_iter().chain(args.into_iter().skip(1)).collect()
}

/// `help --help` is `help`, which takes no options.
fn without_help_of_help(mut args: Vec<OsString>) -> Vec<OsString> {
    if args.get(1).is_some_and(|command| command == "help") {
        args.retain(|arg| arg != "--help" && arg != "-h");
    }
    args
}

/// `~/` at the start of an argument or of an option's value, where the shell has left it (`--save=~/F.rrd`), is the home folder.
fn with_home(arg: OsString) -> OsString {
    let home = std::env::home_dir().and_then(|home| home.into_os_string().into_string().ok());
    let (Some(text), Some(home)) = (arg.to_str(), home) else { return arg };
    match text.split_once("~/") {
        Some((option, rest)) if option.is_empty() || (option.starts_with("--") && option.ends_with('=')) => {
            format!("{option}{home}/{rest}").into()
        }
        _ => arg,
    }
}

/// The map of a flight as JSON, as `run --map` writes it.
pub fn map_json(map: &Map) -> String {
    maps::json(map).to_string()
}
