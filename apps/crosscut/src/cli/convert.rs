//! The options of `crosscut convert`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser as _};

use super::values::has_extension;
use super::{CONFIGURATION, InputArgs};

#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    /// MCAP file for the scans (/scan) or clouds (/points), odometry (/odom) and transforms (/tf).
    #[arg(short, long, value_name = "FLIGHT.mcap", value_parser = PathBufValueParser::new().try_map(converted_path))]
    pub(crate) out: PathBuf,
    /// File of settings, of which those of the section csv and ingest.echo count.
    #[arg(long, value_name = "FILE.toml|FLIGHT.rrd", help_heading = CONFIGURATION)]
    pub(crate) config: Option<PathBuf>,
    /// Single setting that overrides the file: ingest.echo=VALUE or csv.KEY=VALUE. May be repeated.
    #[arg(long, value_name = "SECTION.KEY=VALUE", value_parser = setting_of_conversion, help_heading = CONFIGURATION)]
    pub(crate) set: Vec<String>,
    /// Show no progress and no summary.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// Endings of recordings that are no MCAP.
const OTHER_FORMATS: [&str; 7] = ["rrd", "bag", "db3", "clf", "csv", "pcd", "ply"];

fn converted_path(path: PathBuf) -> Result<PathBuf, &'static str> {
    if OTHER_FORMATS.iter().any(|format| has_extension(&path, format)) {
        return Err("convert writes MCAP: FLIGHT.mcap");
    }
    Ok(path)
}

fn setting_of_conversion(setting: &str) -> Result<String, &'static str> {
    let key = setting.split('=').next().unwrap_or_default().trim();
    if key.starts_with("csv.") || key == "ingest.echo" {
        Ok(setting.to_owned())
    } else {
        Err("only csv.KEY and ingest.echo have an effect: scans are converted as they were recorded")
    }
}
