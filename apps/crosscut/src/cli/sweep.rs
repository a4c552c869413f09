//! The options of `crosscut sweep`.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;
use crosscut_messages::ScanType;

use super::{ConfigArgs, scan_type};

#[derive(Debug, Args)]
pub(crate) struct SweepArgs {
    /// Recordings of any format, or folders of them. Each file is a flight of its own.
    #[arg(required = true)]
    pub(crate) input: Vec<PathBuf>,
    /// Setting with the values to try, such as affinity.sigma_per_m2=0.5,1,1.5 or preset=paper,default. Repeat it to try
    /// every combination.
    #[arg(long, required = true, value_name = "KEY=V1,V2...")]
    pub(crate) grid: Vec<String>,
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
    /// Topic of the scans; may be omitted when there is only one.
    #[arg(long)]
    pub(crate) topic: Option<String>,
    /// Type of the messages on the topic, if the recording does not state it or uses another name.
    #[arg(long = "as", value_name = "TYPE", value_parser = scan_type)]
    pub(crate) read_as: Option<ScanType>,
    /// Folder for sweep.csv, times.csv and the pictures. What an earlier sweep into it has computed with the
    /// same program, settings and recordings is kept, so the same command continues an interrupted sweep.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Number of recordings that are processed at a time. [default: the number of processors]
    #[arg(long, value_name = "N")]
    pub(crate) jobs: Option<NonZeroUsize>,
    /// Show no progress bar and no table.
    #[arg(long)]
    pub(crate) quiet: bool,
}
