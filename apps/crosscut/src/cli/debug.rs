//! The options of `debug`.

use clap::Args;

use super::{ConfigArgs, InputArgs};

#[derive(Debug, Args)]
pub(crate) struct DebugArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
    /// Take and give JSON-RPC 2.0, an object a line, in place of words: the method is the command, its params are the words
    /// after it.
    #[arg(long)]
    pub(crate) json: bool,
}
