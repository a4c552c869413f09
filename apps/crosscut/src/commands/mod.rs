//! The command line: a file or folder for each command, with its options and what it does.

mod compare;
mod config;
mod convert;
mod debug;
mod explore;
pub(crate) mod help;
#[cfg(feature = "rerun")]
mod import;
mod info;
mod report;
#[cfg_attr(not(feature = "rerun"), path = "rrd/args.rs")]
mod rrd;
mod run;
mod shell;
mod simulate;
mod view;

use std::path::PathBuf;

use clap::{CommandFactory as _, Parser, Subcommand};
use clap_complete::Shell;
use crosscut_detector::Registry;

use self::compare::CompareArgs;
use self::convert::ConvertArgs;
use self::debug::DebugArgs;
use self::explore::ExploreArgs;
use self::info::InfoArgs;
use self::report::ReportArgs;
use self::rrd::RrdCommand;
use self::run::RunArgs;
use self::simulate::SimulateArgs;
use self::view::ViewArgs;
use crate::exit::Outcome;
use crate::host::Host;
use crate::input::ConfigArgs;
use crate::input::config::found;
use crate::output::say;

/// Counts the walls in 2D lidar scans and finds the openings between them: spectral junction detection.
#[derive(Debug, Parser)]
#[command(name = "crosscut", version, max_term_width = 110, after_help = EXIT_CODES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXIT_CODES: &str = "\
Exit codes: 0 done; 1 failed, results up to the failure are saved; 2 wrong usage or configuration; 3 done, but \
something was lost (damaged input, incomplete recording); 130 interrupted, results so far are saved.\n\n\
For shells: crosscut completions bash (or zsh, fish, elvish, powershell); crosscut man DIR writes pages for man.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Count the walls in every scan of a flight, recorded or live, and find the openings.
    Run(Box<RunArgs>),
    /// Show a recording made with `run --save` in the Rerun viewer.
    View(ViewArgs),
    /// Simulate a flight through a mine, or scenes for evaluation, with the true answers.
    Simulate(SimulateArgs),
    /// Explore a simulated mine in closed loop: a vehicle that finds every way by its junctions, and comes home.
    Explore(ExploreArgs),
    /// Compare configurations: how often each is right, where the recordings have the truth (/truth), else where they differ. Each
    /// file is a flight, or a family of scenes, of its own; with --join, all are the parts of one flight.
    Compare(CompareArgs),
    /// Debug a flight at a prompt: go to any scan, see what each stage made, change settings, answer the flight again, compare.
    Debug(DebugArgs),
    /// Show the topics, scans and damage of recordings.
    Info(InfoArgs),
    /// Write a page (HTML) on a flight: counts over time, map, junctions with their walls, notes, times and settings.
    Report(ReportArgs),
    /// Convert a recording of any kind to an MCAP of ROS 2 that other tools read.
    Convert(ConvertArgs),
    /// List, export or compare the contents of recordings made with `run --save`.
    #[command(subcommand)]
    Rrd(RrdCommand),
    /// Write a recording for the Rerun viewer to standard output, as the viewer asks its importers to.
    #[cfg(feature = "rerun")]
    #[command(hide = true)]
    Import(import::ImportArgs),
    /// Print every setting with its value, unit, range and origin. The output is a valid configuration file.
    Config(ConfigArgs),
    /// Print a script that lets a shell complete commands and options.
    #[command(hide = true)]
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// Write pages for `man`, one for each command.
    #[command(hide = true)]
    Man {
        /// Folder for the pages, such as ~/.local/share/man/man1.
        #[arg(value_name = "DIR")]
        folder: PathBuf,
    },
}

/// The command line, with its examples.
pub(crate) fn command() -> clap::Command {
    help::with_examples(Cli::command(), "")
}

impl Command {
    /// Names the file of settings that nobody gave on the command line, before a command that reads it.
    fn say_settings_found(&self) {
        #[cfg(feature = "rerun")]
        if matches!(self, Self::Import(_)) {
            return; // most files that it is called with are not for us
        }
        let reads_none = matches!(
            self,
            Self::View(_)
                | Self::Simulate(_)
                | Self::Rrd(_)
                | Self::Config(_)
                | Self::Completions { .. }
                | Self::Man { .. }
        );
        let Some(found) = found().filter(|_| !reads_none) else { return };
        let path = found.path.display();
        match found.refused() {
            None => say(format_args!("settings of {path}")),
            Some(why) => {
                say(format_args!("note: {path} {why}: its settings are not taken; --config {path} takes them"))
            }
        }
    }

    /// Does the command.
    pub(crate) fn run(self, registry: &Registry, host: &Host<'_>) -> anyhow::Result<Outcome> {
        self.say_settings_found();
        match self {
            Self::Run(args) => run::run(&args, registry, host.robots),
            Self::View(args) => view::view(&args),
            Self::Simulate(args) => simulate::simulate(&args),
            Self::Explore(args) => explore::explore(&args, registry),
            Self::Compare(args) => compare::compare(&args, registry, host.robots),
            Self::Debug(args) => debug::debug(args, registry, host.kinds),
            Self::Info(args) => info::info(&args, registry),
            Self::Report(args) => report::report(&args, registry),
            Self::Convert(args) => convert::convert(&args, registry),
            Self::Rrd(command) => rrd::rrd(&command, registry),
            #[cfg(feature = "rerun")]
            Self::Import(args) => import::import(&args, registry),
            Self::Config(args) => config::print(&args, registry),
            Self::Completions { shell } => shell::completions(shell, command()),
            Self::Man { folder } => shell::man(&folder, command()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_has_no_contradictory_options() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_command_opens_with_examples_that_it_accepts() {
        fn check(of: &clap::Command, path: &str) {
            let lines = help::examples(path).unwrap_or_else(|| panic!("`crosscut {path}` has no examples"));
            for line in lines {
                let line = line.split(" > ").next().unwrap_or_default();
                let parsed = command().try_get_matches_from(line.split(' '));
                assert!(parsed.is_ok(), "{line}: {}", parsed.expect_err("refused"));
                assert!(line.starts_with(format!("crosscut {path}").trim()), "{line} is no example of {path}");
            }
            for subcommand in of.get_subcommands().filter(|command| !command.is_hide_set()) {
                check(subcommand, format!("{path} {}", subcommand.get_name()).trim());
            }
        }
        check(&command(), "");
    }
}
