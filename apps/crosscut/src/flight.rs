//! The flight that a command reads.

use crosscut_ingest::{CsvGeometry, ReadOptions, Recording, Sensor};
use crosscut_pipeline::Config;

use crate::cli::FlightArgs;
use crate::exit::UsageError;

/// Opens the recordings of a flight, read with the settings of the sensor in `config`.
pub(crate) fn open(args: &FlightArgs, config: &Config) -> anyhow::Result<Recording> {
    refuse_empty_span(args.from, args.to)?;
    let csv = CsvGeometry::new(config.params("csv"));
    let options = ReadOptions {
        topic: args.topic.clone(),
        read_as: args.read_as,
        from_s: args.from,
        to_s: args.to,
        every: args.every,
        csv,
    };
    Ok(Recording::open(&args.input, &options, Sensor::new(config.params("ingest")))?)
}

/// Refuses a span of time that ends before it begins.
pub(crate) fn refuse_empty_span(from_s: Option<f64>, to_s: Option<f64>) -> Result<(), UsageError> {
    match (from_s, to_s) {
        (Some(from), Some(to)) if from > to => Err(UsageError(format!("--from {from} is after --to {to}"))),
        _ => Ok(()),
    }
}
