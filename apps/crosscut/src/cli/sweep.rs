//! The options of `crosscut sweep`.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;

use super::values::count;
use super::{ConfigArgs, InputArgs};

#[derive(Debug, Args)]
pub(crate) struct SweepArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    /// Setting with the values to try, such as affinity.sigma_per_m2=0.5,1,1.5 or preset=paper,default. Repeat it to try
    /// every combination.
    #[arg(long, required = true, value_name = "KEY=V1,V2...")]
    pub(crate) grid: Vec<String>,
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
    /// Folder for sweep.csv, times.csv, verdicts.json and the pictures. What an earlier sweep into it has computed with the
    /// same program, settings and recordings is kept, so the same command continues an interrupted sweep.
    #[arg(short, long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Number of recordings that are processed at a time. [default: the number of processors]
    #[arg(long, value_name = "N", value_parser = count::<NonZeroUsize>, allow_negative_numbers = true)]
    pub(crate) jobs: Option<NonZeroUsize>,
    /// Append a line for each combination to this history: inputs, settings, build and figures. `crosscut runs` lists it.
    #[arg(long, value_name = "RUNS.jsonl")]
    pub(crate) log: Option<PathBuf>,
    /// Show no progress bar and no table.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}
