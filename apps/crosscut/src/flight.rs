//! The flight that a command goes through.

use crosscut_ingest::{ReadOptions, Recording, Sensor};
use crosscut_pipeline::Config;

use crate::cli::FlightArgs;
use crate::exit::UsageError;

/// Opens its recordings, as the sensor's settings of `config` read them.
pub(crate) fn open(args: &FlightArgs, config: &Config) -> anyhow::Result<Recording> {
    if let (Some(from), Some(to)) = (args.from, args.to)
        && from > to
    {
        return Err(UsageError(format!("--from {from} lies after --to {to}")).into());
    }
    let options = ReadOptions { topic: args.topic.clone(), from_s: args.from, to_s: args.to, every: args.every };
    Ok(Recording::open(&args.input, &options, Sensor::new(config.params("ingest")))?)
}
