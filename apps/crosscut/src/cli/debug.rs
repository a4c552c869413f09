//! The options of `debug` and `replay`.

use std::num::NonZeroU64;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use crosscut_stage::Step;

use super::input::RecordingsArgs;
use super::{ConfigArgs, InputArgs};

#[derive(Debug, Args)]
pub(crate) struct DebugArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,
    #[command(flatten)]
    pub(crate) config: ConfigArgs,
    /// Begin at this revolution, as `seek N` does.
    #[arg(long, value_name = "N", value_parser = super::values::number::<u64>, allow_negative_numbers = true)]
    pub(crate) at: Option<u64>,
    /// Take and give JSON-RPC 2.0, an object a line, in place of words: the method is the command, its params are the words
    /// after it.
    #[arg(long)]
    pub(crate) json: bool,
    /// Show the page of stages in the Rerun viewer: of the present revolution, after every command; beside it what is held.
    #[arg(long)]
    pub(crate) view: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// Recording made with `run --save`; or a flight, which is then read with the settings below.
    #[arg(value_name = "FLIGHT.rrd")]
    pub(crate) input: PathBuf,
    /// The first stage that runs with other settings, or on arrays of another program.
    #[arg(long, value_name = "STAGE", default_value = "affinity", value_parser = stage())]
    pub(crate) from: Step,
    /// Folder of arrays for that stage, a file for each revolution: W-107.npy for spectral, U-107.npy for kmeans,
    /// labels-107.npy for report. Revolutions without a file keep what the stages make.
    #[arg(long, value_name = "DIR")]
    pub(crate) given: Option<PathBuf>,
    /// Setting that differs, of that stage or a later one (`spectral.zero_tolerance=1e-8`); may be repeated.
    #[arg(long, value_name = "SECTION.KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Write the new results: a line of JSON for each revolution; `-` is standard output.
    #[arg(long, value_name = "FILE.jsonl")]
    pub(crate) results: Option<PathBuf>,
    /// Settings to compare with: the preset. [default: default; of a recording (.rrd), the settings that it was made with]
    #[arg(long)]
    pub(crate) preset: Option<String>,
    /// Settings over these: a TOML file.
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) config: Option<PathBuf>,
}

impl ReplayArgs {
    /// All scans of the input.
    pub(crate) fn input(&self) -> InputArgs {
        InputArgs {
            recordings: RecordingsArgs { input: vec![self.input.clone()], read_as: None },
            topic: Vec::new(),
            from: None,
            to: None,
            join: false,
            every: NonZeroU64::MIN,
        }
    }
}

/// The stages that a flight can be replayed from.
fn stages() -> impl Iterator<Item = Step> {
    Step::ALL.into_iter().filter(|step| *step != Step::Ingest)
}

fn stage() -> impl TypedValueParser<Value = Step> {
    let of_name = |name: String| stages().find(|step| step.name() == name).expect("a possible value");
    PossibleValuesParser::new(stages().map(Step::name)).map(of_name)
}
