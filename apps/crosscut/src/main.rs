//! `crosscut`: how many walls, and so how many ways on, are here.
//!
//! One file per command. Results go to files or standard output, words for people to standard error.

// They panic when they cannot write: words are for `say`, and results are written with their error.
#![deny(clippy::print_stderr, clippy::print_stdout)]

mod cli;
mod compare;
mod config;
mod configurations;
mod evaluate;
mod exit;
mod figure;
mod flight;
mod info;
mod interrupt;
mod over_time;
mod overwriting;
mod paper;
mod progress;
mod record;
#[cfg(feature = "rerun")]
mod rrd;
mod run;
mod say;
mod scoring;
mod simulate;
mod summary;
mod typeset;
#[cfg(feature = "rerun")]
mod view;
mod wrong;

use std::process::ExitCode;

use clap::Parser;

use crate::cli::{Cli, Command};

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Run(args) => run::run(&args),
        Command::View(args) => view(&args),
        Command::Simulate(args) => simulate::simulate(&args),
        Command::Evaluate(args) => evaluate::evaluate(&args),
        Command::Compare(args) => compare::compare(&args),
        Command::Paper(args) => paper::paper(&args),
        Command::Info(args) => info::info(&args),
        Command::Rrd(command) => rrd(&command),
        Command::Config(args) => config::print(&args),
    };
    match outcome {
        Ok(outcome) => outcome.into(),
        Err(error) => exit::report(&error),
    }
}

#[cfg(feature = "rerun")]
use rrd::rrd;
#[cfg(feature = "rerun")]
use view::view;

#[cfg(not(feature = "rerun"))]
fn rrd(_: &cli::RrdCommand) -> anyhow::Result<exit::Outcome> {
    Err(exit::without_rerun())
}

#[cfg(not(feature = "rerun"))]
fn view(_: &cli::ViewArgs) -> anyhow::Result<exit::Outcome> {
    Err(exit::without_rerun())
}
