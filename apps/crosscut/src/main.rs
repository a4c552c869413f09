//! `crosscut`: counts the walls in 2D lidar scans and finds the openings between them.
//!
//! Each command has a file or folder in `commands`. Results go to files or standard output, messages to standard error.

// These macros panic when they cannot write. Messages go through `say`, and writing results returns its error.
#![deny(clippy::print_stderr, clippy::print_stdout)]

mod cli;
mod commands;
mod config;
mod configurations;
mod diagnostics;
mod exit;
mod figure;
mod flight;
mod interrupt;
mod observers;
mod outputs;
mod over_time;
mod progress;
mod say;
mod scoring;
mod summary;
mod typeset;
mod wrong;

use std::process::ExitCode;

use clap::Parser;

use crate::cli::{Cli, Command};

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Run(args) => commands::run::run(&args),
        Command::View(args) => view(&args),
        Command::Simulate(args) => commands::simulate::simulate(&args),
        Command::Evaluate(args) => commands::evaluate::evaluate(&args),
        Command::Compare(args) => commands::compare::compare(&args),
        Command::Paper(args) => commands::paper::paper(&args),
        Command::Info(args) => commands::info::info(&args),
        Command::Convert(args) => commands::convert::convert(&args),
        Command::Rrd(command) => rrd(&command),
        Command::Config(args) => config::print(&args),
    };
    match outcome {
        Ok(outcome) => outcome.into(),
        Err(error) => exit::report(&error),
    }
}

#[cfg(feature = "rerun")]
use commands::rrd::rrd;
#[cfg(feature = "rerun")]
use commands::view::view;

#[cfg(not(feature = "rerun"))]
fn rrd(_: &cli::RrdCommand) -> anyhow::Result<exit::Outcome> {
    Err(exit::without_rerun())
}

#[cfg(not(feature = "rerun"))]
fn view(_: &cli::ViewArgs) -> anyhow::Result<exit::Outcome> {
    Err(exit::without_rerun())
}
