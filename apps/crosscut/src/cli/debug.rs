//! The options of `debug`.

use clap::Args;

use super::{ConfigArgs, InputArgs};

#[derive(Debug, Args)]
pub(crate) struct DebugArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
    /// Begin at this revolution, as `seek N` does.
    #[arg(long, value_name = "REVOLUTION", value_parser = super::values::number::<u64>, allow_negative_numbers = true)]
    pub(crate) at: Option<u64>,
    /// Show the page of stages in the Rerun viewer: of the present revolution, after every command; beside it what is held.
    #[arg(long)]
    pub(crate) view: bool,
}
