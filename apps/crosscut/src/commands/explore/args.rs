//! The options of `crosscut explore`.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser as _};

use crate::input::ConfigArgs;
use crate::output::record::rrd_path;

#[derive(Debug, Args)]
pub(crate) struct ExploreArgs {
    /// World to explore, or `all`; --list shows them.
    #[arg(value_name = "MISSION")]
    pub(super) mission: Option<String>,
    /// Plan of a mine to explore, all of it: {"nodes":[{"id","x_m","y_m"}],"edges":[{"from","to","width_m","via_m"}]}.
    /// `"start":{"node","towards"}` is where to start and which node to face, else the first dead end.
    #[arg(long, value_name = "PLAN.json", conflicts_with = "mission")]
    pub(super) plan: Option<PathBuf>,
    /// How the ways are chosen; --list shows the planners.
    #[arg(long, value_name = "NAME", default_value = "nearest_frontier")]
    pub(super) planner: String,
    /// Seed of the world, of the vehicle and of its lidar; the same seed gives the same mission. FIRST..LAST flies a mission with
    /// each of them, and prints a table.
    #[arg(long, value_name = "N|FIRST..LAST", default_value = "1", value_parser = seeds, allow_negative_numbers = true)]
    pub(super) seed: RangeInclusive<u64>,
    /// Write the outcome: ways, ways_visited, home, crashes, way_m, offline_m, revolutions, the map and more; a list of
    /// outcomes without maps for several missions. `-` is standard output.
    #[arg(long, value_name = "FILE.json")]
    pub(super) json: Option<PathBuf>,
    /// Save a recording of the mission for the Rerun viewer: vehicle, scan, openings, decisions, the map as it grows, and
    /// all stages of each revolution.
    #[arg(long, value_name = "MISSION.rrd", value_parser = PathBufValueParser::new().try_map(rrd_path))]
    pub(super) save: Option<PathBuf>,
    /// Record what the vehicle senses, with the truth, as a flight that every command reads. It is complete up to the last
    /// second at any time.
    #[arg(long, value_name = "FLIGHT.mcap")]
    pub(super) journal: Option<PathBuf>,
    /// Resume a killed mission from its --journal: give the same mission, seed, planner and settings as then.
    #[arg(long, value_name = "FLIGHT.mcap")]
    pub(super) resume: Option<PathBuf>,
    #[command(flatten)]
    pub(super) config: ConfigArgs,
    /// List the worlds and the planners.
    #[arg(long)]
    pub(super) list: bool,
    /// Show no progress bar and no summary.
    #[arg(short, long)]
    pub(super) quiet: bool,
}

/// More missions than anybody waits for.
const MOST_SEEDS: u64 = 1_000_000;

/// A seed, or all from one to another: `7`, `201..210`.
fn seeds(text: &str) -> Result<RangeInclusive<u64>, String> {
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    match (first.parse(), last.parse()) {
        (Ok(first), Ok(last)) if first <= last && last - first < MOST_SEEDS => Ok(first..=last),
        _ => Err(format!(
            "a whole number from 0 on, or FIRST..LAST of at most {MOST_SEEDS} seeds, the first not above the last"
        )),
    }
}
