//! The options of `runs`.

use std::path::PathBuf;

use clap::Args;

#[derive(Debug, Args)]
pub(crate) struct RunsArgs {
    /// History that `run --log`, `evaluate --log` and `sweep --log` wrote.
    #[arg(value_name = "RUNS.jsonl")]
    pub(crate) log: PathBuf,
    /// List only runs that contain this text: a command, a path, a setting, a build. May be repeated; all must hold.
    #[arg(long = "where", value_name = "TEXT")]
    pub(crate) contains: Vec<String>,
    /// Compare two runs by their numbers in the list: settings and figures that differ.
    #[arg(long, num_args = 2, value_names = ["A", "B"], value_parser = super::values::number::<usize>, allow_negative_numbers = true)]
    pub(crate) diff: Option<Vec<usize>>,
}
