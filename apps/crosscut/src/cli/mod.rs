//! What can be typed.

pub(crate) mod record;

use std::net::SocketAddr;
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser as _};
use clap::{Args, Parser, Subcommand, ValueEnum};
use crosscut_messages::ScanType;

use record::{LayoutArg, RecordArgs};

/// How many walls, and so how many ways on, are here: spectral junction detection on 2D lidar revolutions.
#[derive(Debug, Parser)]
#[command(name = "crosscut", version, max_term_width = 110, after_help = EXIT_CODES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

const EXIT_CODES: &str = "\
Exit codes: 0 done; 1 failed, what came before is saved; 2 wrong usage or configuration; 3 done, but something was \
lost (damaged input, incomplete recording); 130 interrupted, what was made is saved.";

/// Where viewers connect if no address is given: on this machine alone.
const SERVED_AT: &str = "127.0.0.1:9877";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Count the walls of every revolution in a recorded flight.
    Run(RunArgs),
    /// Show what `run --save` recorded.
    View(ViewArgs),
    /// Make a flight through a mine whose truth is known.
    Simulate(SimulateArgs),
    /// Compare the results of one configuration or several with the truth in recordings.
    Evaluate(EvaluateArgs),
    /// Show where two configurations or more answer differently, stage by stage or setting by setting; needs no truth.
    Compare(CompareArgs),
    /// Repeat the paper's evaluation on scenes of its kind: figures, and the zero tolerance against what is right.
    Paper(PaperArgs),
    /// Show what is in a recording.
    Info(InfoArgs),
    /// Write a recording of any kind as an MCAP of ROS 2 that other tools read.
    Convert(ConvertArgs),
    /// List, export or compare what is in recordings made with --save.
    #[command(subcommand)]
    Rrd(RrdCommand),
    /// Show every setting with its value, unit, range and where it comes from. The output is a configuration file.
    Config(ConfigArgs),
}

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) flight: FlightArgs,
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
    /// Write one JSON object per scan message; `-` is standard output.
    #[arg(long, value_name = "FILE.jsonl")]
    pub(crate) results: Option<PathBuf>,
    /// Draw count, margin and confidence over time, and list beside it, as FILE.md, the revolutions whose count is not
    /// that of most around them, with what is different there.
    #[arg(long, value_name = "FILE.svg", value_parser = PathBufValueParser::new().try_map(an_svg))]
    pub(crate) over_time: Option<PathBuf>,
    /// No progress, no summary.
    #[arg(long)]
    pub(crate) quiet: bool,
    /// Play at this multiple of the sensor's pace (1 = as it was recorded); pauses of more than 10 s are left out.
    #[arg(long, value_name = "X", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) rate: Option<f64>,
    #[command(flatten)]
    pub(crate) record: RecordArgs,
}

/// A recorded flight, or a part of it.
#[derive(Debug, Args)]
pub(crate) struct FlightArgs {
    /// Recordings (MCAP, ROS 1 bag, rosbag2 .db3, CARMEN log, CSV), or folders of them: the parts of one flight, in this
    /// order; `-` is standard input.
    #[arg(required = true)]
    pub(crate) input: Vec<PathBuf>,
    /// Scan topic; found by itself when there is only one.
    #[arg(long)]
    pub(crate) topic: Option<String>,
    /// What the messages of that topic are, where the recording does not say or uses another name: LaserScan,
    /// MultiEchoLaserScan or PointCloud2; in json or protobuf those of Foxglove.
    #[arg(long = "as", value_name = "TYPE", value_parser = scan_type)]
    pub(crate) read_as: Option<ScanType>,
    /// Start this many seconds after the first scan. When no scan is left the command fails (exit code 1).
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) from: Option<f64>,
    /// Stop this many seconds after the first scan.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) to: Option<f64>,
    /// Take every N-th scan.
    #[arg(long, value_name = "N", default_value = "1", allow_negative_numbers = true)]
    pub(crate) every: NonZeroU64,
}

#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// Recordings, or folders of them: the parts of one flight, in this order.
    #[arg(required = true)]
    pub(crate) input: Vec<PathBuf>,
    /// Where to write scans (/scan), odometry (/odom) and transforms (/tf).
    #[arg(long, value_name = "FLIGHT.mcap", value_parser = PathBufValueParser::new().try_map(no_rrd))]
    pub(crate) out: PathBuf,
    /// Scan topic; found by itself when there is only one.
    #[arg(long)]
    pub(crate) topic: Option<String>,
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
}

#[derive(Debug, Args)]
pub(crate) struct ViewArgs {
    /// The recording that `run --save` made; its other parts (FLIGHT-2.rrd...) come with it.
    #[arg(required = true, value_name = "FLIGHT.rrd")]
    pub(crate) flight: Vec<PathBuf>,
    /// Which page the viewer opens with. [default: with --beside or --with their own page, else the one that the
    /// recording was made for]
    #[arg(long, value_enum)]
    pub(crate) layout: Option<LayoutArg>,
    /// Another recording, side by side with the first.
    #[arg(long, value_name = "OTHER.rrd")]
    pub(crate) beside: Option<PathBuf>,
    /// The flight's MCAP recording, to see its point clouds, cameras and transforms together with ours. May be given
    /// again.
    #[arg(long, value_name = "FLIGHT.mcap", conflicts_with = "beside")]
    pub(crate) with: Vec<PathBuf>,
    /// Do not open the viewer: let viewers connect, until Ctrl-C. Port 0 takes a free one.
    #[arg(long, value_name = "ADDR:PORT", num_args = 0..=1, require_equals = true, default_missing_value = SERVED_AT)]
    pub(crate) serve: Option<SocketAddr>,
}

#[derive(Debug, Args)]
pub(crate) struct ConfigArgs {
    /// Settings to start from: paper, default, or a baseline: threshold, breakpoint, dbscan.
    #[arg(long, default_value = "default")]
    pub(crate) preset: String,
    /// A file of settings (TOML), over the preset; or a recording made with --save, for the settings it was made with.
    #[arg(long, value_name = "FILE.toml|FLIGHT.rrd")]
    pub(crate) config: Option<PathBuf>,
    /// A single setting, over the file: vehicle.width_m=0.8. May be given again.
    #[arg(long, value_name = "SECTION.KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

#[derive(Debug, Args)]
pub(crate) struct SimulateArgs {
    /// The scenario, one flight; --list shows them.
    #[arg(conflicts_with = "suite")]
    pub(crate) scenario: Option<String>,
    /// A family of scenes for evaluation instead of a flight; `all` for every family.
    #[arg(long, value_name = "NAME")]
    pub(crate) suite: Option<String>,
    /// Which scenes of the suite: choose parameters on dev, report on report.
    #[arg(long, value_enum, default_value = "dev", requires = "suite", conflicts_with = "scenario")]
    pub(crate) split: SplitArg,
    /// Where to write: FLIGHT.mcap for a scenario, a folder for suites.
    #[arg(long, value_name = "PATH", value_parser = PathBufValueParser::new().try_map(no_rrd))]
    pub(crate) out: Option<PathBuf>,
    /// The same seed gives the same bytes.
    #[arg(long, default_value_t = 1, conflicts_with = "suite", allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// Show the scenarios and suites.
    #[arg(long)]
    pub(crate) list: bool,
    /// No progress, and no word of what was written.
    #[arg(long)]
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
pub(crate) struct EvaluateArgs {
    /// MCAP recordings with /truth, or folders of them; each file is a family of scenes, named after it;
    /// no two of one name.
    #[arg(required = true)]
    pub(crate) input: Vec<PathBuf>,
    /// A configuration to evaluate: a preset, or a file of settings (or a recording made with --save) over the preset
    /// `default` or over another (`paper,FILE.toml`), and single settings over that: `paper,affinity.sigma_per_m2=3`.
    /// May be given again, to see them side by side.
    #[arg(long, value_name = "PRESET|FILE.toml|PRESET,FILE.toml[,SETTING]...")]
    pub(crate) with: Vec<String>,
    /// A single setting, over every configuration. May be given again.
    #[arg(long, value_name = "SECTION.KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Scan topic; found by itself when there is only one.
    #[arg(long)]
    pub(crate) topic: Option<String>,
    /// What the messages of that topic are, where the recording does not say or uses another name: LaserScan,
    /// MultiEchoLaserScan or PointCloud2; in json or protobuf those of Foxglove.
    #[arg(long = "as", value_name = "TYPE", value_parser = scan_type)]
    pub(crate) read_as: Option<ScanType>,
    /// Show counts, labels, openings and confidence as well.
    #[arg(long)]
    pub(crate) details: bool,
    /// Write every figure as JSON; `-` is standard output.
    #[arg(long, value_name = "FILE.json")]
    pub(crate) json: Option<PathBuf>,
    /// Write the tables as Markdown; `-` is standard output.
    #[arg(long, value_name = "FILE.md")]
    pub(crate) markdown: Option<PathBuf>,
    /// Draw the first scenes of each recording that are answered wrong, truth beside answer, and list all of them:
    /// DIR/RECORDING-CONFIGURATION.svg and .csv.
    #[arg(long, value_name = "DIR")]
    pub(crate) draw_wrong: Option<PathBuf>,
    /// No progress, no tables on the terminal.
    #[arg(long)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub(crate) flight: FlightArgs,
    /// A configuration: a preset, or a file of settings (or a recording made with --save) over the preset
    /// `default` or over another (`paper,FILE.toml`), and single settings over that: `paper,affinity.sigma_per_m2=3`.
    /// Given twice or more; the first is what the others are compared with.
    #[arg(long, required = true, value_name = "PRESET|FILE.toml|PRESET,FILE.toml[,SETTING]...")]
    pub(crate) with: Vec<String>,
    /// A single setting, over every configuration. May be given again.
    #[arg(long, value_name = "SECTION.KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Show every stretch of the flight where the walls differ, not the longest ones only.
    #[arg(long)]
    pub(crate) all: bool,
    /// Write every figure and every stretch as JSON; `-` is standard output.
    #[arg(long, value_name = "FILE.json")]
    pub(crate) json: Option<PathBuf>,
    /// No progress, no tables on the terminal.
    #[arg(long)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct PaperArgs {
    /// The folder to write paper.md and its figures into.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// How many scenes of each family the table of tolerances counts.
    #[arg(long, value_name = "N", default_value_t = crosscut_simulator::SCENES, value_parser = one_or_more)]
    pub(crate) scenes: usize,
    /// No progress.
    #[arg(long)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// MCAP recordings, or folders of them.
    #[arg(required = true)]
    pub(crate) input: Vec<PathBuf>,
    /// What the messages of topics without a schema are, such as LaserScan.
    #[arg(long = "as", value_name = "TYPE", value_parser = scan_type)]
    pub(crate) read_as: Option<ScanType>,
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
}

#[derive(Debug, Subcommand)]
pub(crate) enum RrdCommand {
    /// Show entities, components, revolutions and sizes of a recording.
    Ls(RrdLsArgs),
    /// Write values of an entity to a file: arrays for NumPy, CSV, Parquet, or JSON lines.
    Get(RrdGetArgs),
    /// Compare two recordings row by row: which revolution and step differ first. Exit codes as of diff(1): 0 the same,
    /// 1 different, 2 trouble; 3 the same as far as a damaged recording goes.
    Diff(RrdDiffArgs),
}

#[derive(Debug, Args)]
pub(crate) struct RrdLsArgs {
    /// A recording.
    #[arg(value_name = "FLIGHT.rrd")]
    pub(crate) recording: PathBuf,
    /// Show every component, also those that say how it is drawn.
    #[arg(long)]
    pub(crate) components: bool,
    /// Show the configuration that it was made with as well.
    #[arg(long)]
    pub(crate) config: bool,
}

#[derive(Debug, Args)]
pub(crate) struct RrdGetArgs {
    /// A recording.
    #[arg(value_name = "FLIGHT.rrd")]
    pub(crate) recording: PathBuf,
    /// What to take, as `rrd ls` names it: /spectral/eigenvalues; /affinity/W is a picture unless made anew with --exact.
    pub(crate) entity: String,
    /// Which component of it; the one with the numbers if not given.
    #[arg(long, value_name = "NAME", conflicts_with = "exact")]
    pub(crate) component: Option<String>,
    /// One revolution, by its number; all if not given.
    #[arg(long, value_name = "N", conflicts_with_all = ["from", "to"], allow_negative_numbers = true)]
    pub(crate) revolution: Option<i64>,
    /// From this many seconds after the first revolution recorded.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) from: Option<f64>,
    /// To this many seconds after the first revolution recorded.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub(crate) to: Option<f64>,
    /// Recompute W, L, U and what follows from them in full precision, from the recorded ranges and configuration.
    #[arg(long)]
    pub(crate) exact: bool,
    /// Where to write: .npy, .csv, .parquet or .jsonl; words also as they are, as .md or with `-` to standard output.
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct RrdDiffArgs {
    /// A recording.
    #[arg(value_name = "A.rrd")]
    pub(crate) first: PathBuf,
    /// Another recording of the same flight.
    #[arg(value_name = "B.rrd")]
    pub(crate) second: PathBuf,
    /// Numbers that differ by this much at most are the same.
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = tolerance, allow_negative_numbers = true)]
    pub(crate) tolerance: f64,
}

fn one_or_more(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|count| *count > 0).ok_or_else(|| "a whole number, 1 or more".to_owned())
}

fn seconds(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|s: &f64| s.is_finite() && *s >= 0.0).ok_or_else(|| "seconds, 0 or more".to_owned())
}

fn an_svg(path: PathBuf) -> Result<PathBuf, &'static str> {
    if ends_in(&path, "svg") { Ok(path) } else { Err("pictures are written as SVG: FILE.svg") }
}

fn no_rrd(path: PathBuf) -> Result<PathBuf, &'static str> {
    if ends_in(&path, "rrd") {
        return Err("what is written is an MCAP recording, none for the Rerun viewer: FLIGHT.mcap");
    }
    Ok(path)
}

fn ends_in(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|of_path| of_path.eq_ignore_ascii_case(ending))
}

fn tolerance(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| *x >= 0.0).ok_or_else(|| "a number, 0 or more".to_owned())
}

fn scan_type(name: &str) -> Result<ScanType, String> {
    let names: Vec<_> = ScanType::ALL.into_iter().map(ScanType::name).collect();
    ScanType::of_name(name).ok_or_else(|| format!("one of {}", names.join(", ")))
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0).ok_or_else(|| "a number above 0".to_owned())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_free_of_contradictions() {
        super::Cli::command().debug_assert();
    }
}
