//! The command line: every command with its options.

pub(crate) mod convert;
pub(crate) mod debug;
pub(crate) mod explore;
pub(crate) mod help;
#[cfg(feature = "rerun")]
pub(crate) mod import;
pub(crate) mod input;
pub(crate) mod record;
pub(crate) mod rrd;
mod values;

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::builder::{PathBufValueParser, TypedValueParser as _};
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;

use crate::config;
use crate::say::say;
use convert::ConvertArgs;
use debug::DebugArgs;
use explore::ExploreArgs;
use input::RecordingsArgs;
pub(crate) use input::{InputArgs, LiveArgs};
use record::{LayoutArg, RecordArgs};
use rrd::RrdCommand;
pub(crate) use values::Drift;
use values::{drift, html_path, map_path, mcap_path, number, positive, results_path};

/// Counts the walls in 2D lidar scans and finds the openings between them: spectral junction detection.
#[derive(Debug, Parser)]
#[command(name = "crosscut", version, max_term_width = 110, after_help = EXIT_CODES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXIT_CODES: &str = "\
Exit codes: 0 done; 1 failed, results up to the failure are saved; 2 wrong usage or configuration; 3 done, but \
something was lost (damaged input, incomplete recording); 130 interrupted, results so far are saved.";

/// The default address of --serve. Only viewers on this machine can connect to it.
const SERVED_AT: &str = "127.0.0.1:9877";

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
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// Write pages for `man`, one for each command.
    Man {
        /// Folder for the pages, such as ~/.local/share/man/man1.
        #[arg(value_name = "DIR")]
        folder: PathBuf,
    },
}

impl ConfigArgs {
    /// The preset, whether it was given or not.
    pub(crate) fn preset(&self) -> &str {
        self.preset.as_deref().unwrap_or("default")
    }
}

impl Command {
    /// Names the file of settings that nobody gave on the command line, before a command that reads it.
    pub(crate) fn say_settings_found(&self) {
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
        if let (false, Some(path)) = (reads_none, config::found()) {
            say(format_args!("settings of {}", path.display()));
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Results, one JSON object per scan; `-` is standard output. FILE.mcap has the scans beside them, and drawings for
    /// Foxglove.
    #[arg(short, long, value_name = "FILE.jsonl|FILE.mcap", value_parser = PathBufValueParser::new().try_map(results_path))]
    pub(crate) out: Option<PathBuf>,
    /// Write the map of the flight, junctions, dead ends and the passages between them: .svg (a drawing), .json, .geojson
    /// (for Nav2) or .g2o (the visits as a pose graph).
    #[arg(long, value_name = "FILE.svg|json|geojson|g2o", value_parser = PathBufValueParser::new().try_map(map_path))]
    pub(crate) map: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
    #[command(flatten)]
    pub(crate) input: InputArgs,
    /// Play at this multiple of the recorded pace (1 = as recorded); pauses of more than 10 s are skipped.
    #[arg(long, value_name = "X", value_parser = positive, allow_negative_numbers = true, conflicts_with = "follow")]
    pub(crate) rate: Option<f64>,
    /// Show no progress bar and no summary.
    #[arg(short, long)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) live: LiveArgs,
    /// To a live robot, send JSON to KEY/results and KEY/map, and a drawing for RViz and Foxglove to the topic KEY/markers.
    #[arg(long, value_name = "KEY")]
    pub(crate) publish: Option<String>,
    #[command(flatten)]
    pub(crate) record: RecordArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
    /// The page. It needs no other file and no network.
    #[arg(short, long, value_name = "FILE.html", value_parser = PathBufValueParser::new().try_map(html_path))]
    pub(crate) out: PathBuf,
    /// Show no progress bar and no summary.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ViewArgs {
    /// Recording made with `run --save`; its further parts (FLIGHT-2.rrd...) are shown as well.
    #[arg(required = true, value_name = "FLIGHT.rrd")]
    pub(crate) flight: Vec<PathBuf>,
    /// Page that the viewer opens with. [default: the page of --beside if that is given, else stages]
    #[arg(long, value_enum)]
    pub(crate) layout: Option<LayoutArg>,
    /// Revolution to open at. [default: the last]
    #[arg(long, value_name = "REVOLUTION", conflicts_with = "serve", value_parser = number::<u64>, allow_negative_numbers = true)]
    pub(crate) at: Option<u64>,
    /// Second recording, shown side by side with the first; or MCAP recordings of the flight, to show their point clouds,
    /// cameras and transforms as well.
    #[arg(long, value_name = "OTHER.rrd|FLIGHT.mcap")]
    pub(crate) beside: Vec<PathBuf>,
    /// Let viewers connect until Ctrl-C instead of opening one. Port 0 selects a free port.
    #[arg(long, value_name = "ADDR:PORT", num_args = 0..=1, require_equals = true, default_missing_value = SERVED_AT)]
    pub(crate) serve: Option<SocketAddr>,
}

/// The heading of what configures.
const CONFIGURATION: &str = "Configuration";

#[derive(Debug, Args)]
#[command(next_help_heading = CONFIGURATION)]
pub(crate) struct ConfigArgs {
    /// Settings to start from: paper, default, or one of the baselines clear_width, threshold, breakpoint.
    /// [default: default]
    #[arg(long)]
    pub(crate) preset: Option<String>,
    /// Settings that override the preset and crosscut.toml: a TOML file, or a recording made with `run --save` to use its
    /// settings. (crosscut.toml is looked for in this folder and those above it, unless $CROSSCUT_CONFIG names a file.)
    #[arg(long, value_name = "FILE.toml|FLIGHT.rrd")]
    pub(crate) config: Option<PathBuf>,
    /// Single setting that overrides the files, such as vehicle.width_m=0.8. May be repeated.
    #[arg(long, value_name = "SECTION.KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

#[derive(Debug, Args)]
pub(crate) struct SimulateArgs {
    /// Scenario of the flight; --list shows them.
    #[arg(conflicts_with = "suite")]
    pub(crate) scenario: Option<String>,
    /// Plan of a mine to fly through, all of it: {"nodes":[{"id","x_m","y_m"}],"edges":[{"from","to","width_m","via_m"}]}.
    /// `"start":{"node","towards"}` is where to start and which node to face, else the first dead end.
    #[arg(long, value_name = "PLAN.json", conflicts_with_all = ["scenario", "suite"])]
    pub(crate) plan: Option<PathBuf>,
    /// Family of scenes for evaluation, instead of a flight; `all` for every family.
    #[arg(long, value_name = "NAME")]
    pub(crate) suite: Option<String>,
    /// Scenes of the suite: parameters are chosen on dev, results are reported on report.
    #[arg(long, value_enum, default_value = "dev", requires = "suite", conflicts_with = "scenario")]
    pub(crate) split: SplitArg,
    /// Output: FLIGHT.mcap for a scenario, a folder for suites.
    #[arg(short, long, value_name = "PATH", value_parser = PathBufValueParser::new().try_map(mcap_path))]
    pub(crate) out: Option<PathBuf>,
    /// Seed of the random numbers; the same seed gives the same bytes.
    #[arg(long, default_value_t = 1, conflicts_with = "suite", value_parser = number::<u64>, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// Drift of the odometry of a flight, as a share of its way; its heading drifts by a tenth of it in rad per metre. `none`:
    /// a flight without odometry.
    #[arg(long, value_name = "SHARE|none", value_parser = drift, allow_negative_numbers = true, conflicts_with = "suite")]
    pub(crate) drift: Option<Drift>,
    /// List the scenarios and suites.
    #[arg(long)]
    pub(crate) list: bool,
    /// Show no progress bar and no summary.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum SplitArg {
    /// To choose parameters on.
    Dev,
    /// To report on.
    Report,
}

#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    /// Configuration, in parts that commas separate: a preset, a file of settings over it (FILE.toml, or FLIGHT.rrd made with
    /// `run --save`), single settings over both. `NAME=` before them names it in tables
    /// (`mine=paper,affinity.sigma_per_m2=3`). Repeat it: the others are compared with the first. [default: default]
    #[arg(long, help_heading = CONFIGURATION, value_name = "[NAME=]PRESET|FILE.toml|SETTING[,...]")]
    pub(crate) with: Vec<String>,
    /// Setting with the values to try in every configuration, such as affinity.sigma_per_m2=0.5,1,1.5. Repeat it to try every
    /// combination.
    #[arg(long, help_heading = CONFIGURATION, value_name = "KEY=V1,V2...")]
    pub(crate) grid: Vec<String>,
    /// Single setting that overrides every configuration. May be repeated.
    #[arg(long, help_heading = CONFIGURATION, value_name = "SECTION.KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Show all tables: counts, labels, openings and confidence, every stretch where walls differ, and a command for each
    /// revolution that is mended or broken.
    #[arg(long)]
    pub(crate) details: bool,
    /// Write a row for each flight and configuration; `-` is standard output.
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) csv: Option<PathBuf>,
    /// Write all figures, verdicts and stretches as JSON; `-` is standard output.
    #[arg(long, value_name = "FILE.json")]
    pub(crate) json: Option<PathBuf>,
    /// Show no progress bar and no tables.
    #[arg(short, long)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) live: LiveArgs,
}

#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// Explain the notes with this code instead (N082), or `all` of them.
    #[arg(long, value_name = "CODE", exclusive = true)]
    pub(crate) note: Option<String>,
    #[command(flatten)]
    pub(crate) recordings: RecordingsArgs,
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
    /// Write all that is found as JSON instead, one object per recording; `-` is standard output.
    #[arg(long, value_name = "FILE.json")]
    pub(crate) json: Option<PathBuf>,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_has_no_contradictory_options() {
        super::Cli::command().debug_assert();
    }
}
